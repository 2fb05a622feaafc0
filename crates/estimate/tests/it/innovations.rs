//! Whitening against scipy.linalg (fixtures/reference/innovations_scipy.py) and on clean noise drawn from its covariance.

use estimate::innovations::Innovations;
use estimate::{linear, spectral, stats};
use faer::{Mat, Side};
use noise::Stream;
use serde_json::Value;
use std::f64::consts::{PI, TAU};

const STEP_S: f64 = 0.5;
/// α, A and the rms of white noise.
const NOISES: [(f64, f64, f64); 5] =
    [(0.5, 1.0, 1.0), (1.0, 1.0, 0.0), (1.0, 0.01, 1.0), (1.5, 1.0, 0.3), (1.9, 1.0, 0.0)];

fn density(rows: usize, step_s: f64, (alpha, amplitude, white): (f64, f64, f64)) -> impl Fn(f64) -> f64 {
    let lowest_hz = 1.0 / (rows as f64 * step_s);
    move |f: f64| amplitude * f.max(lowest_hz).powf(-alpha) + 2.0 * white * white * step_s
}

/// Constant, trend, exponential, lagged temperature, a sine of 37 cycles, and a fast one.
fn columns(rows: usize) -> Vec<Vec<f64>> {
    let angle = 4.0 * PI;
    let lagged = |t: f64| {
        ((angle * t).sin() - 0.1 * angle * ((angle * t).cos() - (-t / 0.1).exp()))
            / (1.0 + (0.1 * angle).powi(2))
    };
    let shapes: [&dyn Fn(f64) -> f64; 6] =
        [&|_| 1.0, &|t| t - 0.5, &|t| (-t / 0.2).exp(), &lagged, &|t| (TAU * 37.0 * t).sin(), &|t| {
            (0.9 * PI * t * rows as f64).cos()
        }];
    shapes.iter().map(|shape| (0..rows).map(|row| shape(row as f64 / rows as f64)).collect()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn as_scipy_has_them() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/reference/innovations_scipy.json");
    let text = std::fs::read_to_string(path).expect("the reference");
    let reference: Value = serde_json::from_str(&text).expect("JSON");
    let number = |value: &Value| value.as_f64().expect("a number");
    let names = ["constant", "linear", "exponential", "lagged", "sine", "fast"];
    for case in reference["cases"].as_array().expect("cases") {
        let noise = (number(&case["alpha"]), number(&case["amplitude"]), number(&case["white"]));
        let short = Innovations::of(&density(400, STEP_S, noise), 400, STEP_S).expect("innovations");
        let determinant = short.log_determinant().expect("no gaps") - number(&case["log_determinant"]);
        let mut rows_differ: f64 = 0.0;
        for (name, white) in names.iter().zip(short.whiten_all(&columns(400))) {
            let expected: Vec<f64> =
                case["whitened"][*name].as_array().expect("rows").iter().map(number).collect();
            let size = dot(&expected, &expected).sqrt();
            let difference: Vec<f64> = white.iter().zip(&expected).map(|(a, b)| a - b).collect();
            rows_differ = rows_differ.max(dot(&difference, &difference).sqrt() / size);
        }
        let long = Innovations::of(&density(6000, STEP_S, noise), 6000, STEP_S).expect("innovations");
        let white = long.whiten_all(&columns(6000));
        let mut products_differ: f64 = 0.0;
        for i in 0..6 {
            for j in 0..6 {
                let expected = number(&case["products"][i][j]);
                let size = (number(&case["products"][i][i]) * number(&case["products"][j][j])).sqrt();
                products_differ = products_differ.max((dot(&white[i], &white[j]) - expected).abs() / size);
            }
        }
        println!(
            "{noise:?}: rows {rows_differ:.1e}, products {products_differ:.1e}, ln|V| {determinant:.1e}"
        );
        assert!(rows_differ < 1e-3 && products_differ < 1e-3 && determinant.abs() < 1e-3);
    }
}

/// r_m by the midpoint rule, 64 points below 1/(n Δt).
fn lags(rows: usize, step_s: f64, density: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let points = 32 * rows;
    let spacing_hz = 0.5 / step_s / points as f64;
    let mut lags = vec![0.0; rows];
    for k in 0..points {
        let frequency_hz = (k as f64 + 0.5) * spacing_hz;
        let power = density(frequency_hz) * spacing_hz;
        let turn = 2.0 * (TAU * frequency_hz * step_s).cos();
        let (mut now, mut before) = (power, power * turn / 2.0);
        for lag in &mut lags {
            *lag += now;
            (now, before) = (turn * now - before, now);
        }
    }
    lags
}

/// Series of a noise by the Cholesky factor of its covariance.
fn draws(rows: usize, count: usize, density: &dyn Fn(f64) -> f64, seed: u64) -> Vec<Vec<f64>> {
    let lags = lags(rows, STEP_S, density);
    let factor = Mat::from_fn(rows, rows, |i, j| lags[i.abs_diff(j)]).llt(Side::Lower).expect("a factor");
    let mut stream = Stream::new(seed, "innovations");
    let normal = Mat::from_fn(rows, count, |_, _| stream.normal());
    let drawn = factor.L() * normal;
    (0..count).map(|j| drawn.col_as_slice(j).to_vec()).collect()
}

/// What a group of columns takes off the sum of squares beyond a base.
fn gain(white: &[f64], base: &[&Vec<f64>], group: &[&Vec<f64>]) -> f64 {
    let left = |columns: &[&Vec<f64>]| {
        let scale: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt()).collect();
        let design = Mat::from_fn(white.len(), columns.len(), |i, j| columns[j][i] / scale[j]);
        linear::fit(design.as_ref(), white, None).expect("a fit").sum_of_squares
    };
    let without = if base.is_empty() { dot(white, white) } else { left(base) };
    without - left(&[base, group].concat())
}

/// Kolmogorov's distance of probabilities from even ones, times √n: above 1.63 once in a hundred.
fn distance(probabilities: &mut [f64]) -> f64 {
    probabilities.sort_by(f64::total_cmp);
    let n = probabilities.len() as f64;
    let apart = |(i, p): (usize, &f64)| (p - i as f64 / n).abs().max((p - (i + 1) as f64 / n).abs());
    probabilities.iter().enumerate().map(apart).fold(0.0, f64::max) * n.sqrt()
}

#[test]
fn gains_on_clean_noise_are_chi_squared() {
    let (rows, count) = (3000, 400);
    for (seed, noise) in (1..).zip(NOISES) {
        let density = density(rows, STEP_S, noise);
        let innovations = Innovations::of(&density, rows, STEP_S).expect("innovations");
        let drawn = draws(rows, count, &density, seed);
        let (given, white) = (columns(rows), innovations.whiten_all(&columns(rows)));
        let noise_white = innovations.whiten_all(&drawn);
        let variance = noise_white.iter().map(|w| dot(w, w)).sum::<f64>() / (rows * count) as f64;
        println!("{noise:?}: variance of a row {variance:.4}");
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / (rows * count) as f64).sqrt());
        let groups: [&[usize]; 4] = [&[3], &[1, 3], &[1, 2, 3], &[1, 2, 3, 4]];
        for group in groups {
            let columns: Vec<&Vec<f64>> = group.iter().map(|j| &white[*j]).collect();
            let gains: Vec<f64> = noise_white.iter().map(|w| gain(w, &[&white[0]], &columns)).collect();
            let freedom = group.len() as f64;
            let mean = gains.iter().sum::<f64>() / count as f64;
            let mut p: Vec<f64> = gains.iter().map(|gain| stats::chi_squared_p(*gain, freedom)).collect();
            let beyond = p.iter().filter(|p| **p < 0.01).count();
            let apart = distance(&mut p);
            // The same by transforms that take the series as periodic.
            let plain: Vec<Vec<f64>> = group.iter().map(|j| given[*j].clone()).collect();
            let periodic: Vec<f64> = drawn.iter().map(|y| periodic_gain(&plain, y, &density)).collect();
            let periodic_mean = periodic.iter().sum::<f64>() / count as f64;
            println!(
                "  {freedom} columns: mean {mean:.2}, {beyond} of {count} beyond 1 %, distance {apart:.2}; periodic: mean {periodic_mean:.2}"
            );
            assert!((mean - freedom).abs() < 4.0 * (2.0 * freedom / count as f64).sqrt());
            // 4 expected of 400; 13 or more have a probability below 3e-4.
            assert!(beyond <= 12 && apart < 1.95, "{beyond}, {apart}");
        }
    }
}

fn periodic_gain(columns: &[Vec<f64>], y: &[f64], density: &dyn Fn(f64) -> f64) -> f64 {
    let fit = spectral::regress(columns, y, STEP_S, density).expect("a fit");
    let k = columns.len();
    let factor = fit.weighted_covariance.llt(Side::Lower).expect("a factor");
    let mut beta = Mat::from_fn(k, 1, |i, _| fit.weighted[i]);
    factor.L().solve_lower_triangular_in_place(beta.as_mut());
    beta.col_as_slice(0).iter().map(|b| b * b).sum()
}

/// A twentieth of the rows at random, and a gap.
fn known(rows: usize) -> Vec<bool> {
    let mut stream = Stream::new(9, "known");
    (0..rows).map(|row| stream.normal() < 1.645 && !(rows / 3..rows / 3 + rows / 10).contains(&row)).collect()
}

#[test]
fn gains_with_missing_rows_have_their_mean() {
    let count = 400;
    for rows in [1500, 3000] {
        let known = known(rows);
        let left = known.iter().filter(|known| **known).count();
        assert_eq!(left > 2000, rows == 3000, "the one by its covariance, the other filled");
        for (seed, noise) in (rows as u64..).zip(NOISES) {
            let density = density(rows, STEP_S, noise);
            let innovations = Innovations::of_known(&density, &known, STEP_S).expect("innovations");
            assert_eq!(innovations.known(), left);
            let hide = |mut series: Vec<f64>| {
                series.iter_mut().zip(&known).filter(|(_, known)| !**known).for_each(|(x, _)| *x = f64::NAN);
                series
            };
            let drawn: Vec<Vec<f64>> = draws(rows, count, &density, seed).into_iter().map(hide).collect();
            let given: Vec<Vec<f64>> = columns(rows).into_iter().map(hide).collect();
            let (drawn, white) = (innovations.whiten_all(&drawn), innovations.whiten_all(&given));
            let group: Vec<&Vec<f64>> = white[1..].iter().collect();
            let mean = drawn.iter().map(|w| gain(w, &[&white[0]], &group)).sum::<f64>() / count as f64;
            let whole = drawn.iter().map(|w| dot(w, w)).sum::<f64>() / (left * count) as f64;
            println!("{rows} rows {noise:?}: mean gain of 5 columns {mean:.2}, of a known row {whole:.4}");
            assert!((mean - 5.0).abs() < 4.0 * (10.0 / count as f64).sqrt());
            assert!((whole - 1.0).abs() < 5.0 * (2.0 / (left * count) as f64).sqrt());
        }
    }
}

#[test]
fn filled_gaps_leave_gains_their_mean() {
    // With y of the covariance V of the known rows and T the map, the mean gain of columns X is the trace of
    // (XᵀMX)⁻¹ XᵀMVMX, M = TᵀT: without error their number.
    let rows = 3000;
    let known = known(rows);
    let places: Vec<usize> = (0..rows).filter(|row| known[*row]).collect();
    let unit = |place: &usize| (0..rows).map(|row| if row == *place { 1.0 } else { 0.0 }).collect();
    let units: Vec<Vec<f64>> = places.iter().map(unit).collect();
    for noise in NOISES {
        let density = density(rows, STEP_S, noise);
        let lags = lags(rows, STEP_S, &density);
        let covariance = Mat::from_fn(places.len(), places.len(), |i, j| lags[places[i].abs_diff(places[j])]);
        let filled = Innovations::of_known(&density, &known, STEP_S).expect("innovations");
        assert!(filled.log_determinant().is_none());
        let map = filled.whiten_all(&units);
        let map = Mat::from_fn(rows, places.len(), |i, j| map[j][i]);
        let white = filled.whiten_all(&columns(rows));
        let white = Mat::from_fn(rows, white.len(), |i, j| white[j][i]);
        let (inner, weighted) = (white.transpose() * &white, map.transpose() * &white);
        let spread = weighted.transpose() * &covariance * &weighted;
        let factor = inner.llt(Side::Lower).expect("independent columns");
        let gains = faer::linalg::solvers::Solve::solve(&factor, &spread);
        let excess = (0..6).map(|i| gains[(i, i)]).sum::<f64>() - 6.0;
        println!("{noise:?}: the mean gain of 6 columns is above 6 by {excess:.4}");
        assert!((-0.001..0.01).contains(&excess), "{excess}");
    }
}

#[test]
fn times_take_the_same_noise() {
    // Even times, and even ones with some left out.
    let (rows, noise) = (300, (1.2, 1.0, 0.4));
    let flicker = density(rows, STEP_S, (noise.0, noise.1, 0.0));
    let known = known(rows);
    let gaps = Innovations::of_known(&density(rows, STEP_S, noise), &known, STEP_S).expect("innovations");
    let places: Vec<usize> = (0..rows).filter(|row| known[*row]).collect();
    let times: Vec<f64> = places.iter().map(|place| 100.0 + *place as f64 * STEP_S).collect();
    let at_times = Innovations::at_times(&flicker, noise.2 * noise.2, &times, STEP_S).expect("innovations");
    let determinant = |innovations: &Innovations| innovations.log_determinant().expect("a covariance");
    assert!((determinant(&gaps) - determinant(&at_times)).abs() < 1e-3);
    for column in columns(rows) {
        let white = gaps.whiten(&column);
        let short: Vec<f64> = places.iter().map(|place| column[*place]).collect();
        let same = at_times.whiten(&short);
        assert!((dot(&white, &white) / dot(&same, &same) - 1.0).abs() < 1e-3);
        assert!(white.iter().zip(&known).all(|(white, known)| *known || *white == 0.0));
    }
    // Random times: a row's variance under its own covariance, integrated.
    let mut stream = Stream::new(3, "times");
    let times: Vec<f64> = (0..40).map(|row| (f64::from(row) + 0.3 * stream.normal()) * STEP_S).collect();
    let random = Innovations::at_times(&flicker, 0.01, &times, STEP_S).expect("innovations");
    let points = 200_000;
    let spacing_hz = 0.5 / STEP_S / f64::from(points);
    let covariance = |i: usize, j: usize| {
        let cosine = |k: i32| {
            let f = (f64::from(k) + 0.5) * spacing_hz;
            flicker(f) * (TAU * f * (times[i] - times[j])).cos() * spacing_hz
        };
        (0..points).map(cosine).sum::<f64>() + if i == j { 0.01 } else { 0.0 }
    };
    let unit = |j: usize| (0..40).map(|i| if i == j { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
    let inverse_factor = random.whiten_all(&(0..40).map(unit).collect::<Vec<_>>());
    let map = Mat::from_fn(40, 40, |i, j| inverse_factor[j][i]);
    let half = Mat::from_fn(40, 40, |i, j| if j <= i { covariance(i, j) } else { 0.0 });
    let whole = Mat::from_fn(40, 40, |i, j| half[(i.max(j), i.min(j))]);
    let product = &map * &whole * map.transpose();
    let worst = (0..1600)
        .map(|at| (product[(at / 40, at % 40)] - if at / 40 == at % 40 { 1.0 } else { 0.0 }).abs())
        .fold(0.0, f64::max);
    println!("random times: covariance of the whitened rows from the unit matrix by {worst:.1e}");
    assert!(worst < 1e-3);
}

#[test]
fn white_noise_is_a_division() {
    let series: Vec<f64> = (0..50).map(|i| f64::from(i * i % 13)).collect();
    let white = Innovations::of(&|_| 2.0 * 0.25 * 10.0, 50, 10.0).expect("innovations");
    for (white, given) in white.whiten(&series).iter().zip(&series) {
        assert!((white - 2.0 * given).abs() < 1e-12);
    }
    assert!((white.log_determinant().expect("no gaps") - 50.0 * 0.25_f64.ln()).abs() < 1e-10);
}

#[test]
fn threads_change_nothing() {
    let rows = 5000;
    let innovations = Innovations::of(&density(rows, 1.0, (1.3, 1.0, 0.1)), rows, 1.0).expect("innovations");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let alone = one.install(|| innovations.whiten_all(&columns(rows)));
    assert_eq!(alone, innovations.whiten_all(&columns(rows)));
}

#[test]
fn bad_input_is_refused() {
    let message = |found: Result<Innovations, estimate::Error>| found.err().expect("an error").to_string();
    assert!(message(Innovations::of(&|f| 1.0 / f, 100, 1.0)).contains("inf at 0 Hz"));
    assert!(message(Innovations::of(&|_| 1.0, 100, 0.0)).contains("step"));
    assert!(message(Innovations::of_known(&|_| 1.0, &[false; 4], 1.0)).contains("0 readings"));
    let flicker = |f: f64| 1.0 / f.max(0.01);
    assert!(message(Innovations::at_times(&flicker, 0.0, &[0.0, f64::NAN], 1.0)).contains("finite"));
    assert!(message(Innovations::at_times(&flicker, 0.0, &[0.0, 1e9], 1.0)).contains("half a million"));
    assert!(message(Innovations::at_times(&flicker, 0.0, &[0.0, 1.0, 1.0], 1.0)).contains("so close"));
}
