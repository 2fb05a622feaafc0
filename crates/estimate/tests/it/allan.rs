//! The Allan deviation against published test sets, and its interval against the truth of simulated noise.

use crate::sequence;

use std::f64::consts::PI;

use estimate::Error;
use estimate::allan::{AllanPoint, deviation, overlapping};
use fourier::{Complex, Planner};
use sequence::Sequence;

/// Samples of a simulated series.
const COUNT: usize = 512;

/// Period of the simulated flicker noise, in samples.
const PERIOD: usize = 8 * COUNT;

/// The thousand numbers n/(2³¹ − 1), n' = 16807 n mod (2³¹ − 1), the first n 1234567890.
fn thousand() -> Vec<f64> {
    let modulus = (1_u64 << 31) - 1;
    let numbers = std::iter::successors(Some(1_234_567_890_u64), |n| Some(16_807 * n % modulus));
    numbers.take(1000).map(|n| n as f64 / modulus as f64).collect()
}

/// Gaussian noise with the variance 1/k at k cycles per [`PERIOD`], k = 1 … half the period less 1: flicker.
struct Flicker {
    planner: Planner,
    sequence: Sequence,
}

impl Flicker {
    fn series(&mut self) -> Vec<f64> {
        let plan = self.planner.inverse(PERIOD);
        let (mut spectrum, mut series) = (plan.make_input_vec(), plan.make_output_vec());
        let numbers = self.sequence.white(PERIOD, 1.0);
        for (k, pair) in (1..PERIOD / 2).zip(numbers.chunks(2)) {
            // a cos + b sin is c e^(iφ) + c* e^(−iφ) with c = (a − ib)/2.
            spectrum[k] = Complex::new(pair[0], -pair[1]) * (0.5 / (k as f64).sqrt());
        }
        plan.process(&mut spectrum, &mut series).expect("buffers of the plan's lengths");
        series.truncate(COUNT);
        series
    }

    /// Σ P 2 sin⁴(πfτ)/(m sin(πfΔt))²: the Allan variance of averages of m samples of this noise.
    ///
    /// For samples that are themselves averages over Δt, m sin(πfΔt) would be πfτ, with P the density before
    /// that.
    fn variance(m: usize) -> f64 {
        let line = |k: usize| {
            let (phase, m) = (PI * k as f64 / PERIOD as f64, m as f64);
            2.0 * (m * phase).sin().powi(4) / (m * phase.sin()).powi(2) / k as f64
        };
        (1..PERIOD / 2).map(line).sum()
    }
}

/// Walks at random: the running sums of white noise.
fn walk(sequence: &mut Sequence) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = sequence.white(COUNT, 1.0);
    steps
        .iter()
        .map(|step| {
            sum += step;
            sum
        })
        .collect()
}

/// Coverage of the 95 % interval at m = 1, 2, 4, … and the mean of the estimated variance over the true one.
fn coverage(
    exponent: f64,
    mut series: impl FnMut() -> Vec<f64>,
    variance: impl Fn(usize) -> f64,
) -> Vec<(usize, f64, f64)> {
    let trials = 2000;
    let mut found: Vec<(usize, f64, f64)> = (0..8).map(|octave| (1 << octave, 0.0, 0.0)).collect();
    let truth: Vec<f64> = found.iter().map(|(m, ..)| variance(*m)).collect();
    // The factors depend on the degrees of freedom alone, which are those of the first series.
    let mut factors: Vec<(f64, f64)> = Vec::new();
    for _ in 0..trials {
        let points = overlapping(&series(), 1.0, |_| exponent).expect("deviations");
        assert_eq!(points.len(), found.len());
        if factors.is_empty() {
            factors = points.iter().map(|point| point.interval(0.95)).collect();
        }
        for (i, point) in points.iter().enumerate() {
            let band = point.deviation * factors[i].0..point.deviation * factors[i].1;
            found[i].1 += f64::from(u8::from(band.contains(&truth[i].sqrt()))) / f64::from(trials);
            found[i].2 += point.deviation.powi(2) / truth[i] / f64::from(trials);
        }
    }
    for (m, share, ratio) in &found {
        println!("exponent {exponent}, m = {m}: {share:.4} covered, variance {ratio:.4} of the true one");
    }
    found
}

/// The coverage of 2000 trials is known to 0.005; asked of it are 0.93 … 0.97 at m = 1, 4, 16.
fn assert_covered(found: &[(usize, f64, f64)]) {
    for (m, share, ratio) in found.iter().filter(|(m, ..)| [1, 4, 16].contains(m)) {
        assert!((0.93..=0.97).contains(share), "m = {m}: {share}");
        assert!((ratio - 1.0).abs() < 0.02, "m = {m}: {ratio} of the true variance");
    }
}

#[test]
fn published_test_sets() {
    // W. J. Riley, NIST Special Publication 1065 (2008), sets of 9 and of 1000 frequencies; the first is from
    // NBS Monograph 140, Annex 8.E.
    let nine = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0];
    for (m, printed) in [(1, "91.22945"), (2, "85.95287")] {
        assert_eq!(format!("{:.5}", deviation(&nine, m).expect("a deviation")), printed, "m = {m}");
    }
    let thousand = thousand();
    for (m, printed) in [(1, "2.922319e-1"), (10, "9.159953e-2"), (100, "3.241343e-2")] {
        assert_eq!(format!("{:.6e}", deviation(&thousand, m).expect("a deviation")), printed, "m = {m}");
    }
}

#[test]
fn octaves_and_their_end() {
    let samples = thousand();
    let points = overlapping(&samples, 0.25, |averaging_s| {
        assert!((0.25..=62.5).contains(&averaging_s));
        0.0
    })
    .expect("deviations");
    assert_eq!(points.len(), 8, "1 … 128: of 256 there are only three averages");
    for (octave, point) in points.iter().enumerate() {
        let m = 1_usize << octave;
        assert_eq!(point.averaging_s, 0.25 * m as f64);
        assert_eq!(Some(point.deviation), deviation(&samples, m));
        assert_eq!(point.pairs, 1001 - 2 * m);
    }
    for (count, expected) in [(4, 1), (7, 1), (8, 2), (15, 2), (16, 3)] {
        let points = overlapping(&samples[..count], 1.0, |_| 0.0).expect("deviations");
        assert_eq!(points.len(), expected, "{count} samples");
    }
    for count in 0..4 {
        match overlapping(&samples[..count], 1.0, |_| 0.0) {
            Err(Error::TooFew { found, unknowns: 4 }) => assert_eq!(found, count),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(deviation(&samples, 0), None);
    assert_eq!(deviation(&samples, 501), None);
    assert_eq!(deviation(&samples, usize::MAX), None);
    assert_eq!(deviation(&[], 1), None);
    assert!((deviation(&[1.0, 4.0], 1).expect("one pair") - 3.0 / 2.0_f64.sqrt()).abs() < 1e-15);
}

#[test]
fn degrees_of_freedom_by_hand() {
    // N = 17 sums: the three formulas worked out on paper for m = 1, 2, 4.
    let samples = &thousand()[..16];
    for (exponent, expected) in [
        (
            0.0,
            [
                4.0 / 9.0 * (24.0 - 30.0 / 17.0),
                16.0 / 21.0 * (12.0 - 30.0 / 17.0),
                64.0 / 69.0 * (6.0 - 30.0 / 17.0),
            ],
        ),
        (1.0, [450.0 / 34.2, 1445.0 / 184.0, 1445.0 / 464.0]),
        // The first, 15 · 212/196, is more than the pairs.
        (2.0, [15.0, 7.5 * 176.0 / 196.0, 3.75 * 128.0 / 196.0]),
    ] {
        for near in [exponent - 0.49, exponent, exponent + 0.49] {
            let points = overlapping(samples, 1.0, |_| near).expect("deviations");
            for (point, expected) in points.iter().zip(expected) {
                assert!((point.freedom - expected).abs() < 1e-12, "exponent {near}: {point:?}, {expected}");
            }
        }
    }
    let freedom = |exponent: f64| {
        let points = overlapping(samples, 1.0, |_| exponent).expect("deviations");
        points.iter().map(|point| point.freedom).collect::<Vec<_>>()
    };
    assert_eq!(freedom(-3.0), freedom(0.0));
    assert_eq!(freedom(7.0), freedom(2.0));
    assert!(freedom(f64::NAN).iter().all(|freedom| freedom.is_nan()));

    // Each averaging time has its own exponent.
    let mixed = overlapping(samples, 3.0, |averaging_s| if averaging_s < 10.0 { 0.0 } else { 2.0 });
    let mixed: Vec<f64> = mixed.expect("deviations").iter().map(|point| point.freedom).collect();
    assert_eq!(mixed, [freedom(0.0)[0], freedom(0.0)[1], freedom(2.0)[2]]);
}

#[test]
fn factors_of_the_deviation() {
    // χ² of 10 degrees of freedom: 3.2470 and 20.4832 at 2.5 % and 97.5 %.
    let point = AllanPoint { averaging_s: 1.0, deviation: 1.0, freedom: 10.0, pairs: 20 };
    let (low, high) = point.interval(0.95);
    assert!((low - (10.0_f64 / 20.483_177).sqrt()).abs() < 1e-7, "{low}");
    assert!((high - (10.0_f64 / 3.246_973).sqrt()).abs() < 1e-6, "{high}");
    assert_eq!(point.interval(1.0), (0.0, f64::INFINITY));
    // So many degrees of freedom that χ² is as good as normal: 1 ∓ 1.959964/√(2ν).
    let (low, high) = AllanPoint { freedom: 5.7e6, ..point }.interval(0.95);
    let half = 1.959_964 / 11.4e6_f64.sqrt();
    assert!((low - (1.0 - half)).abs() < 1e-6 && (high - (1.0 + half)).abs() < 1e-6, "{low}, {high}");
    for (freedom, probability) in [(10.0, -0.1), (10.0, 1.1), (10.0, f64::NAN), (f64::NAN, 0.95)] {
        let (low, high) = AllanPoint { freedom, ..point }.interval(probability);
        assert!(low.is_nan() && high.is_nan(), "{freedom}, {probability}");
    }
}

#[test]
fn a_large_constant_takes_no_digits() {
    // Noise of 0.01 in steps of 2⁻²⁰, so that 50 000 more leaves the samples exact.
    let unit = (1_u32 << 20) as f64;
    let noise: Vec<f64> =
        Sequence(5).white(200_000, 0.01).iter().map(|x| (x * unit).round() / unit).collect();
    let lifted: Vec<f64> = noise.iter().map(|x| x + 50_000.0).collect();
    for m in [1, 64, 4096, 50_000] {
        let (alone, lifted) = (deviation(&noise, m).expect("one"), deviation(&lifted, m).expect("one"));
        println!("m = {m}: {:.1e} off", lifted / alone - 1.0);
        assert!((lifted / alone - 1.0).abs() < 1e-11, "m = {m}: {alone}, {lifted}");
    }
}

#[test]
fn drift_and_steps_that_cancel() {
    // A drift of 0.3 per sample: neighbouring averages of m samples differ by 0.3 m.
    let ramp: Vec<f64> = (0..1000).map(|i| 7.0 + 0.3 * f64::from(i)).collect();
    for m in [1, 3, 128, 500] {
        let expected = 0.3 * m as f64 / 2.0_f64.sqrt();
        assert!((deviation(&ramp, m).expect("a deviation") / expected - 1.0).abs() < 1e-12, "m = {m}");
    }
    // A sine of period m is averaged away.
    let sine: Vec<f64> = (0..1000).map(|i| (std::f64::consts::TAU * f64::from(i) / 20.0).sin()).collect();
    assert!(deviation(&sine, 20).expect("a deviation") < 1e-14);
    assert!(deviation(&sine, 10).expect("a deviation") > 0.5);
}

#[test]
fn the_interval_covers_white_noise() {
    let mut sequence = Sequence(6);
    assert_covered(&coverage(0.0, || sequence.white(COUNT, 1.0), |m| 1.0 / m as f64));
}

#[test]
fn the_interval_covers_flicker_noise() {
    let mut noise = Flicker { planner: Planner::new(), sequence: Sequence(7) };
    assert_covered(&coverage(1.0, || noise.series(), Flicker::variance));
}

#[test]
fn the_interval_covers_a_random_walk() {
    // Steps of one add up over two neighbouring averages with weights that rise to one and fall again.
    let variance = |m: usize| (2.0 * (m * m) as f64 + 1.0) / (6.0 * m as f64);
    let mut sequence = Sequence(8);
    assert_covered(&coverage(2.0, || walk(&mut sequence), variance));
}
