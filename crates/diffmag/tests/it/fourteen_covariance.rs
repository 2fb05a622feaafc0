//! The covariance against draws: η and what is known vary, and the answers must vary as stated.

use diffmag::fourteen::{EtaCovariance, KnownFive, NAMES, solve};
use nalgebra::{Matrix3, SMatrix, SVector};
use noise::Stream;

use crate::pairs::{eta_of, known, parameters};

const DRAWS: usize = 8_000;

/// A full covariance L Lᵀ and its L, of standard deviations about `sigma`.
fn correlated<const N: usize>(stream: &mut Stream, sigma: f64) -> [SMatrix<f64, N, N>; 2] {
    let factor = SMatrix::<f64, N, N>::from_fn(|i, j| {
        let own = if i == j { 1.0 } else { 0.0 };
        sigma * (own + 0.4 * stream.normal())
    });
    [factor * factor.transpose(), factor]
}

#[test]
fn stated_covariance_is_the_spread_of_draws() {
    let truth = parameters([35.0, 6.0, 9.0, 84.0, 97.0, -5.0, 82.0, 140.0, 8.0], [1.3, 0.8, 1.2, 0.9, 1.15]);
    let eta = eta_of(&truth);
    for (name, mut known) in ["tilts", "test"].into_iter().zip(known(&truth)) {
        let mut stream = Stream::new(14, name);
        let [covariance, factor] = correlated::<9>(&mut stream, 1e-4);
        let [five, five_factor] = correlated::<5>(&mut stream, 1e-4);
        known.covariance = five;
        let stated = solve(&eta, &covariance, &known).expect("an answer");
        assert!(stated.undetermined.is_empty());
        // How far answers for draws of η and the known values about the truth are from the stated one.
        let off: Vec<[f64; 14]> = (0..DRAWS)
            .map(|_| {
                let by = factor * SVector::<f64, 9>::from_fn(|_, _| stream.normal());
                let drawn = eta + Matrix3::from_column_slice(by.as_slice());
                let by = five_factor * SVector::<f64, 5>::from_fn(|_, _| stream.normal());
                let values = std::array::from_fn(|i| known.values[i] + by[i]);
                let known = KnownFive { values, ..known.clone() };
                let found = solve(&drawn, &EtaCovariance::zeros(), &known).expect("an answer").values;
                std::array::from_fn(|i| found[i] - stated.values[i])
            })
            .collect();
        let mut worst = 0.0_f64;
        for i in 0..14 {
            for j in 0..=i {
                let found = off.iter().map(|o| o[i] * o[j]).sum::<f64>() / DRAWS as f64;
                let [vi, vj, cij] = [(i, i), (j, j), (i, j)].map(|at| stated.covariance[at]);
                let sampling = ((vi * vj + cij * cij) / DRAWS as f64).sqrt();
                let z = (found - cij) / sampling;
                worst = worst.max(z.abs());
                assert!(z.abs() < 4.5, "{name} {} {}: {found:.4e} {cij:.4e} ({z:.1})", NAMES[i], NAMES[j]);
            }
        }
        println!("{name}: the worst of 105 covariances is off by {worst:.2} of its sampling error");
    }
}

/// The share of 95 % intervals that hold the truth, for tilts of 0 to 30 of their uncertainty. Near the
/// vertical they are wide on purpose; nowhere are they narrow.
#[test]
fn intervals_hold_the_truth_at_any_tilt() {
    let sigma = 1e-4;
    let covariance = EtaCovariance::identity() * (sigma * sigma);
    for steps in [0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 30.0] {
        let mut truth = parameters([30.0, 2.0, 0.0, 90.0, 90.0, 0.0, 90.0, 60.0, 0.0], [1.0; 5]);
        (truth[2], truth[8]) = (steps * sigma, steps * sigma);
        let (eta, [_, known]) = (eta_of(&truth), known(&truth));
        let mut stream = Stream::new(16, "tilts");
        let mut held = [0; 14];
        let draws = 4_000;
        for _ in 0..draws {
            let drawn = eta + Matrix3::from_fn(|_, _| sigma * stream.normal());
            let found = solve(&drawn, &covariance, &known).expect("an answer");
            let uncertainty = found.uncertainties();
            for (i, held) in held.iter_mut().enumerate() {
                let off = found.values[i] - truth[i];
                let off = if NAMES[i].ends_with("_rad") { off.sin().atan2(off.cos()) } else { off };
                *held += i32::from(off.abs() <= 1.96 * uncertainty[i]);
            }
        }
        let share = held.map(|held| f64::from(held) / f64::from(draws));
        println!("{steps}: {share:.3?}");
        // The last two are known here, and exact.
        assert_eq!(share[12..], [1.0, 1.0]);
        for (i, share) in share[..12].iter().enumerate() {
            let near_vertical = [0, 2, 7, 8].contains(&i) && steps < 10.0;
            assert!(*share > 0.93 && (near_vertical || *share < 0.97), "{steps} {}: {share}", NAMES[i]);
        }
    }
}
