//! Three sensors whose field hardly turns, beside a scalar magnetometer: readings are the field, or its variations
//! about a main field that is compensated.
//!
//! With b the corrected readings and B₀ an unknown main field, F = |B₀ + b| = F₀ + u·d + (|d|² − (u·d)²)/2F + …, d = b
//! less its mean and u the direction of the field: a level and three slopes, and a bend that follows from these.
//! What is determined is the level and the slopes: the direction of the main field, and a common scale factor. The
//! sensors' scale factors one by one, and the angles between them, are not seen.

use explain::{Cause, Covariate, Fit, Form, Problem, thinned};
use faer::Mat;
use joined::{Pair, Segment};

use crate::LEAST;
use crate::residual::centred;

/// Rounds of slopes and of the bend that follows from them.
const ROUNDS: usize = 3;
/// Rows are on an even grid where their times are off by less than this share of the step.
const EVEN: f64 = 0.05;
/// So many rows, in so many blocks that are spread over all, say whether there are slopes.
const MOST: usize = 1 << 15;
const BLOCKS: usize = 16;
/// Fields that turn by less, in radians, say little of single sensors.
const TURNS: f64 = 0.1;

/// Readings of the vector, corrected, and of the scalar magnetometer at the same moments.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// The vector, nT.
    pub b: Vec<[f64; 3]>,
    /// The magnitude, nT.
    pub scalar: Vec<f64>,
}

/// A level and three slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Mean of the vector, nT.
    pub mean: [f64; 3],
    /// The magnitude there, nT.
    pub level_nt: f64,
    /// How it changes with each reading, nT/nT.
    pub slopes: [f64; 3],
    /// Rms of what they leave, nT.
    pub rms_nt: f64,
    /// Whether the slopes are those that the calibration means: the readings do not show others.
    pub alone: bool,
}

impl Level {
    /// The same with what a fit beside other causes has: coefficients of the three readings, and of the level.
    #[must_use]
    pub fn fitted(&self, base: &[(f64, f64)], level: usize) -> Self {
        if self.alone {
            return Self { level_nt: self.level_nt + base[level].0, ..*self };
        }
        let slopes = std::array::from_fn(|axis| base[axis].0);
        Self { slopes, level_nt: self.level_nt + base[level].0, ..*self }
    }

    /// A common scale factor k of the readings and the main field B₀ beside them, nT: |k b + B₀| has this level and
    /// these slopes. Standard uncertainties of B₀ are those of the slopes times the level.
    pub fn main_field(&self, slope_std: [f64; 3]) -> (f64, [(f64, f64); 3]) {
        let scale = self.slopes.iter().map(|slope| slope * slope).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let of = |i: usize| {
            let along = self.level_nt * self.slopes[i] / scale;
            (along - scale * self.mean[i], self.level_nt * slope_std[i] / scale)
        };
        (scale, std::array::from_fn(of))
    }
}

impl Readings {
    /// In the order of time, each moment once.
    #[must_use]
    pub fn sorted(&self) -> Self {
        let mut order: Vec<usize> = (0..self.time_s.len()).collect();
        order.sort_by(|a, b| self.time_s[*a].total_cmp(&self.time_s[*b]));
        order.dedup_by(|a, b| self.time_s[*a] == self.time_s[*b]);
        Self {
            time_s: order.iter().map(|row| self.time_s[*row]).collect(),
            b: order.iter().map(|row| self.b[*row]).collect(),
            scalar: order.iter().map(|row| self.scalar[*row]).collect(),
        }
    }

    /// Whether the field turns in the sensors.
    pub fn turn(&self) -> bool {
        let mean = self.mean();
        let squares = self.b.iter().map(|b| (0..3).map(|i| (b[i] - mean[i]).powi(2)).sum::<f64>());
        let vary = (squares.sum::<f64>() / self.b.len() as f64).sqrt();
        vary > TURNS * estimate::stats::mean(&self.scalar)
    }

    fn mean(&self) -> [f64; 3] {
        std::array::from_fn(|i| self.b.iter().map(|b| b[i]).sum::<f64>() / self.b.len() as f64)
    }

    /// The bend that slopes make of each row, nT.
    fn bend(&self, slopes: [f64; 3]) -> Vec<f64> {
        let mean = self.mean();
        let size = slopes.iter().map(|s| s * s).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let of = |(b, scalar): (&[f64; 3], &f64)| {
            let d: [f64; 3] = std::array::from_fn(|i| b[i] - mean[i]);
            let along: f64 = (0..3).map(|i| slopes[i] / size * d[i]).sum();
            (d.iter().map(|d| d * d).sum::<f64>() - along * along) / (2.0 * scalar)
        };
        self.b.iter().zip(&self.scalar).map(of).collect()
    }

    /// The level alone, with the slopes that the readings as they are corrected mean.
    fn stated(&self) -> Level {
        let mean = self.mean();
        let size = mean.iter().map(|b| b * b).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let slopes = mean.map(|b| b / size);
        Level {
            mean,
            level_nt: estimate::stats::mean(&self.scalar),
            slopes,
            rms_nt: self.left(slopes),
            alone: true,
        }
    }

    /// What slopes leave of each row.
    fn rest(&self, slopes: [f64; 3]) -> Vec<f64> {
        let (mean, bend) = (self.mean(), self.bend(slopes));
        let rest = |row: usize| {
            let along: f64 = (0..3).map(|i| slopes[i] * (self.b[row][i] - mean[i])).sum();
            self.scalar[row] - bend[row] - along
        };
        (0..self.b.len()).map(rest).collect()
    }

    /// Its rms beside a level.
    fn left(&self, slopes: [f64; 3]) -> f64 {
        estimate::stats::rms(&centred(&self.rest(slopes)))
    }

    /// ln of the odds for slopes beside those that the calibration means, under noise of many forms.
    fn odds_of_slopes(&self) -> Result<f64, estimate::Error> {
        let rest = self.rest(self.stated().slopes);
        let kept = thinned(self.b.len(), MOST, BLOCKS);
        let of = |axis: usize| Covariate {
            name: String::new(),
            time_s: kept.iter().map(|row| self.time_s[*row]).collect(),
            values: kept.iter().map(|row| self.b[*row][axis]).collect(),
        };
        let problem = Problem {
            time_s: kept.iter().map(|row| self.time_s[*row]).collect(),
            channels: vec![kept.iter().map(|row| rest[*row]).collect()],
            covariates: (0..3).map(of).collect(),
            ..Problem::default()
        };
        let slopes = [0, 1, 2].map(|axis| (Cause::Covariate(axis), Form::default()));
        Ok(explain::weigh(&problem, &slopes)?.0)
    }

    /// A level and three slopes; the level alone where the readings show no slopes but those that the calibration
    /// means.
    /// Refused: times out of order.
    pub fn level(&self) -> Result<Level, estimate::Error> {
        let seen = self.b.len() < LEAST || self.odds_of_slopes()? > 0.0;
        Ok(if seen { self.by_least_squares() } else { self.stated() })
    }

    /// By plain least squares, the bend taken off.
    fn by_least_squares(&self) -> Level {
        let mean = self.mean();
        let mut level = Level { mean, level_nt: 0.0, slopes: [0.0; 3], rms_nt: 0.0, alone: false };
        let mut bend = vec![0.0; self.b.len()];
        for _ in 0..ROUNDS {
            let y: Vec<f64> = self.scalar.iter().zip(&bend).map(|(scalar, bend)| scalar - bend).collect();
            let about = estimate::stats::mean(&y);
            let column = |i: usize, row: usize| if i < 3 { self.b[row][i] - mean[i] } else { y[row] - about };
            let gram = Mat::from_fn(4, 4, |i, j| {
                (0..y.len()).map(|row| column(i, row) * column(j, row)).sum::<f64>()
            });
            let fit = Fit::of(&gram, 3, &[0, 1, 2]);
            level.level_nt = about;
            level.slopes = std::array::from_fn(|i| fit.coefficient(i));
            level.rms_nt = (fit.left / y.len() as f64).sqrt();
            bend = self.bend(level.slopes);
        }
        level
    }

    /// The magnitude less its bend, held against the vector.
    pub fn pair(&self, level: &Level) -> Pair {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let step_s = estimate::stats::median_of(&mut steps);
        let first_s = self.time_s[0];
        let place = |t: &f64| (t - first_s) / step_s;
        let even = self.time_s.iter().all(|t| (place(t) - place(t).round()).abs() < EVEN);
        let last = self.time_s.len() - 1;
        let count = if even { place(&self.time_s[last]).round() as usize + 1 } else { self.b.len() };
        let mut whole = vec![false; count];
        let mut columns = vec![vec![0.0; count]; 4];
        for (number, bend) in self.bend(level.slopes).iter().enumerate() {
            let row = if even { place(&self.time_s[number]).round() as usize } else { number };
            (0..3).for_each(|axis| columns[axis][row] = self.b[number][axis]);
            (columns[3][row], whole[row]) = (self.scalar[number] - bend, true);
        }
        let [x, y, z, test] = std::array::from_fn(|i| std::mem::take(&mut columns[i]).into());
        let mut pair = Pair {
            first_s,
            step_s,
            reference: [x, y, z],
            test: vec![test],
            whole,
            steps: vec![Vec::new()],
            segments: vec![Segment { rows: 0..count, late_s: 0.0 }],
            ..Pair::default()
        };
        pair.bridge();
        pair
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_the_direction_of_the_main_field() {
        let main = [20_800.0, 1500.0, 43_900.0];
        let b: Vec<[f64; 3]> =
            (0..500).map(|k| [0.7, 1.1, 1.9].map(|w: f64| 60.0 * (w * f64::from(k) / 30.0).sin())).collect();
        let scalar = b.iter().map(|b| (0..3).map(|i| (main[i] + b[i]).powi(2)).sum::<f64>().sqrt()).collect();
        let readings = Readings { time_s: (0..500).map(f64::from).collect(), b, scalar };
        let level = readings.level().expect("a level");
        let size = main.iter().map(|m: &f64| m * m).sum::<f64>().sqrt();
        for (slope, main) in level.slopes.iter().zip(main) {
            assert!((slope - main / size).abs() < 2e-3, "{level:?}");
        }
        assert!(level.rms_nt < 1e-3 && !readings.turn(), "{level:?}");
        let (scale, added) = level.main_field([1e-3; 3]);
        let size = |b: &[f64; 3]| (0..3).map(|i| (scale * b[i] + added[i].0).powi(2)).sum::<f64>().sqrt();
        for (b, scalar) in readings.b.iter().zip(&readings.scalar) {
            assert!((size(b) - scalar).abs() < 0.01, "{} {scalar}", size(b));
        }
    }
}
