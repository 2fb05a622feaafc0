use crate::Process;
use pulp::{Arch, NullaryFnOnce};
use std::array::from_fn;

/// Columns that are whitened side by side.
pub const LANES: usize = 8;
/// Gains that change by less than this part of the largest from row to row are steady.
const STEADY: f64 = 1e-11;

/// What one row does: x ← φ x + g e of each process, e the innovation, of the std 1/`inverse`.
#[derive(Debug)]
pub struct Gain {
    /// φ of each process, for the step to the next row.
    pub decays: Vec<f64>,
    /// g of each process.
    pub gains: Vec<f64>,
    pub inverse: f64,
    pub variance: f64,
}

impl Clone for Gain {
    fn clone(&self) -> Self {
        Self { decays: self.decays.clone(), gains: self.gains.clone(), ..*self }
    }

    fn clone_from(&mut self, other: &Self) {
        self.decays.clone_from(&other.decays);
        self.gains.clone_from(&other.gains);
        (self.inverse, self.variance) = (other.inverse, other.variance);
    }
}

/// The gains of some rows, each once as long as it stays the same.
#[derive(Clone, Debug, Default)]
pub struct Gains {
    kept: Vec<Gain>,
    /// Which is that of each row.
    which: Vec<usize>,
}

impl Gains {
    /// Those of the next rows of a filter, by the step from each to the one after it.
    pub fn next(&mut self, filter: &mut Filter<'_>, steps_s: impl Iterator<Item = f64>) {
        self.which.clear();
        let mut count = 0;
        for step_s in steps_s {
            if filter.row(step_s) || count == 0 {
                match self.kept.get_mut(count) {
                    // In the room that is there.
                    Some(there) => there.clone_from(&filter.gain),
                    None => self.kept.push(filter.gain.clone()),
                }
                count += 1;
            }
            self.which.push(count - 1);
        }
    }

    /// How many there are.
    pub fn distinct(&self) -> usize {
        self.kept.len()
    }

    /// Σ ln F over the rows.
    pub fn log_variance(&self) -> f64 {
        let logarithms: Vec<f64> = self.kept.iter().map(|gain| gain.variance.ln()).collect();
        self.which.iter().map(|which| logarithms[*which]).sum()
    }

    /// That of a row.
    pub fn of(&self, row: usize) -> &Gain {
        &self.kept[self.which[row]]
    }
}

/// The Kalman filter of the model, as far as it does not depend on the readings (Durbin and Koopman 2012,
/// Time Series Analysis by State Space Methods, chapter 4): the covariance P of the predicted states.
///
/// With M = P z, z all ones: F = zᵀM + σ² is the variance of the innovation, g = φ M/F and P ← φ (P − M Mᵀ/F)
/// φ + s² (1 − φ²). Gains that are steady are kept until the step changes.
pub struct Filter<'a> {
    processes: &'a [Process],
    /// Variance of the step of a random walk, nT²/s, whose state is the last one.
    walk: f64,
    white: f64,
    covariance: Vec<f64>,
    /// Its sums over rows: M.
    sums: Vec<f64>,
    /// s² (1 − φ²) for the step of the row before.
    added: Vec<f64>,
    step_s: f64,
    steady: bool,
    /// What the last row does.
    pub gain: Gain,
}

impl<'a> Filter<'a> {
    pub fn new(processes: &'a [Process], walk: f64, white: f64) -> Self {
        let states = processes.len() + usize::from(walk > 0.0);
        let mut covariance = vec![0.0; states * states];
        for (at, process) in processes.iter().enumerate() {
            covariance[at * (states + 1)] = process.variance_nt2;
        }
        Self {
            processes,
            walk,
            white,
            covariance,
            sums: vec![0.0; states],
            added: vec![0.0; states],
            step_s: f64::NAN,
            steady: false,
            gain: Gain { decays: vec![1.0; states], gains: vec![0.0; states], inverse: 0.0, variance: 0.0 },
        }
    }

    pub fn states(&self) -> usize {
        self.added.len()
    }

    /// Goes on by a row, to the next `step_s` later; whether the gain is another one than before.
    pub fn row(&mut self, step_s: f64) -> bool {
        let same = step_s == self.step_s;
        if same && self.steady {
            return false;
        }
        if !same {
            self.move_by(step_s);
        }
        let states = self.states();
        for (sum, row) in self.sums.iter_mut().zip(self.covariance.chunks_exact(states.max(1))) {
            *sum = row.iter().sum();
        }
        // Never below the white part, whatever is rounded.
        let variance = self.sums.iter().sum::<f64>().max(0.0) + self.white;
        let inverse = 1.0 / variance;
        let (mut largest, mut change) = (0f64, 0f64);
        for ((gain, kept), sum) in self.gain.gains.iter_mut().zip(&self.gain.decays).zip(&self.sums) {
            let new = kept * sum * inverse;
            largest = largest.max(new.abs());
            change = change.max((new - *gain).abs());
            *gain = new;
        }
        let settled = (variance - self.gain.variance).abs() <= STEADY * variance;
        self.steady = same && settled && change <= STEADY * largest;
        self.gain.variance = variance;
        self.gain.inverse = inverse.sqrt();
        let all_kept = &self.gain.decays;
        for (i, row) in self.covariance.chunks_exact_mut(states.max(1)).enumerate() {
            let (own, sum) = (all_kept[i], self.sums[i]);
            for ((value, kept), other) in row.iter_mut().zip(all_kept).zip(&self.sums) {
                *value = own * kept * (*value - sum * other * inverse);
            }
            row[i] += self.added[i];
        }
        true
    }

    fn move_by(&mut self, step_s: f64) {
        self.step_s = step_s;
        let room = self.gain.decays.iter_mut().zip(&mut self.added);
        for ((kept, added), process) in room.zip(self.processes) {
            let product = process.rate_per_s * step_s;
            (*kept, *added) = ((-product).exp(), -process.variance_nt2 * (-2.0 * product).exp_m1());
        }
        if self.walk > 0.0
            && let Some(last) = self.added.last_mut()
        {
            *last = self.walk * step_s;
        }
    }
}

/// The predicted states of some columns side by side.
pub struct States {
    states: Vec<[f64; LANES]>,
    /// Their sums: what the next readings are expected to be.
    sums: [f64; LANES],
    /// None of the readings so far was other than zero.
    zero: bool,
    /// The rows that are whitened now.
    rows: Vec<[f64; LANES]>,
}

impl States {
    pub fn new(states: usize) -> Self {
        Self { states: vec![[0.0; LANES]; states], sums: [0.0; LANES], zero: true, rows: Vec::new() }
    }

    /// Whitens the next rows of at most as many columns as there are lanes.
    pub fn whiten(&mut self, columns: &mut [&mut [f64]], gains: &Gains) {
        self.zero &= columns.iter().all(|column| column.iter().all(|reading| *reading == 0.0));
        if self.zero {
            return;
        }
        let count = columns.first().map_or(0, |column| column.len());
        self.rows.resize(count, [0.0; LANES]);
        for (lane, column) in columns.iter().enumerate() {
            self.rows.iter_mut().zip(column.iter()).for_each(|(row, reading)| row[lane] = *reading);
        }
        Arch::new().dispatch(Rows { states: self, gains });
        for (lane, column) in columns.iter_mut().enumerate() {
            self.rows.iter().zip(column.iter_mut()).for_each(|(row, reading)| *reading = row[lane]);
        }
    }
}

/// The rows of some states, whitened with AVX2 where there is one; the operations are the same without.
struct Rows<'a> {
    states: &'a mut States,
    gains: &'a Gains,
}

impl NullaryFnOnce for Rows<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let States { states, sums, rows, .. } = self.states;
        for (number, row) in rows.iter_mut().enumerate() {
            let gain = self.gains.of(number);
            let innovations: [f64; LANES] = from_fn(|lane| row[lane] - sums[lane]);
            *row = from_fn(|lane| innovations[lane] * gain.inverse);
            let mut sum = [0.0; LANES];
            for ((state, kept), gain) in states.iter_mut().zip(&gain.decays).zip(&gain.gains) {
                let (now, kept, gain) = (*state, *kept, *gain);
                let next: [f64; LANES] = from_fn(|lane| kept * now[lane] + gain * innovations[lane]);
                *state = next;
                sum = from_fn(|lane| sum[lane] + next[lane]);
            }
            *sums = sum;
        }
    }
}
