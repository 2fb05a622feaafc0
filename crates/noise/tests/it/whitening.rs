//! Whitening against the dense covariance of its model, against power laws and against noise that is drawn.

use common::Noise;
use nalgebra::{DMatrix, DVector};
use noise::{NoiseError, Stream, Whitening, series};

fn declared(white: f64, flicker: f64, exponent: f64, walk: f64) -> Noise {
    Noise {
        white_rms_nt: Some(white),
        flicker_nt2_per_hz_at_1hz: Some(flicker),
        flicker_exponent: Some(exponent),
        random_walk_nt_per_sqrt_s: Some(walk),
        ..Noise::default()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Even, uneven and gapped times, and such with readings at one time.
fn times(rows: usize) -> [Vec<f64>; 4] {
    let even = |row: usize| 100.0 + 0.1 * row as f64;
    let uneven = (0..rows).map(|row| even(row) + 0.04 * (row as f64 * 1.7).sin());
    let gapped = (0..2 * rows).filter(|row| row % 7 != 3 && !(40..90).contains(row)).take(rows).map(even);
    let repeated = (0..rows).map(|row| even(row - row % 3));
    [(0..rows).map(even).collect(), uneven.collect(), gapped.collect(), repeated.collect()]
}

#[test]
fn it_is_the_inverse_of_the_root_of_the_covariance() {
    let rows = 300;
    let noises = [
        declared(0.3, 0.2, 1.0, 0.0),
        declared(0.3, 0.2, 1.5, 0.1),
        declared(0.01, 0.3, 0.5, 0.0),
        declared(0.1, 0.0, 1.0, 0.4),
        declared(0.1, 0.4, 2.0, 0.0),
        declared(0.1, 0.4, 0.0, 0.2),
        declared(0.0, 0.2, 1.3, 0.0),
    ];
    for (number, noise) in noises.iter().enumerate() {
        for (which, time) in times(rows).iter().enumerate() {
            if number == 6 && which == 3 {
                // Readings at equal times without white noise: known but for a billionth, see below.
                continue;
            }
            let whitening = Whitening::of(noise, Some(time), rows, 300.0).expect("a whitening");
            let covariance = whitening.covariance();
            let matrix = DMatrix::from_row_slice(rows, rows, &covariance);
            let l = matrix.cholesky().expect("positive definite").unpack();
            let solve =
                |y: &Vec<f64>| l.solve_lower_triangular(&DVector::from_column_slice(y)).expect("a root");
            let mut stream = Stream::new(number as u64, "columns");
            let mut columns: Vec<Vec<f64>> =
                (0..11).map(|_| (0..rows).map(|_| stream.normal()).collect()).collect();
            columns.push((0..rows).map(|row| if row < 200 { 0.0 } else { 1.0 }).collect());
            let expected: Vec<DVector<f64>> = columns.iter().map(solve).collect();
            let alone: Vec<Vec<f64>> = columns.iter().map(|column| whitening.whiten(column)).collect();
            let originals = columns.clone();
            whitening.whiten_all(&mut columns);
            assert!(columns == alone, "a column alone becomes what it becomes among others");
            let mut by_rows: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
            whitening.by_rows(&originals, |some| {
                let rows = some.len() / by_rows.len();
                by_rows.iter_mut().zip(some.chunks(rows)).for_each(|(all, some)| all.extend(some));
            });
            assert!(by_rows == columns, "block by block they become the same");
            let norms = whitening.step_norms();
            for from in [0, 1, 150, rows - 1] {
                let step: Vec<f64> = (0..rows).map(|row| f64::from(u8::from(row >= from))).collect();
                let white = whitening.whiten(&step);
                let norm = dot(&white, &white);
                assert!((norms[from] - norm).abs() < 1e-8 * norm, "{number} {which} {from}: {norm}");
            }
            let mut farthest = 0f64;
            for (column, expected) in columns.iter().zip(&expected) {
                let size = expected.iter().map(|value| value.abs()).fold(1.0, f64::max);
                for (is, should) in column.iter().zip(expected) {
                    farthest = farthest.max((is - should).abs() / size);
                }
            }
            assert!(farthest < 1e-9, "noise {number}, times {which}: {farthest}");

            let logarithm: f64 = (0..rows).map(|row| 2.0 * l[(row, row)].ln()).sum();
            let error = (whitening.log_determinant() - logarithm).abs();
            assert!(error < 1e-9 * rows as f64, "{error}");

            let trace: f64 = (0..rows).map(|row| covariance[row * (rows + 1)]).sum();
            let about = (trace - covariance.iter().sum::<f64>() / rows as f64) / rows as f64;
            assert!((whitening.variance_nt2() / about - 1.0).abs() < 1e-9, "{about}");

            let mut departure = vec![0.0; rows];
            departure[150] = 1.0;
            assert_eq!(whitening.response(), whitening.whiten(&departure)[150..]);
        }
    }
}

/// A series too long for its gains to be kept begins as a short one, whose gains are.
#[test]
fn a_long_series_begins_as_a_short_one() {
    let (long, short) = (400_000, 700);
    let time: Vec<f64> = (0..long).map(|row| 0.125 * (row + row / 3) as f64).collect();
    let noise = declared(0.3, 0.2, 1.5, 0.1);
    let of = |rows: usize| Whitening::of(&noise, Some(&time[..rows]), rows, 300.0).expect("a whitening");
    let mut stream = Stream::new(4, "long");
    let series: Vec<f64> = (0..long).map(|_| stream.normal()).collect();
    let (whole, beginning) = (of(long).whiten(&series), of(short).whiten(&series[..short]));
    for (row, (a, b)) in whole.iter().zip(&beginning).enumerate() {
        assert_eq!(a, b, "{row}");
    }
    assert!(whole.iter().all(|value| value.is_finite()));
}

/// C⁻¹ + 1 1ᵀ/(n s)² of readings whose mean is known besides, and the determinant of its inverse.
#[test]
fn a_known_mean_is_one_more_observation() {
    let rows = 200;
    for noise in [declared(0.3, 0.2, 1.5, 0.1), declared(0.1, 0.4, 2.0, 0.0), declared(0.1, 0.0, 1.0, 0.4)] {
        for time in &times(rows)[..3] {
            let without = Whitening::of(&noise, Some(time), rows, 300.0).expect("a whitening");
            let with = without.clone().with_level(0.02);
            let mut stream = Stream::new(3, "columns");
            let [one, other] = [0, 1].map(|_| (0..rows).map(|_| stream.normal()).collect::<Vec<f64>>());
            let mean = |y: &[f64]| y.iter().sum::<f64>() / rows as f64;
            let product = |noise: &Whitening| dot(&noise.whiten(&one), &noise.whiten(&other));
            let expected = product(&without) + mean(&one) * mean(&other) / (0.02 * 0.02);
            assert!((product(&with) / expected - 1.0).abs() < 1e-9, "{} {expected}", product(&with));
            // 1ᵀC1/n² is the variance of the mean without the knowledge.
            let covariance = without.covariance();
            let sums: Vec<f64> = covariance.chunks(rows).map(|row| row.iter().sum()).collect();
            let ratio = 1.0 + mean(&sums) / (rows as f64 * 0.02 * 0.02);
            let lower = without.log_determinant() - with.log_determinant();
            assert!((lower - ratio.ln()).abs() < 1e-9, "{lower} {}", ratio.ln());
        }
    }
}

#[test]
fn readings_at_one_time_without_white_noise_are_finite() {
    let rows = 90;
    let noise = declared(0.0, 0.2, 1.3, 0.0);
    let whitening = Whitening::of(&noise, Some(&times(rows)[3]), rows, 100.0).expect("a whitening");
    let field: Vec<f64> = (0..rows).map(|row| (row / 3) as f64).collect();
    assert!(whitening.whiten(&field).iter().all(|value| value.abs() < 1e3));
}

#[test]
fn processes_follow_the_power_law() {
    // Within 1 % from one over the longest period to half the Nyquist frequency, within 15 % beyond.
    for exponent in [0.5, 1.0, 1.3, 1.5, 2.0] {
        let time: Vec<f64> = (0..1000).map(|row| f64::from(row) * 0.02).collect();
        let noise = Noise { white_rms_nt: Some(0.05), ..declared(0.0, 3e-3, exponent, 0.01) };
        let whitening = Whitening::of(&noise, Some(&time), 1000, 400.0).expect("a whitening");
        let mut f = 1.0 / 400.0;
        while f <= 25.0 {
            // What the walk has folded down is its own.
            let sine = (std::f64::consts::PI * f * 0.02).sin();
            let folded = 1e-4 / 2.0 * ((0.02 / sine).powi(2) - (std::f64::consts::PI * f).powi(-2));
            let ratio = (whitening.sampled_density(f, 0.02) - folded) / noise.density(f, 0.02);
            let within = if f <= 12.5 { 0.01 } else { 0.15 };
            assert!((ratio - 1.0).abs() < within, "{exponent} at {f} Hz: {ratio}");
            assert!(whitening.density(f) > 0.0);
            f *= 1.02;
        }
    }
}

#[test]
fn drawn_noise_becomes_white() {
    // 4096 rows: the variance of white noise has the standard deviation √(2/n) = 2.2 %; 4 of them, and 1 %
    // for the model.
    let rows = 4096;
    let time: Vec<f64> = (0..rows).map(|row| row as f64 * 0.1).collect();
    for (exponent, flicker) in [(1.0, 0.05), (1.5, 0.05), (1.0, 0.5)] {
        let noise = declared(0.3, flicker, exponent, 0.0);
        let drawn = series(&noise, 5, "drawn", rows, Some(&time)).expect("noise");
        let white = Whitening::of(&noise, Some(&time), rows, 409.6).expect("a whitening").whiten(&drawn);
        let mean = |lag: usize| dot(&white, &white[lag..]) / rows as f64;
        assert!((mean(0) - 1.0).abs() < 0.1, "{exponent}: {}", mean(0));
        for lag in 1..=5 {
            assert!(mean(lag).abs() < 4.0 / (rows as f64).sqrt(), "{lag}: {}", mean(lag));
        }
    }
}

#[test]
fn printed_times_are_even() {
    let rows = 500;
    let exact: Vec<f64> = (0..rows).map(|row| row as f64 / 22.0).collect();
    let printed: Vec<f64> = exact.iter().map(|t| (t * 1e6).floor() / 1e6).collect();
    let noise = declared(0.1, 0.2, 1.2, 0.05);
    let whitening = |time: &[f64]| Whitening::of(&noise, Some(time), rows, 100.0).expect("a whitening");
    // Two rows a step apart anywhere are as correlated as any others: but for the walk's, the covariance has
    // equal diagonals.
    let covariance = whitening(&printed).covariance();
    let walk = |i: usize| 0.05f64.powi(2) * i as f64 / 22.0;
    for i in 1..rows {
        let (first, here) = (covariance[1] - walk(0), covariance[i * rows + i - 1] - walk(i - 1));
        assert!((first / here - 1.0).abs() < 1e-5, "{i}");
    }
    let unit: Vec<f64> = (0..rows).map(|row| (row as f64).sin()).collect();
    for (a, b) in whitening(&printed).whiten(&unit).iter().zip(whitening(&exact).whiten(&unit)) {
        assert!((a - b).abs() < 1e-4);
    }
}

#[test]
fn what_cannot_be_whitened_is_refused() {
    let time = [0.0, 1.0, 2.0, 1.5];
    let of = |noise: &Noise, time: Option<&[f64]>, oldest_s| Whitening::of(noise, time, 4, oldest_s).err();
    let flicker = declared(0.1, 0.2, 1.0, 0.0);
    assert_eq!(of(&flicker, Some(&time), 10.0), Some(NoiseError::Disorder(3)));
    let even = [0.0, 1.0, 2.0, 3.0];
    assert_eq!(of(&declared(0.1, 0.2, 2.5, 0.0), Some(&even), 10.0), Some(NoiseError::Exponent(2.5)));
    assert_eq!(of(&declared(0.0, 0.0, 1.0, 0.0), Some(&even), 10.0), Some(NoiseError::Nothing));
    assert_eq!(of(&declared(0.0, 0.2, 1.0, 0.0), None, 10.0), Some(NoiseError::Nothing));
    assert_eq!(of(&flicker, Some(&even), 0.0), Some(NoiseError::Length(0.0, 1.0)));
    // White noise needs no times, nor such in order.
    let white = declared(0.5, 0.0, 1.0, 0.0);
    for time in [None, Some(&time[..])] {
        let whitening = Whitening::of(&white, time, 4, 10.0).expect("a whitening");
        assert_eq!(whitening.whiten(&[1.0, 2.0, -1.0, 0.0]), [2.0, 4.0, -2.0, 0.0]);
        assert!((whitening.log_determinant() - 4.0 * 0.25f64.ln()).abs() < 1e-12);
        assert_eq!(whitening.response(), [2.0, 0.0]);
        assert_eq!(whitening.step_norms(), [16.0, 12.0, 8.0, 4.0]);
    }
}

#[test]
fn the_transposed_filter_is_the_filters_transpose() {
    for time in times(50) {
        for noise in
            [declared(1.0, 0.0, 1.0, 0.0), declared(0.3, 2.0, 1.2, 0.0), declared(0.2, 1.0, 0.8, 0.1)]
        {
            let whitening = Whitening::of(&noise, Some(&time), 50, 200.0).expect("a noise");
            let [a, b]: [Vec<f64>; 2] =
                [0.7, 1.9].map(|w: f64| (0..50).map(|row| (w * f64::from(row)).sin()).collect());
            let (one, other) = (dot(&whitening.whiten(&a), &b), dot(&a, &whitening.whiten_transposed(&b)));
            assert!((one - other).abs() < 1e-9 * one.abs().max(1.0), "{one} {other}");
        }
    }
}

#[test]
fn the_most_likely_noise_is_the_covariance_times_the_inverse() {
    for noise in [declared(0.3, 2.0, 1.2, 0.0), declared(0.2, 1.0, 0.8, 0.1)] {
        // The first two rows are at one time.
        let time: Vec<f64> =
            (0..30).map(|row| f64::from(row.max(1)) + 0.3 * f64::from(row.max(1) % 3)).collect();
        let all = Whitening::of(&noise, Some(&time), 30, 200.0).expect("a noise");
        let covariance = all.covariance();
        let v: Vec<f64> = (0..30).map(|row| (0.9 * f64::from(row)).sin()).collect();
        let found = all.most_likely(&time, std::slice::from_ref(&v), &time).concat();
        for (row, found) in found.iter().enumerate() {
            // Without the white part, which is the row's own.
            let expected: f64 = (0..30).map(|other| covariance[row * 30 + other] * v[other]).sum::<f64>()
                - all.white_nt2() * v[row];
            assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{row}: {found} {expected}");
        }
    }
}
