//! Three sensors whose field hardly turns, beside a scalar magnetometer: readings are the field, or its variations
//! about a main field that is compensated.
//!
//! With b the corrected readings and B₀ an unknown main field, F = |B₀ + b| = F₀ + u·b + (|b|² − (u·b)²)/2F + …, u
//! the direction of the field: a level and three slopes, and a bend that these determine. The offsets of the
//! sensors by themselves, and the angles between them, are not seen.

use common::Document;
use explain::Covariate;
use explain::pair::Pair;
use nalgebra::{Matrix4, Vector3, Vector4};

use super::{Compared, rms};
use crate::Error;
use crate::channel::{Channel, Reader};
use crate::magnitude;
use crate::observed::Observed;

/// Rounds of slopes and of the bend that follows from them.
const ROUNDS: usize = 3;
/// Steps that differ by more than this share of the usual one are uneven.
const EVEN: f64 = 1e-3;

/// The readings of all recordings on one clock.
#[derive(Default)]
struct Rows {
    time_s: Vec<f64>,
    b: Vec<Vector3<f64>>,
    scalar: Vec<f64>,
}

/// Explains what the magnitude leaves, where the recordings do not determine the sensors one by one; None for
/// other documents.
pub fn compared(document: &Document, told: &dyn Fn(&str)) -> Result<Option<Compared>, Error> {
    let Ok(gathered) = joined::gathered(document) else { return Ok(None) };
    let (notes, document) = match &gathered {
        Some(gathered) => (gathered.told.clone(), &gathered.document),
        None => (Vec::new(), document),
    };
    let Ok(observed) = Observed::of(document) else { return Ok(None) };
    let timed = |channel: &Channel| channel.reader == Reader::Magnitude && observed.times(channel).is_some();
    if document.model.as_ref().is_some_and(|model| !model.effects.is_empty())
        || !observed.channels.iter().all(timed)
    {
        return Ok(None);
    }
    let mut rows = Rows::default();
    for channel in &observed.channels {
        rows.add(&observed, channel);
    }
    rows.sort();
    if rows.turn() {
        return Ok(None);
    }
    let as_it_came: Vec<f64> = rows.b.iter().zip(&rows.scalar).map(|(b, scalar)| scalar - b.norm()).collect();
    let level = estimate::stats::mean(&as_it_came);
    let as_it_came: Vec<f64> = as_it_came.iter().map(|left| left - level).collect();
    let covariates = covariates(document, &observed);
    let pair = rows.pair(covariates);
    let of = explain::pair::pair(&pair, told)?;
    let mut notes = notes;
    notes.push(
        "the field hardly turns: a level and three slopes are determined, not the offset, scale factor and angles of each sensor; rotations or absolute measurements would"
            .into(),
    );
    Ok(Some(Compared {
        recordings: observed.runs.iter().map(|run| run.recording.id.clone()).collect(),
        channels: vec![("reference_nt".into(), None)],
        what: "the scalar magnetometer beside the sensors",
        as_it_came: vec![rms(&as_it_came)],
        notes,
        ..Compared::of(&pair.covariates, of)
    }))
}

impl Rows {
    fn add(&mut self, observed: &Observed<'_>, channel: &Channel) {
        let run = &observed.runs[channel.run];
        let clock = run.setting.context.clock_s;
        self.time_s.extend(observed.times(channel).into_iter().flatten().map(|t| t + clock));
        self.b.extend(channel.vectors.iter().map(|reading| magnitude::field(&run.setting.basic, reading)));
        self.scalar.extend(&channel.readings);
    }

    fn sort(&mut self) {
        let mut order: Vec<usize> = (0..self.time_s.len()).collect();
        order.sort_by(|a, b| self.time_s[*a].total_cmp(&self.time_s[*b]));
        order.dedup_by(|a, b| self.time_s[*a] == self.time_s[*b]);
        *self = Self {
            time_s: order.iter().map(|row| self.time_s[*row]).collect(),
            b: order.iter().map(|row| self.b[*row]).collect(),
            scalar: order.iter().map(|row| self.scalar[*row]).collect(),
        };
    }

    /// Whether the direction of the field turns so far that the offsets are determined one by one: each to less
    /// than the readings vary.
    fn turn(&self) -> bool {
        let count = self.b.len() as f64;
        let mean = self.b.iter().sum::<Vector3<f64>>() / count;
        let vary = (self.b.iter().map(|b| (b - mean).norm_squared()).sum::<f64>() / count).sqrt();
        let field = estimate::stats::mean(&self.scalar);
        // Directions of a field whose compensated part is not in the readings turn by what these vary.
        vary > 0.1 * field
    }

    /// The level and three slopes of plain least squares.
    fn slopes(&self, y: &[f64]) -> Vector3<f64> {
        let count = self.b.len() as f64;
        let mean = self.b.iter().sum::<Vector3<f64>>() / count;
        let level = estimate::stats::mean(y);
        let (mut gram, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
        for (b, y) in self.b.iter().zip(y) {
            let d = b - mean;
            let row = Vector4::new(1.0, d.x, d.y, d.z);
            gram += row * row.transpose();
            right += row * (y - level);
        }
        let solved = gram.try_inverse().map_or(Vector4::zeros(), |inverse| inverse * right);
        solved.fixed_rows::<3>(1).into()
    }

    /// The scalar readings without the bend, beside the vector's.
    fn pair(&self, covariates: Vec<Covariate>) -> Pair {
        let mean = self.b.iter().sum::<Vector3<f64>>() / self.b.len() as f64;
        let mut y = self.scalar.clone();
        for _ in 0..ROUNDS {
            let u = self.slopes(&y).try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
            for ((y, scalar), b) in y.iter_mut().zip(&self.scalar).zip(&self.b) {
                let d = b - mean;
                *y = scalar - (d.norm_squared() - u.dot(&d).powi(2)) / (2.0 * scalar);
            }
        }
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let step_s = estimate::stats::median_of(&mut steps);
        let first_s = self.time_s[0];
        let place = |t: &f64| (t - first_s) / step_s;
        let even =
            self.time_s.iter().all(|t| (place(t) - place(t).round()).abs() < EVEN * self.time_s.len() as f64);
        let count =
            if even { place(&self.time_s[self.time_s.len() - 1]).round() as usize + 1 } else { self.b.len() };
        let mut pair = Pair {
            first_s,
            step_s,
            reference: [vec![0.0; count], vec![0.0; count], vec![0.0; count]],
            test: vec![vec![0.0; count]],
            whole: vec![false; count],
            covariates,
        };
        for (number, t) in self.time_s.iter().enumerate() {
            let row = if even { place(t).round() as usize } else { number };
            (0..3).for_each(|axis| pair.reference[axis][row] = self.b[number][axis]);
            (pair.test[0][row], pair.whole[row]) = (y[number], true);
        }
        pair
    }
}

/// What was recorded beside on the campaign's clock.
fn covariates(document: &Document, observed: &Observed<'_>) -> Vec<Covariate> {
    let mut all: Vec<Covariate> = Vec::new();
    let _ = document;
    for run in &observed.runs {
        let Some(time) = run.time_s else { continue };
        let clock = run.setting.context.clock_s;
        let beside = |name: &&String| {
            !name.starts_with("time_") && !name.ends_with("_nt") && !name.starts_with("sensor_x_v")
        };
        for name in run.recording.columns.keys().filter(beside) {
            let Some(values) = run.recording.column(name) else { continue };
            if ["sensor_x_v", "sensor_y_v", "sensor_z_v"].contains(&name.as_str()) {
                continue;
            }
            let known = time.iter().zip(values).filter(|(_, value)| value.is_finite());
            let (time_s, values): (Vec<f64>, Vec<f64>) = known.map(|(t, value)| (t + clock, *value)).unzip();
            match all.iter_mut().find(|have| have.name == *name && have.time_s.last() < time_s.first()) {
                Some(have) => {
                    have.time_s.extend(time_s);
                    have.values.extend(values);
                }
                None => all.push(Covariate { name: name.clone(), time_s, values }),
            }
        }
    }
    all.retain(|one| one.values.windows(2).any(|pair| pair[0] != pair[1]));
    all
}
