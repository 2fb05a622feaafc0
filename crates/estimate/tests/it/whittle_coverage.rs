//! Intervals of the Whittle fit against the truth, over seeded noise. FLUXCAL_CAMPAIGNS sets over how many
//! trials; the long proof is `FLUXCAL_CAMPAIGNS=1000 cargo test --release -p estimate --test it
//! whittle_coverage:: -- --nocapture`.

use estimate::periodogram::{Periodogram, periodogram};
use estimate::whittle::{Estimate, White, fit};
use noise::{Stream, power_law};

const THREE: [(usize, f64); 3] = [(1440, 60.0), (3600, 1.0), (6000, 0.01)];
const WHITE_RMS: f64 = 0.02;

fn trials() -> usize {
    testkit::campaigns(200) as usize
}

/// A series has been cut out of a record of so many times its length, as every real one is.
const LONGER: usize = 16;

fn make(stream: &mut Stream, count: usize, step_s: f64, amplitude: f64, exponent: f64) -> Periodogram {
    let mut samples = power_law(stream, LONGER * count, step_s, amplitude, exponent);
    samples.truncate(count);
    samples.iter_mut().for_each(|x| *x += WHITE_RMS * stream.normal());
    periodogram(&samples, step_s).expect("a periodogram")
}

/// How often an interval held the truth, plain and on a logarithmic scale.
struct Counted {
    name: &'static str,
    log_scale: bool,
    plain: usize,
    logarithmic: usize,
}

struct Coverage {
    case: &'static str,
    counted: Vec<Counted>,
    trials: usize,
}

impl Coverage {
    fn new(case: &'static str) -> Self {
        Coverage { case, counted: Vec::new(), trials: 0 }
    }

    fn see(&mut self, name: &'static str, truth: f64, found: &Estimate, log_scale: bool) {
        if !self.counted.iter().any(|counted| counted.name == name) {
            self.counted.push(Counted { name, log_scale, plain: 0, logarithmic: 0 });
        }
        let counted = self.counted.iter_mut().find(|counted| counted.name == name).expect("just put there");
        let holds = |(low, high): (f64, f64)| usize::from((low..=high).contains(&truth));
        counted.plain += holds(found.interval(0.95));
        counted.logarithmic += holds(found.log_interval(0.95));
    }

    /// The share has to be 95 ± 2 % in 1000 trials, and as much farther off in fewer as chance makes it.
    fn check(&self) {
        let slack = 0.02 * (1000.0 / self.trials as f64).sqrt().max(1.0);
        for counted in &self.counted {
            let share = |count: usize| count as f64 / self.trials as f64;
            let (plain, logarithmic) = (share(counted.plain), share(counted.logarithmic));
            println!("{}: {} {plain:.3}, log scale {logarithmic:.3}", self.case, counted.name);
            let used = if counted.log_scale { logarithmic } else { plain };
            assert!((used - 0.95).abs() <= slack, "{}: {} {used}", self.case, counted.name);
        }
    }
}

/// ∫ A f^-α df.
fn integral(amplitude: f64, exponent: f64, low: f64, high: f64) -> f64 {
    if exponent == 1.0 {
        return amplitude * (high / low).ln();
    }
    amplitude * (high.powf(1.0 - exponent) - low.powf(1.0 - exponent)) / (1.0 - exponent)
}

fn cover(case: &'static str, layout: &[(usize, f64)], amplitude: f64, exponent: f64) {
    let mut coverage = Coverage::new(case);
    let (mut unlike, mut bad, mut none) = (0, 0, 0);
    let last = layout.len() - 1;
    let step_s = layout[last].1;
    let (low, high) = (1.0 / (layout[0].0 as f64 * layout[0].1), 0.4 / step_s);
    let variance = integral(amplitude, exponent, low, high) + 2.0 * WHITE_RMS.powi(2) * step_s * (high - low);
    for number in 0..trials() {
        let mut stream = Stream::new(number as u64, case);
        let series: Vec<Periodogram> =
            layout.iter().map(|&(n, step_s)| make(&mut stream, n, step_s, amplitude, exponent)).collect();
        let found = fit(&series).expect("a fit");
        coverage.trials += 1;
        unlike += usize::from(found.white != White::PerReading);
        bad += usize::from(found.goodness.is_some_and(|p| p < 0.05));
        coverage.see("sigma", WHITE_RMS, &found.white_rms[last], false);
        if amplitude > 0.0 {
            none += usize::from(found.amplitude_upper.is_some());
            coverage.see("A", amplitude, &found.amplitude, true);
            coverage.see("sqrt A", amplitude.sqrt(), &found.amplitude.root(), true);
            coverage.see("alpha", exponent, &found.exponent, false);
            coverage.see("rms", variance.sqrt(), &found.band_variance(last, step_s, low, high).root(), true);
        } else {
            none += usize::from(found.amplitude_upper.is_none());
        }
    }
    println!("{case}: {unlike} with other white noise, {none} with flicker taken wrongly, {bad} of p < 0.05");
    coverage.check();
}

#[test]
fn three_series_of_pink_noise() {
    cover("three series, alpha 1", &THREE, 1e-4, 1.0);
}

#[test]
fn three_series_of_steeper_noise() {
    cover("three series, alpha 1.4", &THREE, 1e-4, 1.4);
}

#[test]
fn three_series_of_white_noise() {
    cover("three series, white", &THREE, 0.0, 1.0);
}

#[test]
fn single_series_of_pink_noise() {
    cover("one series, alpha 1", &[(2000, 1.0)], 1e-4, 1.0);
    cover("one fast series, alpha 1", &[(2000, 0.01)], 1e-4, 1.0);
}

#[test]
fn single_series_of_steeper_noise() {
    cover("one series, alpha 1.4", &[(2000, 1.0)], 1e-4, 1.4);
    cover("one series, alpha 1.8", &[(2000, 1.0)], 1e-4, 1.8);
}

#[test]
fn single_series_of_white_noise() {
    cover("one series, white", &[(2000, 1.0)], 0.0, 1.0);
}
