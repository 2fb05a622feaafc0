//! The columns beside which a drift is sought, and the straight one under the noise of what it leaves.

use common::Column;
use estimate::cosine::{Cosine, Errors, Regression, weighted};

use crate::Error;
use joined::Pair;
use paired::noise::Noise;

/// Fewer samples than these show no exponential.
const LEAST: usize = 64;
/// Rounds of fitting the noise to what is left, and the columns under that noise.
pub const ROUNDS: usize = 3;
/// The shortest time constant: so many steps, and this share of the recording.
const SHORTEST_STEPS: f64 = 10.0;
const SHORTEST: f64 = 1e-3;
/// The longest, in lengths of the recording: beyond it an exponential is a straight line.
const LONGEST: f64 = 3.0;
/// Step of ln τ in the search.
const SEARCH: f64 = 0.2;
/// So many coefficients of an exponential are searched: even of the shortest they hold all but 1e-7 of what
/// white noise lets be known of it.
const SEARCHED: usize = 1 << 17;

/// What one axis has besides the columns that all have.
pub struct Beside<'a> {
    /// Transforms of the housekeeping columns that it follows and of its steps; they stand last among the
    /// columns.
    pub own: &'a [Vec<f64>],
    /// Frequencies of spectral lines, which are not noise, Hz.
    pub lines_hz: &'a [f64],
}

/// The columns of a pair and their transforms; of exponentials over all time constants.
#[derive(Clone)]
pub struct Columns<'a> {
    pub cosine: Cosine,
    pub pair: &'a Pair,
    /// Days from the middle of the recording.
    pub days: Column,
    /// How many coefficients of each transform are used, from the lowest on.
    pub kept: usize,
    /// Transforms of the reference's x, y, z and of the days.
    base: Vec<Column>,
    /// ln τ and the lowest coefficients of the transform of its exponential.
    pub search: Vec<(f64, Column)>,
}

impl<'a> Columns<'a> {
    pub fn of(pair: &'a Pair) -> Self {
        let rows = pair.whole.len();
        let cosine = Cosine::new(rows, pair.step_s);
        let days = Column::from(pair.days());
        let base = pair.reference.iter().map(AsRef::as_ref).chain([days.as_slice()]);
        let base = base.map(|column| Column::from(cosine.transform(column))).collect();
        let mut columns = Self { cosine, pair, days, kept: rows - 1, base, search: Vec::new() };
        if rows >= LEAST {
            let (low, high) = columns.limits();
            let steps = ((high - low) / SEARCH).ceil() as usize;
            let at = |i: usize| low + (high - low) * i as f64 / steps as f64;
            let lowest = |ln_tau: f64| {
                let mut all = columns.cosine.transform(&columns.exponential(ln_tau)[0]);
                all.truncate(SEARCHED);
                all.shrink_to_fit();
                Column::from(all)
            };
            columns.search = (0..=steps).map(|i| (at(i), lowest(at(i)))).collect();
        }
        columns
    }

    pub fn length_s(&self) -> f64 {
        self.days.len() as f64 * self.pair.step_s
    }

    /// Least and greatest ln τ.
    pub fn limits(&self) -> (f64, f64) {
        let shortest = (SHORTEST_STEPS * self.pair.step_s).max(SHORTEST * self.length_s());
        (shortest.ln(), (LONGEST * self.length_s()).ln())
    }

    /// e^(−t/τ) and its derivative with respect to ln τ, t from the first row.
    pub fn exponential(&self, ln_tau: f64) -> [Vec<f64>; 2] {
        let rate = self.pair.step_s * (-ln_tau).exp();
        let factor = (-rate).exp();
        // As products: n roundings are 1e-11 of it, and exponentials of each row would take most of the time.
        let plain: Vec<f64> =
            std::iter::successors(Some(1.0), |e| Some(e * factor)).take(self.days.len()).collect();
        let slope = plain.iter().enumerate().map(|(row, e)| rate * row as f64 * e).collect();
        [plain, slope]
    }

    /// The same with the lowest coefficients of every transform only: the band up to a frequency.
    pub fn up_to(&self, kept: usize) -> Self {
        Self { kept, ..self.clone() }
    }

    /// The coefficients of a series that are used.
    pub fn transform(&self, values: &[f64]) -> Vec<f64> {
        let mut all = self.cosine.transform(values);
        all.truncate(self.kept);
        all
    }

    /// Transforms of the reference's x, y, z and of the days.
    pub fn base(&self) -> Vec<&[f64]> {
        self.base.iter().map(|transform| &transform[..self.kept]).collect()
    }

    /// ln τ and the lowest coefficients of the transform of its exponential.
    pub fn search(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.search.iter().map(|(ln_tau, transform)| (*ln_tau, &transform[..self.kept.min(transform.len())]))
    }

    /// These and others, the axis's own last.
    pub fn with<'b>(&'b self, others: &[&'b [f64]], beside: &Beside<'b>) -> Vec<&'b [f64]> {
        let own = beside.own.iter().map(Vec::as_slice);
        self.base().into_iter().chain(others.iter().copied()).chain(own).collect()
    }

    pub fn noise(&self, regression: &Regression, errors: &Errors, lines_hz: &[f64]) -> Result<Noise, Error> {
        let near = 2.0 / self.length_s();
        let line = |frequency: f64| lines_hz.iter().any(|line| (frequency - line).abs() <= near);
        Noise::by_octaves(self.cosine.ordinates(regression, errors, line), self.pair)
    }

    /// η and the straight drift, under the noise of what they leave.
    pub fn straight(&self, y: &[f64], beside: &Beside<'_>) -> Result<(Regression, Noise), Error> {
        let all = self.with(&[], beside);
        let mut errors = Errors::independent(&self.cosine);
        let mut regression = weighted(&all, y, &errors)?;
        let mut noise = self.noise(&regression, &errors, beside.lines_hz)?;
        for round in 0..=ROUNDS {
            errors = noise.errors(&self.cosine)?;
            regression = weighted(&all, y, &errors)?;
            if round < ROUNDS {
                noise = self.noise(&regression, &errors, beside.lines_hz)?;
            }
        }
        Ok((regression, noise))
    }
}
