/// Most rows of a [`Batch`].
pub const BATCH_ROWS: usize = 1 << 16;
/// Most numbers of a batch, unless one row alone has more.
const BATCH_NUMBERS: usize = 1 << 20;

/// Some rows of a table.
///
/// A [`Reader`](crate::Reader) of n columns yields min(65 536, ⌊2²⁰/n⌋) rows in each batch but the last, in
/// every format, or fewer where their text is longer than 32 MiB.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Batch {
    /// Rows of the table before the first of this batch.
    pub first_row: u64,
    /// The numbers, column by column, in the order of [`Reader::columns`](crate::Reader::columns); NaN where
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
