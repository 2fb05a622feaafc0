//! Long series of rows in one pass and bounded memory, and pieces that are joined later to the same answer.
//!
//! What white-noise rows say of the calibration is in the triangular factor of their products
//! ([`crate::terms`]). Kept are such factors by windows of time that double in width as the series grows
//! ([`windows`]), apart for rows at the ends of the sensors' ranges until it is known whether readings are
//! piled up there ([`crate::checks`]), and a sample of rows, to show the turns.

mod answer;
mod memory;
mod partial;
mod windows;

pub use self::partial::{Error, Partial};
pub use answer::document;

use ::partial::{Covered, Error as Fault, Series, Take};
use common::{Axis, procedure};
use physics::Unit;

use crate::read::{Source, columns, unit_of};
use crate::terms::{ONE, Terms};

/// Takes a piece of a series row by row.
pub struct Statistics {
    partial: Partial,
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
            products: vec![0.0; terms.count()],
            terms,
            taken: 0,
            first_s: f64::NAN,
            last_s: f64::NEG_INFINITY,
            before: [f64::NAN; 3],
        }
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
        self.partial.windows.no_longer(moved);
        let [x, y, z] = readings;
        self.terms.fill(&[x, y, z, 1.0, magnitude_nt], &mut self.products);
        self.partial.windows.row(at, time_s, &self.products);
        self.partial.sample.take([time_s, x, y, z, magnitude_nt]);
        Ok(())
    }
}

/// Sensors beside the magnitude of the field, in the columns of a table or a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Columns;

impl Series for Columns {
    type Partial = Partial;
    type Take = Statistics;
    const PROCEDURE: &'static str = procedure::FREE_RUN;

    fn begin(&self, there: &[String]) -> Result<(Vec<String>, Statistics), String> {
        let has = |name: &String| there.contains(name);
        let unit = unit_of(has).ok_or("`sensor_x_v`, `sensor_y_v`, `sensor_z_v` (or `_nt`)")?;
        let ambient = Axis::ALL.map(|axis| format!("ambient_{axis}_nt"));
        let reference = "reference_nt".to_string();
        let (source, magnitude) = if has(&reference) {
            (Source::Scalar, vec![reference])
        } else if ambient.iter().all(has) {
            (Source::Ambient, ambient.to_vec())
        } else {
            return Err("`reference_nt`, or `ambient_x_nt`, `ambient_y_nt`, `ambient_z_nt`".into());
        };
        let time = "time_s".to_string();
        if !has(&time) {
            return Err("`time_s`".into());
        }
        let names = std::iter::once(time).chain(columns(unit)).chain(magnitude).collect();
        Ok((names, Statistics::new(unit, source)))
    }
}

impl Take for Statistics {
    type Partial = Partial;

    /// Columns: times (s), the outputs of the sensors x, y, z, and the magnitude of the field or its three
    /// components (nT). NaN stands for a missing reading. Batches do not change the result.
    fn push(&mut self, columns: &[&[f64]]) -> Result<(), Error> {
        let [time_s, x, y, z, first, more @ ..] = columns else {
            let (found, expected) = (columns.len(), 5);
            return Err(Fault::Lengths { found, expected }.into());
        };
        let expected = time_s.len();
        if let Some(odd) = columns.iter().find(|column| column.len() != expected) {
            return Err(Fault::Lengths { found: odd.len(), expected }.into());
        }
        for row in 0..expected {
            let magnitude_nt = match more {
                [by, bz] => first[row].hypot(by[row]).hypot(bz[row]),
                _ => first[row],
            };
            self.take(time_s[row], [x[row], y[row], z[row]], magnitude_nt)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Partial, Error> {
        if self.taken > 0 {
            self.partial.covered = Covered::of(self.first_s, self.last_s);
        }
        self.partial.windows.settle();
        Ok(self.partial)
    }
}
