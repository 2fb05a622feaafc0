use std::f64::consts::PI;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use common::Noise;

use crate::filter::{Filter, Gain, Gains, LANES, States};
use crate::level::Level;
use crate::sums::Sums;
use crate::{NoiseError, Process, flicker, flicker_of, steps};

/// Rows that are whitened at a time.
const ROWS: usize = 256;
/// Most numbers that are kept of the gains.
const KEPT: usize = 1 << 22;
/// Most steps that the longest period may have.
const MOST_STEPS: f64 = 1e12;
/// White variance of a reading at least, as a part of that of noise with the model's density at the Nyquist
/// frequency: readings at equal times without white noise would be known exactly.
const LEAST_WHITE: f64 = 1e-9;

/// Whitening of readings by their declared noise, in one pass over the rows, at any times in order.
///
/// reading = Σ_j x_j(t) + w(t) + white: Ornstein–Uhlenbeck processes x_j whose sampled density at the typical
/// (median) step is A f^-α within 1 % from one over the longest period to half the Nyquist frequency (in the
/// last octave below that, within 15 %), a random walk w that is zero at the first row, and white noise. A
/// Kalman filter gives each reading's departure from what all before it predict, over its standard deviation:
/// L⁻¹ y, for the covariance L Lᵀ of the model. It takes O(rows).
///
/// Missing readings are rows that are not there. Steps within a thousandth of the typical one count as equal
/// to it.
#[derive(Clone, Debug)]
pub struct Whitening {
    rows: usize,
    /// Steps from each row to the next, s; none where only white noise counts.
    steps_s: Arc<[f64]>,
    processes: Arc<[Process]>,
    /// r², nT²/s.
    walk: f64,
    /// nT².
    white: f64,
    level: Option<Level>,
    /// What the filter does to each row, block by block, once it is known.
    gains: Arc<OnceLock<Option<Vec<Gains>>>>,
}

impl Whitening {
    /// Of a declared noise at the times of the rows; flicker noise levels off at periods longer than
    /// `oldest_s`.
    ///
    /// Without times, or where all are one, only white noise counts. Refused are exponents outside 0 … 2,
    /// times out of order, a longest period that is none or of more than 10¹² steps, and a noise of zero.
    pub fn of(noise: &Noise, time_s: Option<&[f64]>, rows: usize, oldest_s: f64) -> Result<Self, NoiseError> {
        Self::of_sum(std::slice::from_ref(noise), time_s, rows, oldest_s)
    }

    /// Whether it whitens as another does.
    pub fn same(&self, other: &Self) -> bool {
        (self.rows, self.walk, self.white) == (other.rows, other.walk, other.white)
            && self.processes == other.processes
            && self.level == other.level
            && self.steps_s == other.steps_s
    }

    /// Of the sum of several independent noises, otherwise as [`Whitening::of`].
    pub fn of_sum(
        noises: &[Noise],
        time_s: Option<&[f64]>,
        rows: usize,
        oldest_s: f64,
    ) -> Result<Self, NoiseError> {
        let flickers: Vec<(f64, f64)> =
            noises.iter().filter_map(|noise| flicker_of(noise).transpose()).collect::<Result<_, _>>()?;
        let squares = |of: fn(&Noise) -> Option<f64>| -> f64 {
            noises.iter().map(|noise| of(noise).unwrap_or(0.0).powi(2)).sum()
        };
        let walk = squares(|noise| noise.random_walk_nt_per_sqrt_s);
        let mut whitening = Self {
            rows,
            steps_s: Arc::default(),
            processes: Arc::default(),
            walk: 0.0,
            white: squares(|noise| noise.white_rms_nt),
            level: None,
            gains: Arc::default(),
        };
        let memory = walk > 0.0 || !flickers.is_empty();
        let times = time_s.filter(|time| time.len() == rows && rows > 1 && memory);
        if let Some((steps, typical)) = times.map(steps).transpose()?.filter(|(_, step)| *step > 0.0) {
            let count = oldest_s / typical;
            let possible = flickers.is_empty() || (count > 0.0 && count <= MOST_STEPS);
            if !possible {
                return Err(NoiseError::Length(oldest_s, typical));
            }
            let mut processes: Vec<Process> = Vec::new();
            for (amplitude, exponent) in flickers {
                let (sum, white) = flicker::sum(amplitude, exponent, typical, oldest_s);
                whitening.white += white;
                for one in sum {
                    // The corners depend on the steps and the longest period alone.
                    match processes.iter_mut().find(|other| other.rate_per_s == one.rate_per_s) {
                        Some(other) => other.variance_nt2 += one.variance_nt2,
                        None => processes.push(one),
                    }
                }
            }
            whitening.processes = processes.into();
            whitening.walk = walk;
            let nyquist = whitening.sampled_density(0.5 / typical, typical) / (2.0 * typical);
            whitening.white = whitening.white.max(LEAST_WHITE * nyquist);
            whitening.steps_s = steps.into();
        }
        if whitening.white > 0.0 { Ok(whitening) } else { Err(NoiseError::Nothing) }
    }

    /// Of processes and white noise (variance of a reading, nT²) that are known.
    ///
    /// Errors: times out of order; no white noise.
    pub fn of_processes(processes: Vec<Process>, white: f64, time_s: &[f64]) -> Result<Self, NoiseError> {
        let known = Noise { white_rms_nt: Some(white.sqrt()), ..Noise::default() };
        let mut whitening = Self::of(&known, None, time_s.len(), 0.0)?;
        let (steps, typical) = steps(time_s)?;
        if !processes.is_empty() && typical > 0.0 {
            whitening.processes = processes.into();
            whitening.steps_s = steps.into();
        }
        Ok(whitening)
    }

    /// How many readings it whitens.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The same where the mean of the readings is known: zero within a standard uncertainty.
    pub fn with_level(mut self, std_nt: f64) -> Self {
        self.level = None;
        let weight = 1.0 / (self.rows as f64 * std_nt);
        let sums: Vec<f64> = self.of_ones().iter().map(|sum| weight * sum).collect();
        self.level = Some(Level::of(&self.whiten(&sums), weight));
        self
    }

    /// Covariance of each reading with the sum of all, nT².
    fn of_ones(&self) -> Vec<f64> {
        let mut all = vec![self.white; self.rows];
        for process in self.processes.iter() {
            let (mut before, mut after) = (0.0, 0.0);
            for row in 0..self.rows {
                let other = self.rows - 1 - row;
                all[row] += process.variance_nt2 * (before + 1.0);
                all[other] += process.variance_nt2 * after;
                before = (before + 1.0) * (-process.rate_per_s * self.step(row)).exp();
                if other > 0 {
                    after = (after + 1.0) * (-process.rate_per_s * self.step(other - 1)).exp();
                }
            }
        }
        if self.walk > 0.0 {
            let (mut time, mut sum) = (0.0, 0.0);
            for (row, all) in all.iter_mut().enumerate() {
                sum += time;
                *all += self.walk * (sum + (self.rows - 1 - row) as f64 * time);
                time += self.step(row);
            }
        }
        all
    }

    /// Whether readings are independent of each other.
    pub fn is_white(&self) -> bool {
        self.processes.is_empty() && self.walk == 0.0
    }

    /// The processes of the sum.
    pub fn processes(&self) -> &[Process] {
        &self.processes
    }

    /// Variance of the white part of a reading, nT².
    pub fn white_nt2(&self) -> f64 {
        self.white
    }

    /// One-sided density of the processes and the random walk, nT²/Hz: Σ 4 s² λ/(λ² + (2πf)²) + r²/(2π²f²).
    /// White noise, which readings have and not the time between them, is not in it.
    pub fn density(&self, frequency_hz: f64) -> f64 {
        let walk = if self.walk > 0.0 { self.walk / (2.0 * (PI * frequency_hz).powi(2)) } else { 0.0 };
        self.processes.iter().map(|process| process.density(frequency_hz)).sum::<f64>() + walk
    }

    /// One-sided density of readings `step_s` apart, nT²/Hz, with all noise: see
    /// [`Process::sampled_density`]; 2 σ² Δt of the white part, and r² Δt²/(2 sin² πfΔt) of the random walk.
    pub fn sampled_density(&self, frequency_hz: f64, step_s: f64) -> f64 {
        let sine = (PI * frequency_hz * step_s).sin();
        let walk = if self.walk > 0.0 { self.walk * (step_s / sine).powi(2) / 2.0 } else { 0.0 };
        let processes = self.processes.iter().map(|process| process.sampled_density(frequency_hz, step_s));
        processes.sum::<f64>() + walk + 2.0 * self.white * step_s
    }

    /// The series whitened: innovations over their standard deviations.
    pub fn whiten(&self, series: &[f64]) -> Vec<f64> {
        let mut column = series.to_vec();
        self.whiten_all(&mut [&mut column]);
        column
    }

    /// Whitens each column in place, all by the same gains; each becomes what it becomes alone, to the bit.
    ///
    /// Panics where a column has another number of rows.
    pub fn whiten_all<C: AsMut<[f64]>>(&self, columns: &mut [C]) {
        if self.whitens_white(columns) {
            return;
        }
        let known: Vec<f64> = match &self.level {
            Some(level) => columns.iter_mut().map(|column| level.known(column.as_mut())).collect(),
            None => Vec::new(),
        };
        let mut states = self.states(columns.len());
        self.by_blocks(|rows, gains| {
            for (group, states) in columns.chunks_mut(LANES).zip(&mut states) {
                let mut some: Vec<&mut [f64]> =
                    group.iter_mut().map(|column| &mut column.as_mut()[rows.clone()]).collect();
                states.whiten(&mut some, gains);
            }
        });
        if let Some(level) = &self.level {
            columns.iter_mut().zip(known).for_each(|(column, known)| level.add(known, column.as_mut()));
        }
    }

    /// Whitens columns block by block without keeping them. `each` gets the rows of one block, column after column. A known
    /// mean is ignored.
    ///
    /// Panics where a column has another number of rows.
    pub fn by_rows<C: AsRef<[f64]>>(&self, columns: &[C], mut each: impl FnMut(&[f64])) {
        assert!(columns.iter().all(|column| column.as_ref().len() == self.rows), "rows of a column");
        let mut states = self.states(columns.len());
        let mut some = Vec::new();
        self.by_blocks(|rows, gains| {
            some.clear();
            columns.iter().for_each(|column| some.extend_from_slice(&column.as_ref()[rows.clone()]));
            let mut all: Vec<&mut [f64]> = some.chunks_mut(rows.len()).collect();
            for (group, states) in all.chunks_mut(LANES).zip(&mut states) {
                states.whiten(group, gains);
            }
            each(&some);
        });
    }

    fn states(&self, columns: usize) -> Vec<States> {
        let count = self.filter().states();
        (0..columns.div_ceil(LANES)).map(|_| States::new(count)).collect()
    }

    /// Whitens columns where readings are independent, and says whether they are.
    pub(crate) fn whitens_white<C: AsMut<[f64]>>(&self, columns: &mut [C]) -> bool {
        for column in columns.iter_mut() {
            assert_eq!(column.as_mut().len(), self.rows, "rows of a column");
        }
        if self.is_white() {
            let deviation = self.white.sqrt();
            columns.iter_mut().flat_map(|column| column.as_mut()).for_each(|reading| *reading /= deviation);
        }
        self.is_white()
    }

    /// Goes through the rows from the last to the first.
    pub(crate) fn backwards(&self, mut each: impl FnMut(usize, &Gain)) {
        let computed;
        let gains = match self.gains() {
            Some(gains) => gains,
            None => {
                computed = self.computed(usize::MAX).unwrap_or_default();
                &computed
            }
        };
        (0..self.rows).rev().for_each(|row| each(row, gains[row / ROWS].of(row % ROWS)));
    }

    /// Σ_j C(s, t_j) v_j of each series v at this noise's times t, at others s: with v = C⁻¹ y the most likely noise
    /// there. White noise tells nothing of other times. Both in order.
    pub fn most_likely(&self, time_s: &[f64], all_v: &[Vec<f64>], at_s: &[f64]) -> Vec<Vec<f64>> {
        all_v.chunks(LANES).flat_map(|some| self.most_likely_of_some(time_s, some, at_s)).collect()
    }

    fn most_likely_of_some(&self, time_s: &[f64], some: &[Vec<f64>], at_s: &[f64]) -> Vec<Vec<f64>> {
        let rows = time_s.len();
        let of_row = |row: usize| -> [f64; LANES] {
            std::array::from_fn(|lane| some.get(lane).map_or(0.0, |v| v[row]))
        };
        let mut all = vec![vec![0.0; at_s.len()]; some.len()];
        let mut add = |at: usize, values: [f64; LANES]| {
            all.iter_mut().zip(values).for_each(|(own, value)| own[at] += value);
        };
        // Readings up to each time, from the first on; then those after it, from the last on.
        let (mut sums, mut next) = (Sums::of(&self.processes), 0);
        for (place, at) in at_s.iter().enumerate() {
            while next < rows && time_s[next] <= *at {
                sums.add(time_s[next], of_row(next));
                next += 1;
            }
            add(place, sums.at(*at));
        }
        let (mut sums, mut left) = (Sums::of(&self.processes), rows);
        for (place, at) in at_s.iter().enumerate().rev() {
            while left > 0 && time_s[left - 1] > *at {
                left -= 1;
                sums.add(-time_s[left], of_row(left));
            }
            add(place, sums.at(-at));
        }
        if self.walk > 0.0 {
            // r² Σ_j v_j min(s, t_j), times from the first row on.
            let first = time_s.first().copied().unwrap_or(0.0);
            for (own, v) in all.iter_mut().zip(some) {
                let (mut before, mut after, mut next) = (0.0, v.iter().sum::<f64>(), 0);
                for (own, at) in own.iter_mut().zip(at_s) {
                    while next < rows && time_s[next] <= *at {
                        before += v[next] * (time_s[next] - first);
                        after -= v[next];
                        next += 1;
                    }
                    *own += self.walk * (before + after * (at - first).max(0.0));
                }
            }
        }
        all
    }

    pub(crate) fn filter(&self) -> Filter<'_> {
        Filter::new(&self.processes, self.walk, self.white)
    }

    /// Goes through the rows in blocks, with the gains of each.
    fn by_blocks(&self, mut each: impl FnMut(Range<usize>, &Gains)) {
        let kept = self.gains();
        let mut filter = self.filter();
        let mut some = Gains::default();
        for (block, from) in (0..self.rows).step_by(ROWS).enumerate() {
            let rows = from..(from + ROWS).min(self.rows);
            match kept {
                Some(all) => each(rows, &all[block]),
                None => {
                    some.next(&mut filter, rows.clone().map(|row| self.step(row)));
                    each(rows, &some);
                }
            }
        }
    }

    /// The gains of all rows, where there is room; at equal steps most rows share one.
    fn gains(&self) -> Option<&[Gains]> {
        self.gains.get_or_init(|| self.computed(KEPT)).as_deref()
    }

    /// The gains of all rows; none where they are more numbers than `most`.
    fn computed(&self, most: usize) -> Option<Vec<Gains>> {
        let mut filter = self.filter();
        let of_one = 2 * filter.states() + 2;
        let (mut all, mut numbers) = (Vec::new(), 0);
        for from in (0..self.rows).step_by(ROWS) {
            let mut gains = Gains::default();
            let rows = from..(from + ROWS).min(self.rows);
            numbers += rows.len();
            gains.next(&mut filter, rows.map(|row| self.step(row)));
            numbers += gains.distinct() * of_one;
            if numbers > most {
                return None;
            }
            all.push(gains);
        }
        Some(all)
    }

    /// ln det of the covariance: Σ ln F, F the variances of the innovations (nT²).
    pub fn log_determinant(&self) -> f64 {
        if self.is_white() {
            return self.rows as f64 * self.white.ln();
        }
        let mut sum = 0.0;
        self.by_blocks(|_, gains| sum += gains.log_variance());
        sum - self.level.as_ref().map_or(0.0, Level::log_determinant)
    }

    /// What a departure of 1 nT in the middle row alone is whitened to, from its row on (1/nT).
    pub fn response(&self) -> Vec<f64> {
        let middle = self.rows / 2;
        let mut series = vec![0.0; self.rows];
        series.iter_mut().skip(middle).take(1).for_each(|reading| *reading = 1.0);
        self.whiten(&series).split_off(middle)
    }

    /// Variance of a reading about the mean of its recording, nT²: the expected mean of (y_i − ȳ)² over the
    /// rows, (tr C − 1ᵀC1/n)/n of the covariance C, in one pass.
    pub fn variance_nt2(&self) -> f64 {
        let rows = self.rows as f64;
        let mut variance = self.white * (1.0 - 1.0 / rows.max(1.0));
        for process in self.processes.iter() {
            // Mean of 1 − exp(−λ|τ|) over all pairs of rows, each by what is lost from its forerunner.
            let (mut lost, mut sum) = (0.0, 0.0);
            for (before, step) in self.steps_s.iter().enumerate() {
                let product = process.rate_per_s * step;
                lost = (-product).exp() * lost - (before as f64 + 1.0) * (-product).exp_m1();
                sum += lost;
            }
            variance += process.variance_nt2 * 2.0 * sum / (rows * rows);
        }
        // (tr C − 1ᵀC1/n)/n is half the mean of (y_i − y_j)², for a walk half that of r²|t_i − t_j|.
        let pairs = self
            .steps_s
            .iter()
            .enumerate()
            .map(|(row, step)| (row as f64 + 1.0) * (rows - row as f64 - 1.0) * step);
        variance + self.walk * pairs.sum::<f64>() / (rows * rows).max(1.0)
    }

    /// Covariance of the readings under the model, rows of rows, nT²; without what is known of their mean.
    pub fn covariance(&self) -> Vec<f64> {
        let mut times = vec![0.0; self.rows];
        for (row, step) in self.steps_s.iter().enumerate() {
            times[row + 1] = times[row] + step;
        }
        let mut all = vec![0.0; self.rows * self.rows];
        for i in 0..self.rows {
            for j in 0..self.rows {
                let lag = (times[i] - times[j]).abs();
                let parts = self.processes.iter().map(|p| p.variance_nt2 * (-p.rate_per_s * lag).exp());
                all[i * self.rows + j] = parts.sum::<f64>() + self.walk * times[i].min(times[j]);
            }
            all[i * (self.rows + 1)] += self.white;
        }
        all
    }

    /// From a row to the next; none after the last, which keeps the gains of a steady filter.
    fn step(&self, row: usize) -> f64 {
        self.steps_s.get(row).or(self.steps_s.last()).copied().unwrap_or(0.0)
    }
}
