use std::ops::Range;

use common::Noise;
use fourier::Complex;

use crate::power_law::powers;
use crate::{Grid, NoiseError, flicker_of};

/// Covariance of means of readings under a declared noise, of exactly the process that [`crate::series`]
/// draws from: rows of rows, nT².
///
/// Each group is a run of rows, in order and apart; `counts` says which are there. White noise falls as σ²/n.
/// Flicker noise has Σ P(f_k)/(nΔt) Re(W_a(f_k) W_b*(f_k)) over the Fourier frequencies of its grid, W the
/// transform of a mean's weights. The random walk has r² times the mean of min(t_i, t_j), counted from the
/// first row. Without times only white noise counts.
///
/// Errors: as [`crate::series`].
pub fn covariance_of_means(
    noise: &Noise,
    time_s: Option<&[f64]>,
    groups: &[Range<usize>],
    counts: impl Fn(usize) -> bool,
) -> Result<Vec<f64>, NoiseError> {
    let many = groups.len();
    let members: Vec<Vec<usize>> =
        groups.iter().map(|group| group.clone().filter(|row| counts(*row)).collect()).collect();
    let mut all = vec![0.0; many * many];
    let white = noise.white_rms_nt.unwrap_or(0.0);
    for (group, rows) in members.iter().enumerate() {
        all[group * many + group] = white * white / rows.len() as f64;
    }
    let Some(time) = time_s.filter(|time| time.len() > 1) else { return Ok(all) };
    if let Some((amplitude, exponent)) = flicker_of(noise)? {
        let grid = Grid::of(time)?;
        let spectra: Vec<Vec<Complex<f64>>> = members
            .iter()
            .map(|rows| {
                let mut weights = vec![0.0; grid.points];
                for row in rows {
                    let (point, share) = grid.place(*row, time[*row], time[0]);
                    weights[point] += (1.0 - share) / rows.len() as f64;
                    // Rounding may leave a share of a point behind the last one.
                    if let Some(next) = weights.get_mut(point + 1).filter(|_| share > 0.0) {
                        *next += share / rows.len() as f64;
                    }
                }
                fourier::forward(weights)
            })
            .collect();
        // One side of the spectrum: each frequency counts twice but the Nyquist frequency once.
        let mut power = powers(grid.points, grid.step_s, amplitude, exponent);
        for (k, power) in power.iter_mut().enumerate() {
            *power *= if 2 * k == grid.points { 1.0 } else { 2.0 };
        }
        for a in 0..many {
            for b in 0..=a {
                let both = spectra[a].iter().zip(&spectra[b]).zip(&power);
                let value: f64 = both.map(|((a, b), power)| power * (a.re * b.re + a.im * b.im)).sum();
                all[a * many + b] += value;
                if a != b {
                    all[b * many + a] += value;
                }
            }
        }
    }
    let rate = noise.random_walk_nt_per_sqrt_s.unwrap_or(0.0);
    if rate > 0.0 {
        for a in 0..many {
            // A later mean shares with an earlier one the walk to each of the earlier one's rows.
            let rows = &members[a];
            let count = rows.len() as f64;
            let since = |row: usize| time[row] - time[0];
            let mean = rows.iter().map(|row| since(*row)).sum::<f64>() / count;
            let before = |(place, row): (usize, &usize)| (2.0 * (count - place as f64) - 1.0) * since(*row);
            all[a * many + a] +=
                rate * rate * rows.iter().enumerate().map(before).sum::<f64>() / (count * count);
            for b in a + 1..many {
                all[a * many + b] += rate * rate * mean;
                all[b * many + a] += rate * rate * mean;
            }
        }
    }
    Ok(all)
}

/// Variance of the mean of all readings, nT².
///
/// Errors: as [`crate::series`].
pub fn mean_variance(noise: &Noise, rows: usize, time_s: Option<&[f64]>) -> Result<f64, NoiseError> {
    let whole = 0..rows;
    let time = time_s.filter(|time| time.len() == rows);
    Ok(covariance_of_means(noise, time, std::slice::from_ref(&whole), |_| true)?[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::covariance;
    use crate::covariance::tests::declared;

    #[test]
    fn it_is_that_of_the_readings_taken_together() {
        let noise = declared();
        let even: Vec<f64> = (0..12).map(f64::from).collect();
        let settling: Vec<f64> = (0..12).map(|row| f64::from(row) + f64::from(row / 3) * 10.5).collect();
        for time in [even, settling] {
            let each = covariance(&noise, 12, Some(&time)).expect("a covariance");
            let (whole, mean) = (mean_variance(&noise, 12, Some(&time)), each.iter().sum::<f64>() / 144.0);
            assert!((whole.expect("a variance") / mean - 1.0).abs() < 1e-12);
            let groups = [0..3, 3..6, 7..8, 8..12];
            let there = |row: usize| row != 4 && row != 9;
            let means = covariance_of_means(&noise, Some(&time), &groups, there).expect("a covariance");
            for (a, first) in groups.iter().enumerate() {
                for (b, second) in groups.iter().enumerate() {
                    let rows =
                        |group: &Range<usize>| group.clone().filter(|row| there(*row)).collect::<Vec<_>>();
                    let (first, second) = (rows(first), rows(second));
                    let of = |i: &usize| second.iter().map(|j| each[i * 12 + j]).sum::<f64>();
                    let sum: f64 = first.iter().map(of).sum();
                    let expected = sum / (first.len() * second.len()) as f64;
                    let found = means[a * 4 + b];
                    assert!((found - expected).abs() < 1e-12, "{a} {b}: {found} {expected}");
                }
            }
        }
    }
}
