//! A source near the pair, of which the test instrument has less than the reference: weights that rest on it
//! would leave more of the natural field than levels alone do, and least squares stand in their place.

use std::f64::consts::TAU;

use noise::Stream;

use crate::answers::found;
use crate::pair_in_time::{both, document};

const ROWS: usize = 20_000;
/// The share of the near source that is in the test instrument's z.
const SHARE: f64 = 0.9;

#[test]
fn a_matrix_by_least_squares_has_its_own_covariance() {
    let mut stream = Stream::new(8, "near source");
    let slow = |row: usize, axis: usize| {
        let phase = TAU * row as f64 / ROWS as f64;
        [30.0, 20.0, 40.0][axis] * (phase + axis as f64).sin() + 15.0 * ((2 + axis) as f64 * phase).cos()
    };
    let mut near = vec![0.0; ROWS];
    for pulse in 0..ROWS / 300 {
        let (middle, size) = (300.0 * pulse as f64 + 150.0 + 60.0 * stream.normal(), 8.0 * stream.normal());
        for (row, value) in near.iter_mut().enumerate() {
            *value += size * (-((row as f64 - middle) / 25.0).powi(2)).exp();
        }
    }
    let mut made = |share: f64| -> [Vec<f64>; 3] {
        std::array::from_fn(|axis| {
            let own = |row: usize| if axis == 2 { share * near[row] } else { 0.0 };
            (0..ROWS).map(|row| slow(row, axis) + own(row) + 0.01 * stream.normal()).collect()
        })
    };
    let (reference, test) = (made(1.0), made(SHARE));
    let time: Vec<f64> = (0..ROWS).map(|row| row as f64).collect();
    let found = found(&document(vec![both("pair", &time, [&reference, &test], &(0..ROWS))]), false);
    let fit = found.fit.expect("a fit");
    for (axis, of) in fit.axes.iter() {
        assert!(of.left_nt() <= of.rms_of_levels_nt.expect("told"), "{axis}: {of:?}");
    }
    // The natural field is alike in both; by the near source z would be SHARE.
    let (zz, covariance) = (found.matrix.expect("a matrix")[2][2], found.covariance.expect("its covariance"));
    // Under the noise of the fit that was refused the uncertainty would be 0.06.
    let std = covariance[8][8].sqrt();
    assert!(std < 0.02 && (zz - 1.0).abs() < 3.0 * std, "{zz} ± {std}");
}
