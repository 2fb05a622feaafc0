//! Each generator against its definition: averaged spectra of 200 series, decade by decade, each within its
//! own confidence band.

use common::Noise;
use noise::{Stream, power_law, quantise, random_walk, series};

use statrs::distribution::{ChiSquared, ContinuousCDF};

const SERIES: usize = 200;

/// One-sided periodogram, nT²/Hz, at the Fourier frequencies 1..n/2 (the Nyquist frequency left out).
fn periodogram(series: &[f64], step_s: f64) -> Vec<f64> {
    let n = series.len();
    fourier::forward(series.to_vec())[1..n.div_ceil(2)]
        .iter()
        .map(|c| 2.0 * step_s / n as f64 * c.norm_sqr())
        .collect()
}

fn averaged(points: usize, step_s: f64, make: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
    let mut sum = vec![0.0; points.div_ceil(2) - 1];
    for number in 0..SERIES {
        for (sum, p) in sum.iter_mut().zip(periodogram(&make(number), step_s)) {
            *sum += p / SERIES as f64;
        }
    }
    sum
}

/// In each decade of frequency (from one over the length), measured over defined power is chi-squared with 2
/// · 200 degrees of freedom for each Fourier frequency in it; 99.9 % two-sided.
fn check(name: &str, spectrum: &[f64], resolution: f64, defined: impl Fn(f64) -> f64) {
    let mut from = 1;
    while from <= spectrum.len() {
        let to = (from * 10).min(spectrum.len() + 1);
        let ratios = (from..to).map(|k| spectrum[k - 1] / defined(k as f64 * resolution));
        let bins = (to - from) as f64;
        let ratio = ratios.sum::<f64>() / bins;
        let freedom = 2.0 * SERIES as f64 * bins;
        let band = ChiSquared::new(freedom).expect("a distribution");
        let (low, high) = (band.inverse_cdf(0.0005) / freedom, band.inverse_cdf(0.9995) / freedom);
        assert!((low..high).contains(&ratio), "{name}: {ratio} not in [{low}, {high}] from bin {from}");
        from = to;
    }
}

#[test]
fn power_laws_have_their_spectrum_at_every_decade() {
    for exponent in [0.0, 0.5, 1.0, 1.5, 2.0] {
        for points in [4096, 3001] {
            let step_s = 0.25;
            let name = format!("alpha {exponent}, {points} points");
            let make = |number: usize| {
                power_law(&mut Stream::new(number as u64, &name), points, step_s, 3e-4, exponent)
            };
            let resolution = 1.0 / (points as f64 * step_s);
            check(&name, &averaged(points, step_s, make), resolution, |f| 3e-4 * f.powf(-exponent));
        }
    }
}

#[test]
fn the_sum_of_white_and_flicker_has_the_sum_of_the_spectra() {
    let noise = Noise {
        white_rms_nt: Some(0.05),
        flicker_nt2_per_hz_at_1hz: Some(1e-4),
        flicker_exponent: Some(1.2),
        ..Noise::default()
    };
    let time: Vec<f64> = (0..4096).map(|row| f64::from(row) * 2.0).collect();
    let make = |number: usize| series(&noise, number as u64, "sum", 4096, Some(&time)).expect("noise");
    let defined = |f: f64| 2.0 * 0.05 * 0.05 * 2.0 + 1e-4 * f.powf(-1.2);
    check("sum", &averaged(4096, 2.0, make), 1.0 / 8192.0, defined);
}

#[test]
fn the_steps_of_a_random_walk_are_white() {
    let time: Vec<f64> = (0..4097).map(f64::from).collect();
    let make = |number: usize| {
        let walk = random_walk(&mut Stream::new(number as u64, "walk"), &time, 0.2);
        walk.windows(2).map(|pair| pair[1] - pair[0]).collect()
    };
    check("walk", &averaged(4096, 1.0, make), 1.0 / 4096.0, |_| 2.0 * 0.04);
    // At uneven times the variance grows with time, not with rows.
    let uneven = [0.0, 1.0, 1.5, 40.0];
    let variance = (0..4000)
        .map(|number| random_walk(&mut Stream::new(number, "uneven"), &uneven, 0.2)[3].powi(2))
        .sum::<f64>()
        / 4000.0;
    assert!((variance / (0.04 * 40.0) - 1.0).abs() < 0.08, "{variance}");
}

#[test]
fn rounding_adds_the_floor_of_nasa_eq_27() {
    // (δB)² Δt/6, for a signal that crosses many codes.
    let step_s = 0.01;
    let make = |number: usize| {
        let mut stream = Stream::new(number as u64, "codes");
        let exact: Vec<f64> = (0..4096).map(|_| stream.normal() * 5.0).collect();
        let mut rounded = exact.clone();
        quantise(&mut rounded, 1.0);
        rounded.iter().zip(&exact).map(|(a, b)| a - b).collect()
    };
    check("codes", &averaged(4096, step_s, make), 1.0 / 40.96, |_| step_s / 6.0);
}

#[test]
fn figure_7_has_26_pt_over_any_three_decades() {
    // A = 0.026² / ln 1000; the rms of the lines in (f, 1000 f] is within 1 % of 26e-3 nT where the lines lie
    // close.
    let amplitude = 0.026f64.powi(2) / 1000f64.ln();
    let (points, step_s) = (1 << 17, 0.01);
    let resolution = 1.0 / (points as f64 * step_s);
    let mut power = vec![0.0; points / 2];
    for number in 0..SERIES as u64 {
        let series = power_law(&mut Stream::new(number, "figure 7"), points, step_s, amplitude, 1.0);
        for (power, p) in power.iter_mut().zip(periodogram(&series, step_s)) {
            *power += p * resolution / SERIES as f64;
        }
    }
    for from in [10, 20, 50] {
        let first = power[from - 1] / 2.0 + power[1000 * from - 1] / 2.0;
        let rms = (first + power[from..1000 * from - 1].iter().sum::<f64>()).sqrt();
        assert!((rms / 0.026 - 1.0).abs() < 0.01, "{rms}");
    }
}
