//! Long series of rows in one pass and bounded memory, and pieces that are joined later to the same answer.
//!
//! What white-noise rows say of the calibration is in the triangular factor of their products
//! ([`crate::terms`]). Kept are such factors by windows of time that double in width as the series grows
//! ([`windows`]), apart for rows at the ends of the sensors' ranges until it is known whether readings are
//! piled up there ([`crate::ends`]), and a sample of rows ([`sample`]), which shows how the sensors were
//! turned.

mod answer;
mod error;
mod memory;
mod partial;
mod sample;
mod windows;

pub use self::partial::Partial;
pub use answer::document;
pub use error::Error;

use ::partial::{Covered, Error as Fault};
use physics::Unit;

use crate::read::Source;
use crate::terms::{ONE, Terms};
use windows::Windows;

/// Rows in the order of time; NaN where a reading is missing.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// Times, s.
    pub time_s: &'a [f64],
    /// Outputs of the sensors x, y, z.
    pub readings: [&'a [f64]; 3],
    /// The magnitude of the field, nT.
    pub magnitude_nt: &'a [f64],
}

/// Takes a piece of a series row by row.
pub struct Statistics {
    partial: Partial,
    windows: Windows,
    terms: Terms,
    products: Vec<f64>,
    taken: u64,
    first_s: f64,
    last_s: f64,
    before: [f64; 3],
}

impl Statistics {
    /// Nothing yet, of readings in a unit beside a magnitude from a source.
    pub fn new(unit: Unit, source: Source) -> Self {
        let terms = Terms::new(ONE + 1);
        Self {
            partial: Partial::new(unit, source),
            windows: Windows::new(terms.count()),
            products: vec![0.0; terms.count()],
            terms,
            taken: 0,
            first_s: f64::NAN,
            last_s: f64::NEG_INFINITY,
            before: [f64::NAN; 3],
        }
    }

    /// Takes the next rows. What comes out does not depend on how the rows are cut into batches.
    ///
    /// # Errors
    ///
    /// Columns of unlike length, a time that is missing or does not rise.
    pub fn push(&mut self, batch: &Batch<'_>) -> Result<(), Error> {
        let expected = batch.time_s.len();
        let columns = batch.readings.iter().chain([&batch.magnitude_nt]);
        if let Some(odd) = columns.into_iter().find(|column| column.len() != expected) {
            return Err(Fault::Lengths { found: odd.len(), expected }.into());
        }
        for row in 0..expected {
            let readings = batch.readings.map(|column| column[row]);
            self.take(batch.time_s[row], readings, batch.magnitude_nt[row])?;
        }
        Ok(())
    }

    fn take(&mut self, time_s: f64, readings: [f64; 3], magnitude_nt: f64) -> Result<(), Error> {
        let row = self.taken;
        if !time_s.is_finite() {
            return Err(Fault::NoTime { row }.into());
        }
        if time_s <= self.last_s {
            return Err(Fault::Backwards { row, time_s }.into());
        }
        if !windows::holds(time_s) {
            return Err(Error::Far { row, time_s });
        }
        if row == 0 {
            self.first_s = time_s;
        }
        self.taken += 1;
        self.last_s = time_s;
        let whole = readings.iter().all(|reading| reading.is_finite()) && magnitude_nt > 0.0;
        if !whole || !magnitude_nt.is_finite() {
            self.partial.missing += 1;
            return Ok(());
        }
        self.partial.rows += 1;
        self.partial.repeated += u64::from(readings == self.before);
        self.before = readings;
        let (at, moved) = self.partial.ends.take(readings);
        if moved != 0 {
            self.windows.no_longer(moved);
        }
        let [x, y, z] = readings;
        self.terms.fill(&[x, y, z, 1.0, magnitude_nt], &mut self.products);
        self.windows.row(at, time_s, &self.products);
        self.partial.sample.take([time_s, x, y, z, magnitude_nt]);
        Ok(())
    }

    /// The piece.
    pub fn finish(mut self) -> Partial {
        if self.taken > 0 {
            self.partial.covered = Covered::of(self.first_s, self.last_s);
        }
        self.partial.windows = self.windows.closed();
        self.partial
    }
}
