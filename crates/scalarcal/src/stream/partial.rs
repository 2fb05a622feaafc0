use partial::{Covered, MOST, Sample};
use physics::Unit;
use serde::{Deserialize, Serialize};

use super::windows::Windows;
use crate::checks::Ends;
use crate::read::Source;
use crate::terms::{ONE, Terms};

/// Rows of a sample.
const KEPT: usize = 128;

/// Why rows cannot be taken, or pieces not be joined.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum Error {
    /// As with every series.
    #[error(transparent)]
    Piece(#[from] partial::Error),
    /// A time is far from any.
    #[error(
        "row {row}: found {time_s} s; expected seconds of a clock, less than 10¹² (is it in another unit?)"
    )]
    Far {
        /// Row from 0.
        row: u64,
        /// Its time, s.
        time_s: f64,
    },
}

impl common::Told for Error {}

/// What is kept of a piece of a series: joined by [`partial::merge`], answered by [`super::document`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Partial {
    /// Unit of the readings: `v` or `nt`.
    unit: String,
    /// Whether the magnitude is that of a known field (`ambient_*_nt`), not of a scalar magnetometer.
    ambient: bool,
    /// What is covered, s.
    pub(super) covered: Covered<f64>,
    /// Rows with all readings.
    pub rows: u64,
    /// Rows that lack a reading.
    pub missing: u64,
    /// Rows that repeat the one before in all three sensors.
    pub repeated: u64,
    /// The largest and the smallest readings.
    #[serde(default, skip_serializing_if = "Ends::is_empty")]
    pub(super) ends: Ends,
    #[serde(flatten)]
    pub(super) windows: Windows,
    /// Time (s), readings, magnitude (nT).
    pub(super) sample: Sample<5, KEPT>,
}

impl Partial {
    /// A piece without rows, which changes none that it is merged with.
    pub fn new(unit: Unit, source: Source) -> Self {
        Self { unit: unit.suffix().into(), ambient: source == Source::Ambient, ..Self::default() }
    }

    /// Unit of the readings.
    pub fn unit(&self) -> Unit {
        if self.unit == Unit::Nanotesla.suffix() { Unit::Nanotesla } else { Unit::Volt }
    }

    /// Where the magnitude comes from.
    pub fn source(&self) -> Source {
        if self.ambient { Source::Ambient } else { Source::Scalar }
    }

    /// First and last moment that are covered, s.
    pub fn span_s(&self) -> Option<[f64; 2]> {
        self.covered.span()
    }

    fn of(&self) -> String {
        let reference = if self.ambient { "ambient_*_nt" } else { "reference_nt" };
        format!("{} beside {reference}", self.unit)
    }
}

impl partial::Partial for Partial {
    const KIND: &'static str = "scalarcal";
    const VERSION: u32 = 2;
    type Error = Error;

    fn is_whole(&self) -> bool {
        let columns = Terms::new(ONE + 1).count();
        let units = [Unit::Volt, Unit::Nanotesla].map(Unit::suffix);
        units.contains(&self.unit.as_str())
            && self.covered.is_whole()
            && self.ends.is_whole()
            && self.windows.is_whole(columns, self.rows)
            && self.sample.is_whole()
    }

    fn first_s(&self) -> Option<f64> {
        Some(self.span_s()?[0])
    }

    fn join(&mut self, mut other: Self) -> Result<(), Error> {
        if (&self.unit, self.ambient) != (&other.unit, other.ambient) {
            let [first, second] = [&*self, &other].map(|piece| format!("with readings in {}", piece.of()));
            let expected = "the same unit and the same kind of reference in all";
            return Err(partial::Error::Unlike { first, second, expected }.into());
        }
        self.covered
            .merge(&other.covered)
            .map_err(|[from_s, to_s]| partial::Error::Overlap { from_s, to_s })?;
        while self.covered.close(MOST).is_some() {}
        self.rows += other.rows;
        self.missing += other.missing;
        self.repeated += other.repeated;
        let (here, there) = self.ends.merge(&other.ends);
        self.windows.no_longer(here);
        other.windows.no_longer(there);
        self.windows.merge(other.windows);
        self.sample.merge(&other.sample);
        Ok(())
    }
}
