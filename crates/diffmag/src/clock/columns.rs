//! What a look at the clocks fits: the field's rate of change, and drifts.

use estimate::resample::resample;

use crate::drift::days;
use crate::series::Pair;

/// Time constants of the drifts that a look takes off, as shares of the length; fewer rows than these have none.
const DRIFTS: [f64; 4] = [0.5, 0.15, 0.045, 0.0135];
const LEAST_FOR_DRIFTS: usize = 512;
/// Samples between a row and the places whose difference gives the slope.
const BESIDE: f64 = 0.1;

/// A straight drift, and exponential ones enough to take off any that comes to rest: else its beginning would be taken for steps.
pub fn drifts(pair: &Pair) -> Vec<Vec<f64>> {
    let rows = pair.whole.len();
    let exponential = |share: &f64| -> Vec<f64> {
        let factor = (-1.0 / (share * rows as f64)).exp();
        std::iter::successors(Some(1.0), |e| Some(e * factor)).take(rows).collect()
    };
    let shares: &[f64] = if rows < LEAST_FOR_DRIFTS { &[] } else { &DRIFTS };
    std::iter::once(days(pair)).chain(shares.iter().map(exponential)).collect()
}

/// The field Rη along an axis.
pub fn turned(reference: &[Vec<f64>; 3], eta: &[f64; 3]) -> Vec<f64> {
    (0..reference[0].len()).map(|row| (0..3).map(|i| eta[i] * reference[i][row]).sum()).collect()
}

/// −dB/dt of the field Rη along an axis, and that times the time from the middle of the segment in 10⁶ s; `slopes` are those of the reference.
pub fn clock_columns(pair: &Pair, slopes: &[Vec<f64>; 3], eta: &[f64; 3]) -> [Vec<f64>; 2] {
    let late: Vec<f64> = turned(slopes, eta).iter().map(|rate| -rate).collect();
    let fast = late
        .iter()
        .enumerate()
        .map(|(row, late)| late * pair.since_middle_of_segment_s(row) * 1e-6)
        .collect();
    [late, fast]
}

/// dB/dt of the reference's axes by the difference over a fifth of a step of the band-limited interpolation, nT/s: within 2 % up to half the
/// sampling rate. Differences of whole steps would fall short by more than half where the field says most about the clock.
pub fn slopes(pair: &Pair) -> [Vec<f64>; 3] {
    let beside = |by: f64| {
        let places: Vec<f64> = (0..pair.whole.len()).map(|row| row as f64 + by).collect();
        resample(&pair.reference, &places, 1.0).columns
    };
    let (before, mut after) = rayon::join(|| beside(-BESIDE), || beside(BESIDE));
    for (after, before) in after.iter_mut().zip(before) {
        for (after, before) in after.iter_mut().zip(before) {
            let rate = (*after - before) / (2.0 * BESIDE * pair.step_s);
            // Beyond the ends nothing is known.
            *after = if rate.is_finite() { rate } else { 0.0 };
        }
    }
    <[Vec<f64>; 3]>::try_from(after).unwrap_or_default()
}

/// The same with nothing in rows that are not whole: readings that were filled in say nothing of the clock, and a reading filled in with a wrong
/// clock would confirm that one.
pub fn seen_slopes(pair: &Pair) -> [Vec<f64>; 3] {
    let mut slopes = slopes(pair);
    for slope in &mut slopes {
        slope.iter_mut().zip(&pair.whole).filter(|(_, whole)| !**whole).for_each(|(value, _)| *value = 0.0);
    }
    slopes
}
