use common::Noise;
use fourier::Complex;

use crate::power_law::powers;
use crate::{Grid, NoiseError, flicker_of};

/// Covariance of readings at given times under a declared noise: of exactly the process that
/// [`crate::series`] draws from. Rows of rows, nT².
///
/// White noise stands on the diagonal. Flicker noise has K(m Δt) = Σ P(f_k)/(nΔt) cos(2π k m/n) over the
/// Fourier frequencies of its grid, read off by the same straight lines between its points. The random walk
/// has r² min(t_i, t_j), counted from the first row. Without times only white noise counts.
pub fn covariance(noise: &Noise, rows: usize, time_s: Option<&[f64]>) -> Result<Vec<f64>, NoiseError> {
    let mut all = vec![0.0; rows * rows];
    let white = noise.white_rms_nt.unwrap_or(0.0);
    (0..rows).for_each(|row| all[row * rows + row] = white * white);
    let Some(time) = time_s.filter(|time| time.len() == rows && rows > 1) else { return Ok(all) };
    if let Some((amplitude, exponent)) = flicker_of(noise)? {
        let grid = Grid::of(time)?;
        let lags = autocovariance(grid.points, grid.step_s, amplitude, exponent);
        let places: Vec<(usize, f64)> =
            time.iter().enumerate().map(|(row, t)| grid.place(row, *t, time[0])).collect();
        for i in 0..rows {
            for j in 0..=i {
                let value = between(&lags, places[i], places[j]);
                all[i * rows + j] += value;
                if i != j {
                    all[j * rows + i] += value;
                }
            }
        }
    }
    let rate = noise.random_walk_nt_per_sqrt_s.unwrap_or(0.0);
    for i in 0..rows {
        for j in 0..rows {
            all[i * rows + j] += rate * rate * (time[i].min(time[j]) - time[0]);
        }
    }
    Ok(all)
}

/// Covariance of two readings off the grid: each is a straight line between two of its points.
fn between(lags: &[f64], (i, a): (usize, f64), (j, b): (usize, f64)) -> f64 {
    let ends = |point: usize, share: f64| [(point, 1.0 - share), (point + 1, share)];
    let lag = |i: usize, j: usize| lags.get(i.abs_diff(j)).copied().unwrap_or(0.0);
    let of = |(j, other): (usize, f64)| ends(i, a).map(|(i, own)| own * other * lag(i, j));
    ends(j, b).into_iter().flat_map(of).sum()
}

/// K(m Δt), m = 0 … n − 1, of power-law noise on an even grid of n points.
fn autocovariance(points: usize, step_s: f64, amplitude: f64, exponent: f64) -> Vec<f64> {
    let power = powers(points, step_s, amplitude, exponent).into_iter().map(Complex::from).collect();
    fourier::inverse(power, points)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::series;

    /// White, flicker and walk together.
    pub(crate) fn declared() -> Noise {
        Noise {
            white_rms_nt: Some(0.4),
            flicker_nt2_per_hz_at_1hz: Some(0.3),
            flicker_exponent: Some(1.2),
            random_walk_nt_per_sqrt_s: Some(0.2),
            ..Noise::default()
        }
    }

    #[test]
    fn it_is_the_covariance_of_what_is_drawn() {
        // At even and uneven times: 40 000 draws against the covariance, five standard errors.
        let noise = declared();
        for time in [vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], vec![0.0, 1.0, 2.0, 3.5, 4.0, 9.2, 10.0]] {
            let rows = time.len();
            let expected = covariance(&noise, rows, Some(&time)).expect("a covariance");
            let draws = 40_000;
            let mut sums = vec![0.0; rows * rows];
            for seed in 0..draws {
                let drawn = series(&noise, seed, "x", rows, Some(&time)).expect("noise");
                for (at, sum) in sums.iter_mut().enumerate() {
                    *sum += drawn[at / rows] * drawn[at % rows];
                }
            }
            for (at, sum) in sums.iter().enumerate() {
                let (i, j) = (at / rows, at % rows);
                let variance = expected[i * rows + i] * expected[j * rows + j] + expected[at].powi(2);
                let error = (variance / draws as f64).sqrt();
                assert!((sum / draws as f64 - expected[at]).abs() < 5.0 * error, "{i} {j}");
            }
        }
    }
}
