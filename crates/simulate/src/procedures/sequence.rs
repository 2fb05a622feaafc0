//! What every procedure can do.

use common::Error;

use crate::bench::Bench;
use crate::planned::Planned;

/// A procedure as a sequence of recordings.
pub trait Sequence {
    /// Rows that it gives; refuses sizes that make no sense. Called before anything is planned.
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error>;

    /// Its recordings, without readings.
    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error>;
}
