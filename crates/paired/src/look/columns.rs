//! What a look at the clocks fits: the field's rate of change, and drifts.

use estimate::resample::resample;
use std::borrow::Cow;

use joined::Pair;

/// Time constants of the drifts that a look takes off, as shares of the length; fewer rows than these have
/// none.
const DRIFTS: [f64; 4] = [0.5, 0.15, 0.045, 0.0135];
const LEAST_FOR_DRIFTS: usize = 512;
/// Samples between a row and the places whose difference gives the slope.
const BESIDE: f64 = 0.1;

/// A straight drift, and exponential ones enough to take off any that comes to rest: else its beginning would
/// be taken for steps.
pub fn drifts(pair: &Pair) -> impl Iterator<Item = Vec<f64>> {
    let rows = pair.whole.len();
    let exponential = move |share: &f64| -> Vec<f64> {
        let factor = (-1.0 / (share * rows as f64)).exp();
        std::iter::successors(Some(1.0), |e| Some(e * factor)).take(rows).collect()
    };
    let shares: &[f64] = if rows < LEAST_FOR_DRIFTS { &[] } else { &DRIFTS };
    std::iter::once_with(|| pair.days()).chain(shares.iter().map(exponential))
}

pub fn beside(pair: &Pair) -> impl Iterator<Item = Cow<'_, [f64]>> {
    let reference = pair.reference.iter().map(|column| Cow::Borrowed(column.as_slice()));
    reference.chain(drifts(pair).map(Cow::Owned))
}

pub fn turned<C: AsRef<[f64]>>(reference: &[C; 3], eta: &[f64; 3]) -> Vec<f64> {
    let [x, y, z] = reference.each_ref().map(AsRef::as_ref);
    x.iter().zip(y).zip(z).map(|((x, y), z)| eta[0] * x + eta[1] * y + eta[2] * z).collect()
}

/// −dB/dt of a field that changes at this rate, and that times the time from the middle of the segment in 10⁶
/// s.
pub fn clock_columns(pair: &Pair, rate: &[f64]) -> [Vec<f64>; 2] {
    let late: Vec<f64> = rate.iter().map(|rate| -rate).collect();
    let fast = |(row, late): (usize, &f64)| late * pair.since_middle_of_segment_s(row) * 1e-6;
    let fast = late.iter().enumerate().map(fast).collect();
    [late, fast]
}

/// dB/dt of a field by the difference over a fifth of a step of the band-limited interpolation, nT/s: within
/// 2 % up to half the sampling rate. Differences of whole steps would fall short by more than half where the
/// field says most about the clock.
pub fn rate(pair: &Pair, field: &[f64]) -> Vec<f64> {
    let beside = |by: f64| {
        let places: Vec<f64> = (0..field.len()).map(|row| row as f64 + by).collect();
        resample(&[field], &places, 1.0).columns.swap_remove(0)
    };
    let (before, mut after) = rayon::join(|| beside(-BESIDE), || beside(BESIDE));
    for (after, before) in after.iter_mut().zip(before) {
        let rate = (*after - before) / (2.0 * BESIDE * pair.step_s);
        // Beyond the ends nothing is known.
        *after = if rate.is_finite() { rate } else { 0.0 };
    }
    after
}

/// The same with nothing in rows that are not whole: readings that were filled in say nothing of the clock,
/// and a reading filled in with a wrong clock would confirm that one.
pub fn seen_rate(pair: &Pair, field: &[f64]) -> Vec<f64> {
    let mut rate = rate(pair, field);
    rate.iter_mut().zip(&pair.whole).filter(|(_, whole)| !**whole).for_each(|(value, _)| *value = 0.0);
    rate
}
