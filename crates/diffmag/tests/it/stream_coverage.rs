//! Coverage of the streamed answer's 95 % intervals over simulated pairs, white and flicker noise, under a
//! field like nature's (f^-1.6). All noise is cut out of series four times as long, so that it goes on below
//! one over the length. FLUXCAL_CAMPAIGNS sets how many.

use diffmag::stream::{Batch, Estimate, Statistics, answer};
use indexmap::IndexMap;
use noise::Stream;
use rayon::prelude::*;

const ROWS: usize = 20_000;
const ETA: [[f64; 3]; 3] = [[1.002, 0.003, -0.011], [-0.004, 0.998, 0.02], [0.007, -0.013, 1.001]];

#[derive(Clone, Copy)]
struct Truth {
    white_rms_nt: f64,
    flicker: f64,
    exponent: f64,
    drift_nt_per_day: f64,
}

fn campaigns() -> u64 {
    testkit::campaigns(20)
}

/// For each parameter: its distance from the truth in units of its 95 % interval.
fn missed(truth: Truth, seed: u64) -> IndexMap<&'static str, Vec<f64>> {
    let mut stream = Stream::new(seed, "pair");
    let mut cut = |amplitude: f64, exponent: f64| -> Vec<f64> {
        if amplitude == 0.0 {
            return vec![0.0; ROWS];
        }
        let long = noise::power_law(&mut stream, 4 * ROWS, 1.0, amplitude, exponent);
        let middle = long[2 * ROWS];
        long[ROWS..2 * ROWS].iter().map(|n| n - middle).collect()
    };
    let field: Vec<Vec<f64>> = [20_800.0, 700.0, 47_500.0]
        .into_iter()
        .map(|main| cut(2e-4, 1.6).into_iter().map(|n| main + n).collect())
        .collect();
    let flicker: Vec<Vec<f64>> = (0..3).map(|_| cut(truth.flicker, truth.exponent)).collect();
    let mut white = Stream::new(seed, "white");
    let test: Vec<Vec<f64>> = (0..3)
        .map(|j| {
            let row = |row: usize| {
                (0..3).map(|i| ETA[i][j] * field[i][row]).sum::<f64>()
                    + flicker[j][row]
                    + truth.white_rms_nt * white.normal()
                    + truth.drift_nt_per_day * row as f64 / 86_400.0
            };
            (0..ROWS).map(row).collect()
        })
        .collect();
    // The pieces of the pyramid lie elsewhere in each campaign.
    let first = 1000.0 + (seed * 7919 % 65_537) as f64;
    let time_s: Vec<f64> = (0..ROWS).map(|row| first + row as f64).collect();
    let mut statistics = Statistics::new();
    let reference_nt = [&field[0][..], &field[1], &field[2]];
    statistics
        .push(&Batch { time_s: &time_s, reference_nt, test_nt: [&test[0], &test[1], &test[2]] })
        .expect("rows");
    let fit = answer(&statistics.finish()).expect("an answer");
    let mut all = IndexMap::<_, Vec<f64>>::new();
    let of = |estimate: &Estimate, truth: f64| {
        let [low, high] = estimate.interval(0.95);
        (estimate.value - truth).abs() / (0.5 * (high - low))
    };
    for (j, axis) in fit.axes.iter().enumerate() {
        for ((weighted, plain), row) in axis.weighted.iter().zip(axis.least_squares).zip(ETA) {
            all.entry("eta weighted").or_default().push(of(weighted, row[j]));
            all.entry("eta least squares as the source has it").or_default().push(of(&plain, row[j]));
        }
        if truth.drift_nt_per_day == 0.0 {
            for ((std, plain), row) in axis.least_squares_std_noise.iter().zip(axis.least_squares).zip(ETA) {
                let honest = Estimate { std: *std, freedom: f64::INFINITY, ..plain };
                all.entry("eta least squares").or_default().push(of(&honest, row[j]));
            }
        }
        all.entry("drift").or_default().push(of(&axis.drift_nt_per_day, truth.drift_nt_per_day));
        all.entry("white").or_default().push(of(&axis.noise.white_rms_nt, truth.white_rms_nt));
        if truth.flicker > 0.0 {
            let log = (axis.noise.flicker_nt2_per_hz_at_1hz.value / truth.flicker).ln().abs();
            all.entry("flicker at 1 Hz").or_default().push(log / (1.96 * axis.noise.flicker_log_std));
            all.entry("exponent").or_default().push(of(&axis.noise.flicker_exponent, truth.exponent));
        } else {
            all.entry("offset").or_default().push(of(&axis.offset_nt, 0.0));
            let found = axis.noise.flicker_nt2_per_hz_at_1hz.value > 0.0;
            all.entry("no flicker").or_default().push(f64::from(u8::from(found)) * 2.0);
        }
        for octave in &axis.octaves {
            let [low, high] = octave.allan_interval_nt;
            let held = (low..=high).contains(&true_deviation(&truth, octave.averaging_s));
            all.entry("allan").or_default().push(if held { 0.0 } else { 2.0 });
            if let Some((eta, std)) = octave.eta.zip(octave.eta_std) {
                let freedom = octave.differences as f64 - 3.0;
                let eta = Estimate { value: eta[0], std: std[0], freedom };
                all.entry("eta by octave").or_default().push(of(&eta, ETA[0][j]));
            }
        }
    }
    all
}

/// Allan deviation of averages of m samples, the step being 1 s.
fn true_deviation(truth: &Truth, m: f64) -> f64 {
    let level = m.log2() as usize;
    let flicker = estimate::haar::power_law_variances(truth.exponent, level + 1)[level];
    (0.5 * (truth.flicker * flicker + 2.0 * truth.white_rms_nt.powi(2) / m)).sqrt()
}

fn covers(name: &str, truth: Truth) {
    let count = campaigns();
    let all: Vec<_> = (0..count).into_par_iter().map(|seed| missed(truth, seed)).collect();
    let mut shares = IndexMap::<&str, (f64, f64)>::new();
    for (key, missed) in all.iter().flatten() {
        for missed in missed {
            let share = shares.entry(key).or_default();
            *share = (share.0 + f64::from(u8::from(*missed <= 1.0)), share.1 + 1.0);
        }
    }
    // What is counted together in one campaign is not independent.
    let slack = if count < 1000 { 3.0 * (0.95 * 0.05 / count as f64).sqrt() } else { 0.0 };
    let mut outside = Vec::new();
    for (key, (held, of)) in shares {
        let share = held / of;
        println!("{name}: {key}: {:.1} % of {of}", 100.0 * share);
        let told = key.ends_with("as the source has it");
        let most = if key == "no flicker" { 1.0 } else { 0.97 + slack };
        if !told && !(0.93 - slack..=most).contains(&share) {
            outside.push(format!("{key}: {share:.3}"));
        }
    }
    assert!(outside.is_empty(), "{name}: {}", outside.join(", "));
}

#[test]
fn under_white_noise() {
    let truth = Truth { white_rms_nt: 0.1, flicker: 0.0, exponent: 1.0, drift_nt_per_day: 0.0 };
    covers("white", truth);
}

#[test]
fn under_flicker_noise() {
    let truth = Truth { white_rms_nt: 0.02, flicker: 1e-3, exponent: 1.0, drift_nt_per_day: 0.5 };
    covers("flicker", truth);
}

#[test]
fn under_weak_flicker_noise() {
    let truth = Truth { white_rms_nt: 0.1, flicker: 2e-5, exponent: 1.0, drift_nt_per_day: 0.0 };
    covers("weak flicker", truth);
}

#[test]
fn under_steep_noise() {
    let truth = Truth { white_rms_nt: 0.02, flicker: 1e-4, exponent: 1.5, drift_nt_per_day: 0.0 };
    covers("steep", truth);
}
