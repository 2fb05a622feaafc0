use crate::Error;

/// Most rows of a [`Batch`].
pub const BATCH_ROWS: usize = 1 << 16;
/// Most numbers of a batch, unless one row alone has more.
const BATCH_NUMBERS: usize = 1 << 20;

/// Some rows of a table.
///
/// A [`Reader`] of n columns yields min(65 536, ⌊2²⁰/n⌋) rows in each batch but the last, in
/// every format, or fewer where their text is longer than 32 MiB.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// Rows of the table before the first of this batch.
    pub first_row: u64,
    /// The numbers, column by column, in the order of [`Reader::columns`]; NaN where
    /// one is missing.
    pub columns: Vec<Vec<f64>>,
}

impl Batch {
    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
}

/// Rows of a batch of so many columns.
pub(crate) fn rows_per_batch(columns: usize) -> usize {
    (BATCH_NUMBERS / columns.max(1)).clamp(1, BATCH_ROWS)
}

/// A table, read batch by batch: an iterator over its rows in the order of the file.
///
/// After an error it ends. Dropped early, it stops reading.
pub struct Reader {
    pub(super) columns: Vec<String>,
    pub(super) batches: Box<dyn Iterator<Item = Result<Batch, Error>> + Send>,
    pub(super) failed: bool,
}

impl Reader {
    /// Names of the columns that each batch has.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }
}

impl Iterator for Reader {
    type Item = Result<Batch, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let batch = self.batches.next();
        self.failed = matches!(batch, Some(Err(_)));
        batch
    }
}
