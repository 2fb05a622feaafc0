//! A straight drift against noise alone, by the engine `explain`.

use common::{DriftExplanations, Quantity};
use estimate::stats;
use explain::{Cause, Form, Problem};
use joined::{DAY_S, Pair};

use super::joint::LEVEL;
use crate::Error;

/// A drift is as slow as can be: means of rows show it as well, and so many are enough.
const MEANS: usize = 2_048;
/// A drift is one with at least this probability.
const NAMED: f64 = 0.9;

/// Weighs a straight drift of readings beside the reference and other columns under noise of many forms; None
/// of short recordings.
pub fn weighed(pair: &Pair, test: &[f64], columns: &[&[f64]]) -> Result<Option<DriftExplanations>, Error> {
    if pair.samples() < paired::LEAST {
        return Ok(None);
    }
    let each = test.len().div_ceil(MEANS);
    let means = |values: &[f64]| -> Vec<f64> { values.chunks(each).map(stats::mean).collect() };
    let problem = Problem {
        time_s: means(&pair.times_s()),
        channels: vec![means(test)],
        base: pair.reference.iter().map(AsRef::as_ref).chain(columns.iter().copied()).map(means).collect(),
        noisy: pair.reference.len(),
        ..Problem::default()
    };
    let (gain, amplitudes) = explain::weigh(&problem, &[(Cause::Time, Form::default())])?;
    let slope = amplitudes.first().and_then(|one| one.first().first().cloned()).unwrap_or_default();
    let nt_per_day = Quantity::new(DAY_S * slope.value(), DAY_S * slope.std().unwrap_or(f64::INFINITY));
    let drift = 1.0 / (1.0 + (-gain).exp());
    Ok(Some(DriftExplanations {
        drift,
        noise_alone: 1.0 - drift,
        straight_nt_per_day: nt_per_day,
        ..DriftExplanations::default()
    }))
}

/// A slope that was fitted, with its uncertainty over all forms of noise, and the probability of as great a one
/// by chance; None where it is no drift.
pub fn named(weighed: &DriftExplanations, slope: f64) -> Option<(Quantity, f64)> {
    let std = weighed.straight_nt_per_day.std().unwrap_or(f64::INFINITY);
    let p = stats::two_sided_p(slope / std, f64::INFINITY);
    (weighed.drift >= NAMED && p < LEVEL).then(|| (Quantity::new(slope, std), p))
}
