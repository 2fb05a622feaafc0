//! The Allan deviation by octaves, and its interval against the truth of simulated noise.

use estimate::Error;
use estimate::allan::{AllanPoint, Deviations};
use noise::{Stream, power_law, random_walk};
use std::f64::consts::PI;

use crate::made::white;

/// Samples of a simulated series.
const COUNT: usize = 512;

fn overlapping(
    samples: &[f64],
    step_s: f64,
    exponent: impl Fn(f64) -> f64,
) -> Result<Vec<AllanPoint>, Error> {
    Ok(Deviations::of(samples, step_s)?.points(exponent))
}

/// In 2000 series of made noise the 95 % interval holds the true deviation in 93 to 97 %, and the mean of the
/// estimated variance is the true one.
fn covers(exponent: f64, series: impl Fn(&mut Stream) -> Vec<f64>, variance: impl Fn(i32) -> f64) {
    let trials = 2000.0;
    let mut stream = Stream::new(6, "allan");
    let mut found = [(1, 0.0, 0.0), (4, 0.0, 0.0), (16, 0.0, 0.0)];
    let truth = found.map(|(m, ..)| variance(m));
    for _ in 0..trials as usize {
        let points = overlapping(&series(&mut stream), 1.0, |_| exponent).expect("deviations");
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
    let points = overlapping(&samples, 0.25, |averaging_s| {
        assert!((0.25..=62.5).contains(&averaging_s));
        0.0
    })
    .expect("deviations");
    assert_eq!(points.len(), 8, "1 … 128: of 256 there are only three averages");
    for (octave, point) in points.iter().enumerate() {
        assert_eq!(point.averaging_s, 0.25 * (1 << octave) as f64);
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
}

#[test]
fn degrees_of_freedom_by_hand() {
    // N = 17 sums: the three formulas worked out on paper for m = 1, 2, 4.
    let samples = &white(&mut Stream::new(8, "sixteen"), 16, 1.0);
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
fn the_interval_covers_white_noise() {
    covers(0.0, |stream| white(stream, COUNT, 1.0), |m| 1.0 / f64::from(m));
}

#[test]
fn the_interval_covers_flicker_noise() {
    // The variance 1/k at k cycles per period, of which a series is a part.
    const PERIOD: usize = 8 * COUNT;
    let series = |stream: &mut Stream| {
        let mut series = power_law(stream, PERIOD, 1.0, 1.0, 1.0);
        series.truncate(COUNT);
        series
    };
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
