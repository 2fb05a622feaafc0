//! The Allan deviation by octaves, and its interval against the truth of simulated noise.

use estimate::Error;
use estimate::allan::{AllanPoint, Deviations};
use noise::{Stream, power_law, random_walk};
use std::f64::consts::PI;

use crate::made::white;

/// Samples of a simulated series.
const COUNT: usize = 512;

fn points(samples: &[f64], step_s: f64, exponent: impl Fn(f64) -> f64) -> Vec<AllanPoint> {
    Deviations::of(samples, step_s).expect("deviations").points(exponent)
}

/// In 2000 series of made noise the 95 % interval holds the true deviation in 93 to 97 %, and the mean of the
/// estimated variance is the true one.
fn covers(exponent: f64, series: impl Fn(&mut Stream) -> Vec<f64>, variance: impl Fn(i32) -> f64) {
    let trials = 2000.0;
    let mut stream = Stream::new(6, "allan");
    let mut found = [(1, 0.0, 0.0), (4, 0.0, 0.0), (16, 0.0, 0.0)];
    let truth = found.map(|(m, ..)| variance(m));
    for _ in 0..trials as usize {
        let points = points(&series(&mut stream), 1.0, |_| exponent);
        for ((m, share, ratio), truth) in found.iter_mut().zip(truth) {
            let point = points.iter().find(|point| point.averaging_s == f64::from(*m)).expect("an octave");
            let [low, high] = point.band(0.95);
            *share += if (low..high).contains(&truth.sqrt()) { 1.0 / trials } else { 0.0 };
            *ratio += point.deviation.powi(2) / truth / trials;
        }
    }
    for (m, share, ratio) in found {
        // The share is known to 0.005.
        assert!((0.93..=0.97).contains(&share), "exponent {exponent}, m = {m}: {share}");
        assert!((ratio - 1.0).abs() < 0.02, "exponent {exponent}, m = {m}: {ratio} of the true variance");
    }
}

#[test]
fn octaves_and_their_end() {
    let samples = white(&mut Stream::new(7, "octaves"), 1000, 1.0);
    let octaves = points(&samples, 0.25, |_| 0.0).iter().map(|point| point.averaging_s).collect::<Vec<_>>();
    // Of 256 samples there are only three averages.
    assert_eq!(octaves, [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
    for (count, expected) in [(4, 1), (7, 1), (8, 2), (15, 2), (16, 3)] {
        assert_eq!(points(&samples[..count], 1.0, |_| 0.0).len(), expected, "{count} samples");
    }
    for count in 0..4 {
        let refused = Deviations::of(&samples[..count], 1.0);
        assert!(matches!(refused, Err(Error::TooFew { found, unknowns: 4 }) if found == count));
    }
}

#[test]
fn degrees_of_freedom_by_hand() {
    // N = 17 sums: the three formulas worked out on paper for m = 1, 2, 4.
    let samples = &white(&mut Stream::new(8, "sixteen"), 16, 1.0);
    let freedom = |step_s: f64, exponent: &dyn Fn(f64) -> f64| -> Vec<f64> {
        points(samples, step_s, exponent).iter().map(|point| point.freedom).collect()
    };
    let less = 30.0 / 17.0;
    for (exponent, expected) in [
        (0.0, [4.0 / 9.0 * (24.0 - less), 16.0 / 21.0 * (12.0 - less), 64.0 / 69.0 * (6.0 - less)]),
        (1.0, [450.0 / 34.2, 1445.0 / 184.0, 1445.0 / 464.0]),
        // The first, 15 · 212/196, is more than the pairs.
        (2.0, [15.0, 7.5 * 176.0 / 196.0, 3.75 * 128.0 / 196.0]),
    ] {
        for near in [exponent - 0.49, exponent, exponent + 0.49] {
            for (found, expected) in freedom(1.0, &|_| near).iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "exponent {near}: {found}, {expected}");
            }
        }
    }
    let of = |exponent: f64| freedom(1.0, &|_| exponent);
    assert_eq!((of(-3.0), of(7.0)), (of(0.0), of(2.0)));
    assert!(of(f64::NAN).iter().all(|freedom| freedom.is_nan()));
    // Each averaging time has its own exponent.
    let mixed = freedom(3.0, &|averaging_s| if averaging_s < 10.0 { 0.0 } else { 2.0 });
    assert_eq!(mixed, [of(0.0)[0], of(0.0)[1], of(2.0)[2]]);
}

#[test]
fn the_interval_covers_white_noise() {
    covers(0.0, |stream| white(stream, COUNT, 1.0), |m| 1.0 / f64::from(m));
}

#[test]
fn the_interval_covers_flicker_noise() {
    // The variance 1/k at k cycles per period, of which a series is a part.
    const PERIOD: usize = 8 * COUNT;
    let series = |stream: &mut Stream| power_law(stream, PERIOD, 1.0, 1.0, 1.0)[..COUNT].to_vec();
    // Σ P 2 sin⁴(πfτ)/(m sin(πfΔt))²: of averages over Δt, m sin(πfΔt) would be πfτ.
    let variance = |m: i32| {
        let line = |k: usize| {
            let (phase, m) = (PI * k as f64 / PERIOD as f64, f64::from(m));
            2.0 * (m * phase).sin().powi(4) / (m * phase.sin()).powi(2) / k as f64
        };
        (1..PERIOD / 2).map(line).sum::<f64>()
    };
    covers(1.0, series, variance);
}

#[test]
fn the_interval_covers_a_random_walk() {
    // Steps of one add up over two neighbouring averages with weights that rise to one and fall again.
    let variance = |m: i32| (2.0 * f64::from(m * m) + 1.0) / (6.0 * f64::from(m));
    let time: Vec<f64> = (0..COUNT).map(|row| row as f64).collect();
    covers(2.0, |stream| random_walk(stream, &time, 1.0), variance);
}
