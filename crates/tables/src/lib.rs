//! Named numeric columns of long series, read and written in batches of bounded size: CSV, NDJSON and
//! Parquet.
//!
//! A table is a list of columns with distinct names and as many numbers in each. A missing number (an empty
//! field, `null`, `nan`) is [`f64::NAN`]; an infinite one is refused, read or written. A [`Reader`] yields a
//! table from its first row to its last, and the same batches on any number of threads. It reads and parses
//! ahead of its caller, on threads of its own, and holds no more than a few batches. A [`Writer`] takes a
//! table in batches of any size. What is written is read back bit by bit, negative zero included.
//!
//! - CSV: a line of names, perhaps after comments (`#`), then a line a row, cut at commas. A field may stand
//!   in quotes, but does not go over the end of its line. A value that is not wanted may be any text.
//! - NDJSON: one JSON object a line, with a number or null for each key. The columns are the keys of the
//!   first line where none are named. A key that is absent is a missing value. `NaN`, which Python writes, is
//!   one as well.
//! - Parquet: columns of type FLOAT, DOUBLE, INT32 and INT64, at the top of the schema. Integers beyond ±2⁵³
//!   are refused. A TIMESTAMP is read as seconds since 1970-01-01T00:00:00, to a quarter of a microsecond.
//!
//! Names and sizes are limited: [`COLUMN_LIMIT`], [`LINE_LIMIT`].

mod beside;
mod content;
mod error;
pub mod files;
mod format;
mod read;
mod write;

pub use beside::beside;
pub use content::Content;
pub use error::{Error, Place, fault, listed};
pub use format::Format;
pub use read::{BATCH_ROWS, Batch, ColumnKind, Reader, parquet_columns};
pub use write::Writer;

/// A table with more columns is refused.
pub const COLUMN_LIMIT: usize = 10_000;
/// A text file with a longer line (in bytes, 16 MiB) is refused.
pub const LINE_LIMIT: usize = 1 << 24;
