//! The periodogram: its ordinates add up to the variance; spectral lines are found with their frequency and
//! amplitude, not found where there are none, and no part of the noise that is left.

use estimate::periodogram::{Line, Periodogram, periodogram};
use estimate::whittle::{WhittleFit, fit};
use noise::{Stream, power_law};

const STEP_S: f64 = 0.01;

fn pink(stream: &mut Stream, count: usize, step_s: f64, exponent: f64) -> Vec<f64> {
    let mut samples = power_law(stream, count, step_s, 1e-4, exponent);
    samples.iter_mut().for_each(|x| *x += 0.02 * stream.normal());
    samples
}

fn with(samples: &[f64], sine: impl Fn(f64) -> f64) -> Vec<f64> {
    samples.iter().enumerate().map(|(i, x)| x + sine(i as f64 * STEP_S)).collect()
}

fn wave(amplitude: f64, hz: f64, t: f64) -> f64 {
    amplitude * (std::f64::consts::TAU * hz * t + 0.7).sin()
}

fn seen(samples: &[f64], step_s: f64) -> Periodogram {
    periodogram(samples, step_s).expect("a periodogram")
}

fn near(line: &Line, hz: f64, amplitude: f64, length_s: f64) {
    // The Cramér-Rao bounds in noise of density P are √(P/T) for an amplitude a and √(3 P/T)/(π a T) for its
    // frequency; five of these.
    let density = 1e-4 / hz + 2.0 * 0.02_f64.powi(2) * STEP_S;
    let std = (density / length_s).sqrt();
    let hz_std = 3.0_f64.sqrt() * std / (std::f64::consts::PI * amplitude * length_s);
    assert!((line.amplitude - amplitude).abs() < 5.0 * std, "{line:?}, {amplitude} ± {std}");
    assert!((line.frequency_hz - hz).abs() < 5.0 * hz_std, "{line:?}, {hz} ± {hz_std}");
    assert!(line.p_value < 1e-3);
}

/// How far lines moved A, α and σ, in their standard errors.
fn moved(clean: Periodogram, found: Periodogram) -> f64 {
    let [clean, found] = [clean, found].map(|one| fit(&[one]).expect("a fit"));
    let of = |fit: &WhittleFit| [fit.amplitude, fit.exponent, fit.white_rms[0]];
    let off = of(&found).into_iter().zip(of(&clean));
    off.map(|(found, clean)| (found.value - clean.value).abs() / clean.std).fold(0.0, f64::max)
}

#[test]
fn ordinates_add_up_to_the_variance() {
    // All but the Nyquist frequency, which an odd length has not.
    for count in [9, 601, 6001] {
        let samples = pink(&mut Stream::new(11, "sum"), count, STEP_S, 1.0);
        let found = seen(&samples, STEP_S);
        assert!(found.lines.is_empty() && found.samples == count);
        let mean = samples.iter().sum::<f64>() / count as f64;
        let variance = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count as f64;
        let sum = found.bins.iter().map(|bin| bin.count * bin.density).sum::<f64>() / found.length_s;
        assert!((sum / variance - 1.0).abs() < 1e-12, "{count}: {sum}, {variance}");
    }
}

#[test]
fn a_large_constant_costs_no_digits() {
    let samples = pink(&mut Stream::new(12, "constant"), 50_000, STEP_S, 1.0);
    let lifted: Vec<f64> = samples.iter().map(|x| 50_000.0 + 0.01 * x).collect();
    // The readings themselves are rounded to 7e-12.
    let same: Vec<f64> = lifted.iter().map(|x| x - 50_000.0).collect();
    let (lifted, same) = (seen(&lifted, STEP_S), seen(&same, STEP_S));
    for (a, b) in lifted.bins.iter().zip(&same.bins) {
        assert!((a.density / b.density - 1.0).abs() < 1e-8, "{a:?}, {b:?}");
    }
}

#[test]
fn a_line_is_found_and_does_not_move_the_noise() {
    let mut worst = 0.0_f64;
    for number in 0..50 {
        let samples = pink(&mut Stream::new(number, "line"), 6000, STEP_S, 1.0);
        // Between two ordinates, on one, and anything.
        let hz = [16.7, 16.708_333, 16.71 + 0.001 * number as f64][number as usize % 3];
        let (clean, found) = (seen(&samples, STEP_S), seen(&with(&samples, |t| wave(0.3, hz, t)), STEP_S));
        let own: Vec<&Line> =
            found.lines.iter().filter(|line| (line.frequency_hz - hz).abs() < 0.1).collect();
        assert_eq!(own.len(), 1, "{:?}", found.lines);
        near(own[0], hz, 0.3, 60.0);
        worst = worst.max(moved(clean, found));
    }
    // Five of 2999 ordinates are left out: that much of chance has to be expected.
    assert!(worst < 0.2, "{worst}");
}

#[test]
fn several_lines_near_and_far() {
    let samples = pink(&mut Stream::new(1, "lines"), 20_000, STEP_S, 1.2);
    let sines = [(0.5, 16.7), (0.02, 17.25), (0.004, 33.4), (0.3, 2.111), (30.0, 25.003)];
    let found = seen(&with(&samples, |t| sines.iter().map(|(a, hz)| wave(*a, *hz, t)).sum()), STEP_S);
    assert_eq!(found.lines.len(), sines.len(), "{:?}", found.lines);
    for (amplitude, hz) in sines {
        let by = |line: &&Line| (line.frequency_hz - hz).abs() < 0.01;
        let line = found.lines.iter().find(by).unwrap_or_else(|| panic!("{hz}: {:?}", found.lines));
        near(line, hz, amplitude, 200.0);
    }
    assert!(moved(seen(&samples, STEP_S), found) < 0.3);
}

#[test]
fn what_a_wandering_line_spreads_is_no_noise() {
    // The phase of the mains walks at random, by 0.4 rad over the series.
    let samples = pink(&mut Stream::new(2, "mains"), 20_000, STEP_S, 1.0);
    let mut stream = Stream::new(2, "phase");
    let mut walk = 0.0;
    let phases: Vec<f64> = (0..samples.len())
        .map(|_| {
            walk += 0.003 * stream.normal();
            walk
        })
        .collect();
    let turn = |i: usize| std::f64::consts::TAU * 20.0 * STEP_S * i as f64 + phases[i];
    let mains: Vec<f64> = samples.iter().enumerate().map(|(i, x)| x + 0.3 * turn(i).sin()).collect();
    let (clean, found) = (seen(&samples, STEP_S), seen(&mains, STEP_S));
    assert_eq!(found.lines.len(), 1, "{:?}", found.lines);
    assert!((found.lines[0].frequency_hz - 20.0).abs() < 0.05, "{:?}", found.lines);
    let left: f64 = found.bins.iter().map(|bin| bin.count).sum();
    assert!(left > 9000.0 && left < 9900.0, "{left}");
    assert!(moved(clean, found) < 0.7);
}

#[test]
fn clean_series_have_no_lines() {
    let (trials, mut all) = (testkit::campaigns(200), 0);
    for (count, exponent) in [(400, 1.0), (2000, 1.0), (2000, 1.8), (6000, 1.0)] {
        let series = |number: u64| pink(&mut Stream::new(number, "clean"), count, 1.0, exponent);
        all += (0..trials).map(|number| seen(&series(number), 1.0).lines.len()).sum::<usize>();
    }
    // 10⁻³ for each series; as many as chance brings once in a thousand times.
    let expected = 4e-3 * trials as f64;
    assert!((all as f64) < expected + 3.3 * expected.sqrt() + 1.0, "{all}, expected {expected}");
}
