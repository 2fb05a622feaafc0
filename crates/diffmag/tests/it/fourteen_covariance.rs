//! The covariance against draws: η and what is known vary, and the answers must vary as stated.

use diffmag::fourteen::{EtaCovariance, KnownAxes, KnownFive, NAMES, UNDETERMINED_RAD, eta_of, solve};
use nalgebra::{Matrix3, SMatrix, SVector};
use noise::Stream;

use crate::pairs::{parameters, reference, test, tilts};

const DRAWS: usize = 8_000;

/// A full covariance L Lᵀ and its L, of standard deviations about `sigma`.
fn correlated<const N: usize>(stream: &mut Stream, sigma: f64) -> [SMatrix<f64, N, N>; 2] {
    let factor = SMatrix::<f64, N, N>::from_fn(|i, j| {
        let own = if i == j { 1.0 } else { 0.0 };
        sigma * (own + 0.4 * stream.normal())
    });
    [factor * factor.transpose(), factor]
}

/// The five values moved.
fn moved(known: &KnownFive, by: &SVector<f64, 5>) -> KnownFive {
    let add = |v: [f64; 3]| std::array::from_fn(|i| v[i] + by[i]);
    let axes = match known.axes {
        KnownAxes::Reference(v) => KnownAxes::Reference(add(v)),
        KnownAxes::ReferenceTilts(v) => KnownAxes::ReferenceTilts(add(v)),
        KnownAxes::Test(v) => KnownAxes::Test(add(v)),
    };
    KnownFive {
        axes,
        ratios: [known.ratios[0] + by[3], known.ratios[1] + by[4]],
        covariance: known.covariance,
    }
}

/// Answers for draws of η and the known values about the truth.
fn draws(
    eta: &Matrix3<f64>,
    known: &KnownFive,
    factors: (&SMatrix<f64, 9, 9>, &SMatrix<f64, 5, 5>),
    stream: &mut Stream,
    count: usize,
) -> Vec<[f64; 14]> {
    (0..count)
        .map(|_| {
            let off = factors.0 * SVector::<f64, 9>::from_fn(|_, _| stream.normal());
            let by = factors.1 * SVector::<f64, 5>::from_fn(|_, _| stream.normal());
            let drawn = eta + Matrix3::from_column_slice(off.as_slice());
            solve(&drawn, &EtaCovariance::zeros(), &moved(known, &by)).expect("an answer").values
        })
        .collect()
}

#[test]
fn stated_covariance_is_the_spread_of_draws() {
    let truth = parameters([35.0, 6.0, 9.0, 84.0, 97.0, -5.0, 82.0, 140.0, 8.0], [1.3, 0.8, 1.2, 0.9, 1.15]);
    let eta = eta_of(&truth);
    for (name, mut known) in
        [("reference", reference(&truth)), ("tilts", tilts(&truth)), ("test", test(&truth))]
    {
        let mut stream = Stream::new(14, name);
        let [covariance, factor] = correlated::<9>(&mut stream, 1e-4);
        let [five, five_factor] = correlated::<5>(&mut stream, 1e-4);
        known.covariance = five;
        let stated = solve(&eta, &covariance, &known).expect("an answer");
        assert!(stated.undetermined.is_empty());
        let drawn = draws(&eta, &known, (&factor, &five_factor), &mut stream, DRAWS);
        let off: Vec<[f64; 14]> =
            drawn.iter().map(|values| std::array::from_fn(|i| values[i] - stated.values[i])).collect();
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

/// Of a vertical axis the azimuth is anywhere, and the polar angle has the stated mean square about 0.
#[test]
fn stated_spread_of_a_vertical_axis() {
    let truth = parameters([0.0, 2.0, 0.0, 90.0, 90.0, 0.0, 90.0, 0.0, 0.0], [1.0; 5]);
    let eta = eta_of(&truth);
    let sigma = 1e-4;
    let covariance = EtaCovariance::identity() * (sigma * sigma);
    let known = test(&truth);
    let stated = solve(&eta, &covariance, &known).expect("an answer");
    let mut stream = Stream::new(15, "vertical");
    let factors = (&(EtaCovariance::identity() * sigma), &SMatrix::zeros());
    let drawn = draws(&eta, &known, factors, &mut stream, 4_000);
    let mean_square =
        |i: usize| drawn.iter().map(|values| values[i].powi(2)).sum::<f64>() / drawn.len() as f64;
    for (azimuth, polar) in [(0, 2), (7, 8)] {
        let ratio = (mean_square(polar) / stated.covariance[(polar, polar)]).sqrt();
        assert!((ratio - 1.0).abs() < 0.04, "{}: {ratio}", NAMES[polar]);
        let spread = mean_square(azimuth).sqrt() / UNDETERMINED_RAD;
        println!("{}: {ratio:.3}, {}: {spread:.3}", NAMES[polar], NAMES[azimuth]);
        assert!((spread - 1.0).abs() < 0.25, "{}: {spread}", NAMES[azimuth]);
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
        let (eta, known) = (eta_of(&truth), test(&truth));
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
