//! Two magnetometers in a field that is known at every moment: a sum of sines, so that clocks and rates are
//! exact.

use std::f64::consts::TAU;
use std::ops::Range;

use common::{Axis, Column, Document, Recording, procedure};
use noise::Stream;

/// η of the pairs.
pub const ETA: [[f64; 3]; 3] = [[0.998, 0.021, -0.004], [-0.019, 1.003, 0.006], [0.003, -0.005, 0.9985]];
const MAIN_NT: [f64; 3] = [20_800.0, 700.0, 47_500.0];
const SINES: usize = 150;

/// A campaign.
#[derive(Clone, Debug)]
pub struct Made {
    pub seed: u64,
    pub rows: usize,
    pub step_s: f64,
    pub reference_step_s: f64,
    pub reference_phase_s: f64,
    pub white_nt: f64,
    /// White noise of the reference over that of the test instrument.
    pub reference_share: f64,
    pub flicker: bool,
    /// How late the test instrument's clock is in the middle, s.
    pub offset_s: f64,
    pub rate_ppm: f64,
    /// The test instrument reads the mean of the field at these ages, s: a filter. None: as it is.
    pub ages_s: Vec<f64>,
    /// A storm's sudden beginning.
    pub sudden: bool,
}

impl Made {
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            rows: 4320,
            step_s: 60.0,
            reference_step_s: 60.0,
            reference_phase_s: 0.0,
            white_nt: 0.05,
            reference_share: 0.01,
            flicker: false,
            offset_s: 0.0,
            rate_ppm: 0.0,
            ages_s: Vec::new(),
            sudden: false,
        }
    }

    pub fn time(&self, rows: &Range<usize>) -> Vec<f64> {
        rows.clone().map(|row| row as f64 * self.step_s).collect()
    }

    pub fn reference_rows(&self) -> usize {
        (self.rows as f64 * self.step_s / self.reference_step_s) as usize
    }

    pub fn reference_time(&self) -> Vec<f64> {
        (0..self.reference_rows())
            .map(|k| self.reference_phase_s + k as f64 * self.reference_step_s)
            .collect()
    }

    /// All readings of an instrument, three columns.
    pub fn read(&self, name: &str) -> [Vec<f64>; 3] {
        let (time, step_s) = match name {
            "reference" => (self.reference_time(), self.reference_step_s),
            _ => (self.time(&(0..self.rows)), self.step_s),
        };
        let middle = 0.5 * (self.rows as f64 - 1.0) * self.step_s;
        let late =
            |t: f64| if name == "test" { self.offset_s + self.rate_ppm * 1e-6 * (t - middle) } else { 0.0 };
        let at: Vec<f64> = time.iter().map(|t| t - late(*t)).collect();
        let ages_s = if name == "test" { self.ages_s.as_slice() } else { &[] };
        let field: [Vec<f64>; 3] = std::array::from_fn(|axis| self.field(axis, &at, ages_s));
        let mut columns = match name {
            "reference" => field,
            _ => std::array::from_fn(|j| {
                (0..at.len()).map(|row| (0..3).map(|i| field[i][row] * ETA[i][j]).sum()).collect()
            }),
        };
        for (axis, column) in columns.iter_mut().enumerate() {
            let mut stream = Stream::new(self.seed, &format!("{name} {axis}"));
            // The reference is quiet, so that its noise does not bias η.
            let white = if name == "reference" { self.reference_share } else { 1.0 } * self.white_nt;
            if self.flicker && name == "test" {
                let flicker = noise::power_law(&mut stream, column.len(), step_s, 2e-4, 1.0);
                column.iter_mut().zip(&flicker).for_each(|(value, more)| *value += more);
            }
            column.iter_mut().for_each(|value| *value += white * stream.normal());
        }
        columns
    }

    /// The field along an axis: sines up to 0.8 of half the sampling rate of the test instrument, falling as
    /// a natural field's.
    fn field(&self, axis: usize, at: &[f64], ages_s: &[f64]) -> Vec<f64> {
        let mut stream = Stream::new(self.seed, &format!("field {axis}"));
        let (lowest, highest) = (1.0 / (self.rows as f64 * self.step_s), 0.4 / self.step_s);
        let mut field = vec![MAIN_NT[axis]; at.len()];
        for k in 0..SINES {
            let share = (k as f64 + 0.5 + 0.3 * stream.normal().clamp(-1.5, 1.5)) / SINES as f64;
            let frequency = lowest * (highest / lowest).powf(share.clamp(0.0, 1.0));
            let amplitude = 8.0 * (frequency / lowest).powf(-0.45) / (SINES as f64 / 20.0).sqrt();
            let [sine, cosine] = [stream.normal(), stream.normal()].map(|normal| amplitude * normal);
            // What the mean over the ages makes of a sine.
            let mean = |of: fn(f64) -> f64| {
                ages_s.iter().map(|age| of(TAU * frequency * age)).sum::<f64>() / ages_s.len() as f64
            };
            let [real, imaginary] =
                if ages_s.is_empty() { [1.0, 0.0] } else { [mean(f64::cos), mean(f64::sin)] };
            for (value, t) in field.iter_mut().zip(at) {
                let (s, c) = (TAU * frequency * t).sin_cos();
                *value += sine * (s * real - c * imaginary) + cosine * (c * real + s * imaginary);
            }
        }
        if self.sudden {
            let begin = 0.55 * self.rows as f64 * self.step_s;
            let size = [60.0, -15.0, 20.0][axis];
            for (value, t) in field.iter_mut().zip(at) {
                *value += 0.5 * size * (1.0 + ((t - begin) / (1.5 * self.step_s)).tanh());
            }
        }
        field
    }

    /// Both instruments in one recording.
    pub fn both(&self, id: &str, rows: Range<usize>) -> Recording {
        both(id, &self.time(&rows), [&self.read("reference"), &self.read("test")], &rows)
    }
}

/// Reference and test instrument in one recording.
pub fn both(
    id: &str,
    time: &[f64],
    [reference, test]: [&[Vec<f64>; 3]; 2],
    rows: &Range<usize>,
) -> Recording {
    let all = [columns("reference", reference, rows), columns("test", test, rows)];
    recording(id, time, all.concat())
}

/// Columns of an instrument by their names.
pub fn columns(name: &str, read: &[Vec<f64>; 3], rows: &Range<usize>) -> Vec<(String, Vec<f64>)> {
    let of = |axis: usize| (format!("{name}_{}_nt", Axis::ALL[axis]), read[axis][rows.clone()].to_vec());
    (0..3).map(of).collect()
}

pub fn recording(id: &str, time: &[f64], columns: Vec<(String, Vec<f64>)>) -> Recording {
    let mut recording =
        Recording { id: id.into(), procedure: procedure::DIFFERENTIAL.into(), ..Recording::default() };
    recording.columns.insert("time_s".into(), Column::from(time.to_vec()));
    recording.columns.extend(columns.into_iter().map(|(name, column)| (name, Column::from(column))));
    recording
}

pub fn document(recordings: Vec<Recording>) -> Document {
    Document { fluxcal: 1, recordings, ..Document::default() }
}
