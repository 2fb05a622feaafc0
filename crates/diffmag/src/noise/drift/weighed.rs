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

#[cfg(test)]
mod tests {
    use super::*;
    use joined::Segment;
    use noise::{Stream, power_law};
    use rayon::prelude::*;

    const ROWS: usize = 1024;
    const STEP_S: f64 = 60.0;
    const SEEDS: u64 = 40;
    /// Of pairs without a drift fewer show the same.
    const WITHOUT: u64 = 20;

    /// A field that wanders beside white noise and noise of 1/f^α, and a drift; what is known of the drift.
    fn known(seed: u64, exponent: f64, nt_per_day: f64) -> DriftExplanations {
        let mut stream = Stream::new(seed, "weighed");
        let mut field = || -> Vec<f64> {
            let walk = power_law(&mut stream, ROWS, STEP_S, 1e-4, 2.0);
            walk.into_iter().map(|b| 20_000.0 + b).collect()
        };
        let reference = [field(), field(), field()];
        // As much as the white noise at a period of 100 rows.
        let amplitude = 2.0 * STEP_S * 0.1_f64.powi(2) * (0.01 / STEP_S).powf(exponent);
        let own = power_law(&mut stream, ROWS, STEP_S, amplitude, exponent);
        let read = |row: usize| {
            let turned = 1.001 * reference[0][row] + 0.004 * reference[1][row];
            turned + own[row] + nt_per_day * row as f64 * STEP_S / DAY_S
        };
        let test: Vec<f64> = (0..ROWS).map(|row| read(row) + 0.1 * stream.normal()).collect();
        let pair = Pair {
            step_s: STEP_S,
            reference: reference.map(Into::into),
            whole: vec![true; ROWS],
            segments: vec![Segment { rows: 0..ROWS, late_s: 0.0 }],
            ..Pair::default()
        };
        weighed(&pair, &test, &[]).expect("weighed").expect("enough rows")
    }

    fn all(seeds: u64, exponent: f64, nt_per_day: f64) -> Vec<DriftExplanations> {
        (0..seeds).into_par_iter().map(|seed| known(seed, exponent, nt_per_day)).collect()
    }

    #[test]
    fn noise_alone_is_seldom_taken_for_a_drift() {
        for exponent in [0.0, 1.0, 1.5, 2.0] {
            let sure = all(WITHOUT, exponent, 0.0).iter().filter(|one| one.drift >= NAMED).count();
            println!("1/f^{exponent}: {sure} of {WITHOUT} drifts");
            assert!(sure <= 1, "{exponent}: {sure}");
        }
    }

    #[test]
    fn a_drift_is_seen_in_noise_that_does_not_wander_as_far() {
        for exponent in [0.0, 1.0] {
            let found = all(SEEDS, exponent, 1.5);
            let sure = found.iter().filter(|one| one.drift >= NAMED).count();
            let within = |of: &&DriftExplanations| {
                let slope = &of.straight_nt_per_day;
                (slope.value() - 1.5).abs() < 1.96 * slope.std().expect("a std")
            };
            let held = found.iter().filter(within).count();
            println!("1/f^{exponent}: {sure} of {SEEDS} seen, {held} within the 95 % interval");
            assert!(
                sure as f64 > 0.9 * SEEDS as f64 && testkit::agrees(held, SEEDS as usize, [0.92, 0.98], 2)
            );
        }
    }
}
