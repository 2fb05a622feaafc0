//! A recording, and the readings of one sensor, of the scalar magnetometer, or of the corrected vector's
//! length in it.

use common::{Axis, Recording};
use nalgebra::Vector3;
use physics::Setting;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reader {
    /// A sensor of the magnetometer, or of the one under test.
    Sensor(Axis),
    /// A scalar magnetometer in the coils.
    Scalar,
    /// All sensors: the length of the corrected vector, held against a scalar magnetometer beside them.
    Magnitude,
}

/// Readings of one sensor, or of the scalar magnetometer, in one recording.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Number of the recording among the [`Run`]s.
    pub run: usize,
    pub reader: Reader,
    pub column: String,
    /// Rows of the recording that have a reading.
    pub rows: Vec<usize>,
    /// The readings there, in the unit of the column.
    pub readings: Vec<f64>,
    /// nT for a unit of the column.
    pub to_nt: f64,
    /// Where its rows begin in the stack of all channels.
    pub at: usize,
    /// Of a magnitude: what the three sensors read in each of the rows, in the unit of the recording.
    pub vectors: Vec<Vector3<f64>>,
    /// Of a magnitude: the sensitivities of the three sensors as the document has them.
    pub nominal: Vector3<f64>,
    /// Of a magnitude: its derivative in each of the rows by the reading of each sensor as field.
    pub shares: Vec<Vector3<f64>>,
}

impl Channel {
    /// Its rows in the stack of all channels.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.at..self.at + self.rows.len()
    }

    pub fn axis(&self) -> Option<Axis> {
        match self.reader {
            Reader::Sensor(axis) => Some(axis),
            Reader::Scalar | Reader::Magnitude => None,
        }
    }
}

/// A recording with the chain that predicts it.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    pub recording: &'a Recording,
    /// Its place in the document.
    pub path: String,
    pub setting: Setting<'a>,
    /// The times, where all are there and do not run backwards.
    pub time_s: Option<&'a [f64]>,
    /// Of a magnitude: the readings of the three sensors, smooth, in each row of the recording; else empty.
    pub smooth: Vec<Vector3<f64>>,
}

impl Run<'_> {
    /// The times on the clock of the campaign, s.
    pub fn on_clock(&self) -> Option<Vec<f64>> {
        Some(self.time_s?.iter().map(|time| time + self.setting.context.clock_s).collect())
    }
}
