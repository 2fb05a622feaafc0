use crate::{Batch, Error};

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
