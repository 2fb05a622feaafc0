use ::parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use ::parquet::data_type::DataType;
use ::parquet::errors::ParquetError;
use ::parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use ::parquet::file::serialized_reader::SerializedPageReader;
use ::parquet::schema::types::ColumnDescPtr;
use rayon::prelude::*;
use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::Once;

use super::ahead::{ahead, pool};
use super::reader::{Batch, Reader, rows_per_batch};
use super::wanted::{check_wish, select};
use crate::{Error, Place, fault};

mod shared;

use shared::Shared;
pub use shared::Source;

/// Batches that wait for the caller.
const WAITING: usize = 2;
/// The largest integer of which no neighbour is the same in double precision.
const EXACT: u64 = 1 << 53;

/// Reads the schema, and the columns ahead.
pub fn open(
    source: impl Source + 'static,
    source_name: String,
    wanted: Option<&[&str]>,
) -> Result<Reader, Error> {
    check_wish(&source_name, wanted)?;
    let failed = |source| Error::file(&source_name, "read", source);
    let file = Arc::new(Shared::new(source).map_err(failed)?);
    let metadata = guarded(&source_name, || ParquetMetaDataReader::new().parse_and_finish(&*file))?;
    let schema = metadata.file_metadata().schema_descr();
    let names: Vec<String> = schema.columns().iter().map(|column| column.path().string()).collect();
    let all: Vec<_> = names.iter().map(String::as_str).collect();
    let wanted = wanted.unwrap_or(&all);
    let metadata = Arc::new(metadata);
    let columns = select(&source_name, &names, Place::Whole, wanted)?
        .into_iter()
        .map(|place| {
            let kind = metadata.file_metadata().schema_descr().column(place);
            check_kind(&source_name, &kind)?;
            let (file, metadata) = (file.clone(), metadata.clone());
            Ok(Column { place, kind, file, metadata, group: 0, decoder: None })
        })
        .collect::<Result<Vec<_>, Error>>()?;
    let rows = rows_of(&source_name, &metadata)?;
    let pool = pool(columns.len()).map_err(failed)?;
    let columns_read: Vec<String> = wanted.iter().map(|name| name.to_string()).collect();
    let batches = Batches { columns, rows, first_row: 0, pool, source_name: source_name.clone() };
    let batches = ahead(WAITING, batches).map_err(failed)?.into_iter();
    Ok(Reader { columns: columns_read, batches: Box::new(batches), failed: false })
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnKind {
    /// Numbers.
    Number,
    /// Moments (TIMESTAMP), which are read as seconds since 1970-01-01T00:00:00.
    Time,
    /// What is not read: text, lists, …
    Other,
}

/// Names of a Parquet file's columns, and what they hold; `source_name` stands for it in errors.
///
/// # Errors
///
/// [`Error::File`] where it cannot be read, [`Error::Request`] where it is no Parquet file.
pub fn columns(source: impl Source + 'static, source_name: &str) -> Result<Vec<(String, ColumnKind)>, Error> {
    let file = Shared::new(source).map_err(|source| Error::file(source_name, "read", source))?;
    let metadata = guarded(source_name, || ParquetMetaDataReader::new().parse_and_finish(&file))?;
    let kinds = metadata.file_metadata().schema_descr().columns().iter().map(|kind| {
        let holds = match (check_kind(source_name, kind), ticks_per_second(kind)) {
            (Err(_), _) => ColumnKind::Other,
            (Ok(()), Some(_)) => ColumnKind::Time,
            (Ok(()), None) => ColumnKind::Number,
        };
        (kind.path().string(), holds)
    });
    Ok(kinds.collect())
}

/// Of a column of moments, what one second is; None for other columns.
fn ticks_per_second(kind: &ColumnDescPtr) -> Option<i64> {
    match (kind.physical_type(), kind.logical_type_ref(), kind.converted_type()) {
        (Type::INT64, Some(LogicalType::Timestamp(stamp)), _) => Some(match stamp.unit {
            TimeUnit::MILLIS => 1000,
            TimeUnit::MICROS => 1_000_000,
            TimeUnit::NANOS => 1_000_000_000,
        }),
        (Type::INT64, None, ConvertedType::TIMESTAMP_MILLIS) => Some(1000),
        (Type::INT64, None, ConvertedType::TIMESTAMP_MICROS) => Some(1_000_000),
        _ => None,
    }
}

/// Rows of all row groups.
fn rows_of(source_name: &str, metadata: &ParquetMetaData) -> Result<u64, Error> {
    let rows = metadata
        .row_groups()
        .iter()
        .try_fold(0_u64, |sum, group| sum.checked_add(u64::try_from(group.num_rows()).ok()?));
    rows.ok_or_else(|| {
        fault(source_name, Place::Whole, "a number of rows that cannot be", "a whole Parquet file")
    })
}

/// Refuses what is no column of numbers.
fn check_kind(source_name: &str, kind: &ColumnDescPtr) -> Result<(), Error> {
    use ConvertedType::{DATE, DECIMAL, TIME_MICROS, TIME_MILLIS};
    let stored = kind.physical_type();
    let numbers = matches!(stored, Type::FLOAT | Type::DOUBLE | Type::INT32 | Type::INT64);
    let plain = ticks_per_second(kind).is_some()
        || match (kind.logical_type_ref(), kind.converted_type()) {
            (Some(LogicalType::Integer(_)), _) => true,
            (Some(_), _) => false,
            (None, DECIMAL | DATE | TIME_MILLIS | TIME_MICROS) => false,
            (None, _) => true,
        };
    let flat = kind.path().parts().len() == 1 && kind.max_rep_level() == 0;
    let found = match (flat, numbers, plain) {
        (true, true, true) => return Ok(()),
        (false, ..) => "a column within another".into(),
        (_, false, _) => format!("values of type {stored}"),
        (.., false) => match kind.logical_type_ref() {
            Some(logical) => format!("values that mean {logical:?}"),
            None => format!("values that mean {}", kind.converted_type()),
        },
    };
    let expected = "a column of DOUBLE, FLOAT, INT64 or INT32 that are plain numbers; convert it, or name the columns wanted";
    Err(fault(source_name, Place::Column(kind.path().string()), found, expected))
}

/// Does what the decoder does; its errors, and the panics that a damaged file can bring it to, become ours.
fn guarded<T>(source_name: &str, decode: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, Error> {
    let why = match silent(|| catch_unwind(AssertUnwindSafe(decode))) {
        Ok(Ok(decoded)) => return Ok(decoded),
        Ok(Err(error)) => error.to_string(),
        Err(_) => "the decoder gave up".into(),
    };
    let found = format!("what cannot be decoded ({why})");
    Err(fault(source_name, Place::Whole, found, "a whole Parquet file"))
}

thread_local! {
    /// Whether a panic on this thread is expected and becomes an error.
    static EXPECTED: Cell<bool> = const { Cell::new(false) };
}

/// Does it without a word on standard error where it panics: what comes of that is told as an error.
fn silent<T>(work: impl FnOnce() -> T) -> T {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |what| {
            if !EXPECTED.get() {
                usual(what);
            }
        }));
    });
    EXPECTED.set(true);
    let done = work();
    EXPECTED.set(false);
    done
}

struct Batches {
    columns: Vec<Column>,
    /// Rows of the whole table.
    rows: u64,
    first_row: u64,
    pool: rayon::ThreadPool,
    source_name: String,
}

impl Iterator for Batches {
    type Item = Result<Batch, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let (first_row, source_name) = (self.first_row, &self.source_name);
        let most = rows_per_batch(self.columns.len()) as u64;
        let rows = (self.rows - first_row).min(most) as usize;
        if rows == 0 {
            return None;
        }
        self.first_row += rows as u64;
        let columns = &mut self.columns;
        let decoded: Vec<_> = self.pool.install(|| {
            columns.par_iter_mut().map(|column| column.read(source_name, first_row, rows)).collect()
        });
        // The first fault by the order of columns, not of threads.
        let columns = decoded.into_iter().collect::<Result<_, _>>();
        Some(columns.map(|columns| Batch { first_row, columns }))
    }
}

/// A column on its way through the row groups.
struct Column {
    place: usize,
    kind: ColumnDescPtr,
    file: Arc<Shared>,
    metadata: Arc<ParquetMetaData>,
    /// The next row group.
    group: usize,
    /// Decoder of the present row group, and its rows that are left.
    decoder: Option<(ColumnReader, usize)>,
}

impl Column {
    /// The next rows, of which `first_row` is the first.
    fn read(&mut self, source_name: &str, first_row: u64, rows: usize) -> Result<Vec<f64>, Error> {
        let mut values = Vec::with_capacity(rows);
        let ticks = ticks_per_second(&self.kind);
        let unsigned = matches!(self.kind.converted_type(), ConvertedType::UINT_32 | ConvertedType::UINT_64);
        guarded(source_name, || {
            while values.len() < rows {
                let (decoder, left) = self.decoder()?;
                let most = (rows - values.len()).min(*left);
                *left -= most;
                append(decoder, most, unsigned, ticks, &mut values)?;
            }
            Ok(())
        })?;
        match values.iter().position(|value| value.is_infinite()) {
            None => Ok(values),
            Some(row) => Err(fault(
                source_name,
                Place::Row { row: first_row + row as u64 + 1, name: self.kind.path().string() },
                "an infinite number, or an integer beyond ±2⁵³",
                "a finite number that double precision holds exactly, or null",
            )),
        }
    }

    /// The decoder of the row group that has rows left.
    fn decoder(&mut self) -> Result<&mut (ColumnReader, usize), ParquetError> {
        while self.decoder.as_ref().is_none_or(|(_, left)| *left == 0) {
            let groups = self.metadata.row_groups();
            let group = groups.get(self.group).ok_or_else(|| ended(self.group))?;
            self.group += 1;
            let rows = group.num_rows() as usize;
            let pages = SerializedPageReader::new(self.file.clone(), group.column(self.place), rows, None)?;
            self.decoder = Some((get_column_reader(self.kind.clone(), Box::new(pages)), rows));
        }
        self.decoder.as_mut().ok_or_else(|| ended(self.group))
    }
}

fn ended(group: usize) -> ParquetError {
    ParquetError::EOF(format!("the rows end in row group {group}"))
}

/// Appends so many rows; an integer that double precision does not hold is infinite.
fn append(
    decoder: &mut ColumnReader,
    rows: usize,
    unsigned: bool,
    ticks: Option<i64>,
    to: &mut Vec<f64>,
) -> Result<(), ParquetError> {
    match decoder {
        ColumnReader::DoubleColumnReader(decoder) => append_as(decoder, rows, to, |value| *value),
        ColumnReader::FloatColumnReader(decoder) => append_as(decoder, rows, to, |value| f64::from(*value)),
        ColumnReader::Int32ColumnReader(decoder) => append_as(decoder, rows, to, |value| match unsigned {
            true => f64::from(*value as u32),
            false => f64::from(*value),
        }),
        ColumnReader::Int64ColumnReader(decoder) => append_as(decoder, rows, to, |value| {
            if let Some(ticks) = ticks {
                return value.div_euclid(ticks) as f64 + value.rem_euclid(ticks) as f64 / ticks as f64;
            }
            let size = if unsigned { *value as u64 } else { value.unsigned_abs() };
            match (size > EXACT, unsigned) {
                (true, _) => f64::INFINITY,
                (_, true) => size as f64,
                (_, false) => *value as f64,
            }
        }),
        _ => Err(ParquetError::General("a type other than that of the schema".into())),
    }
}

fn append_as<T: DataType>(
    decoder: &mut ColumnReaderImpl<T>,
    rows: usize,
    to: &mut Vec<f64>,
    convert: impl Fn(&T::T) -> f64,
) -> Result<(), ParquetError> {
    let (mut levels, mut present) = (Vec::new(), Vec::with_capacity(rows));
    let (read, ..) = decoder.read_records(rows, Some(&mut levels), None, &mut present)?;
    if read < rows {
        return Err(ParquetError::EOF(format!("a column ends {} rows early", rows - read)));
    }
    if present.len() == rows {
        to.extend(present.iter().map(convert));
    } else {
        let mut present = present.iter();
        to.extend(levels.iter().map(|level| match level {
            0 => f64::NAN,
            _ => present.next().map_or(f64::NAN, &convert),
        }));
    }
    Ok(())
}
