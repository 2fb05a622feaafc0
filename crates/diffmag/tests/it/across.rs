//! Noise that two axes of the test instrument have in common is in the covariance of η. FLUXCAL_CAMPAIGNS
//! sets how many campaigns.

use noise::Stream;
use rayon::prelude::*;

use crate::answers::found;
use crate::pair_in_time::{ETA, Made, document};

const COMMON_NT: f64 = 0.05;
const OWN_NT: f64 = 0.02;

#[test]
fn common_noise_is_in_the_covariance() {
    let count = testkit::campaigns(4);
    // Squares of η_ix ∓ η_iy over their standard uncertainties.
    let all: Vec<[f64; 6]> = (0..count)
        .into_par_iter()
        .map(|seed: u64| {
            let made = Made { white_nt: OWN_NT, ..Made::new(900 + seed) };
            let mut recording = made.both("pair", 0..made.rows);
            for name in ["test_x_nt", "test_y_nt"] {
                let mut stream = Stream::new(seed, "common");
                let column = &mut recording.columns[name];
                column.iter_mut().for_each(|value| *value += COMMON_NT * stream.normal());
            }
            let found = found(&document(vec![recording]), false);
            let (matrix, covariance) = (found.matrix.expect("η"), found.covariance.expect("its covariance"));
            std::array::from_fn(|k| {
                let (i, sign) = (k / 2, [-1.0, 1.0][k % 2]);
                let off = matrix[i][0] - ETA[i][0] + sign * (matrix[i][1] - ETA[i][1]);
                let (x, y) = (i, 3 + i);
                off * off / (covariance[x][x] + covariance[y][y] + 2.0 * sign * covariance[x][y])
            })
        })
        .collect();
    let mean = |k: usize| {
        let squares: f64 = all.iter().map(|of| of[k] + of[k + 2] + of[k + 4]).sum();
        squares / (3 * count) as f64
    };
    // Axis by axis they would be 0.14 and 1.86.
    let (difference, sum) = (mean(0), mean(1));
    println!("{count} campaigns: mean square of z of differences {difference:.2}, of sums {sum:.2}");
    let slack = 4.0 * (2.0 / (3 * count) as f64).sqrt();
    assert!((difference - 1.0).abs() < slack.min(0.8), "{difference}");
    assert!((sum - 1.0).abs() < slack.min(0.8), "{sum}");
}
