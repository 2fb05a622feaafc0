//! Intervals of the Whittle fit against the truth, over seeded noise. FLUXCAL_CAMPAIGNS sets over how many
//! trials; the long proof is `FLUXCAL_CAMPAIGNS=1000 cargo test --release -p estimate --test it
//! whittle_coverage:: -- --nocapture`.

use estimate::periodogram::{Periodogram, periodogram};
use estimate::whittle::{Estimate, White, fit};
use noise::Stream;
use std::collections::BTreeMap;

use crate::made::made;

const THREE: [(usize, f64); 3] = [(1440, 60.0), (3600, 1.0), (6000, 0.01)];
const WHITE_RMS: f64 = 0.02;

/// ∫ A f^-α df.
fn integral(amplitude: f64, exponent: f64, low: f64, high: f64) -> f64 {
    if exponent == 1.0 {
        return amplitude * (high / low).ln();
    }
    amplitude * (high.powf(1.0 - exponent) - low.powf(1.0 - exponent)) / (1.0 - exponent)
}

/// Of every quantity the interval, on a logarithmic scale where it is for an amplitude, has to hold the truth
/// in 95 ± 2 % of 1000 series, and as much farther off in fewer as chance makes it.
fn cover(case: &'static str, layout: &[(usize, f64)], amplitude: f64, exponent: f64) {
    let trials = testkit::campaigns(200);
    let mut held: BTreeMap<&str, u64> = BTreeMap::new();
    let (mut unlike, mut bad, mut wrong) = (0, 0, 0);
    let last = layout.len() - 1;
    let (low, high) = (1.0 / (layout[0].0 as f64 * layout[0].1), 0.4 / layout[last].1);
    let rms = integral(amplitude, exponent, low, high).sqrt();
    for number in 0..trials {
        let mut stream = Stream::new(number, case);
        let mut series = |&(count, step_s): &(usize, f64)| {
            let samples = made(&mut stream, (count, step_s), (amplitude, exponent), WHITE_RMS);
            periodogram(&samples, step_s).expect("a periodogram")
        };
        let series: Vec<Periodogram> = layout.iter().map(&mut series).collect();
        let found = fit(&series).expect("a fit");
        unlike += u64::from(found.white != White::PerReading);
        bad += u64::from(found.goodness.is_some_and(|p| p < 0.05));
        wrong += u64::from((found.amplitude.value > 0.0) != (amplitude > 0.0));
        let mut see = |name, truth: f64, (low, high): (f64, f64)| {
            *held.entry(name).or_default() += u64::from((low..=high).contains(&truth));
        };
        let plain = |of: &Estimate| (of.value - 1.96 * of.std, of.value + 1.96 * of.std);
        see("sigma", WHITE_RMS, plain(&found.white_rms[last]));
        if amplitude > 0.0 {
            see("A", amplitude, found.amplitude.log_interval(0.95));
            see("sqrt A", amplitude.sqrt(), found.amplitude.root().log_interval(0.95));
            see("alpha", exponent, plain(&found.exponent));
            see("rms", rms, found.flicker_variance(low, high).root().log_interval(0.95));
        }
    }
    println!(
        "{case}: {unlike} with other white noise, {wrong} with flicker taken wrongly, {bad} of p < 0.05"
    );
    let slack = 0.02 * (1000.0 / trials as f64).sqrt().max(1.0);
    for (name, held) in held {
        let share = held as f64 / trials as f64;
        println!("{case}: {name} {share:.3}");
        assert!((share - 0.95).abs() <= slack, "{case}: {name} {share}");
    }
}

#[test]
fn three_series() {
    cover("three series, alpha 1", &THREE, 1e-4, 1.0);
    cover("three series, alpha 1.4", &THREE, 1e-4, 1.4);
    cover("three series, white", &THREE, 0.0, 1.0);
}

#[test]
fn single_series() {
    cover("one series, alpha 1", &[(2000, 1.0)], 1e-4, 1.0);
    cover("one fast series, alpha 1", &[(2000, 0.01)], 1e-4, 1.0);
    cover("one series, alpha 1.4", &[(2000, 1.0)], 1e-4, 1.4);
    cover("one series, alpha 1.8", &[(2000, 1.0)], 1e-4, 1.8);
    cover("one series, white", &[(2000, 1.0)], 0.0, 1.0);
}
