//! Least-squares sine of a known frequency, with the uncertainty that the noise at that frequency gives.

use faer::Mat;

use crate::{Error, Svd};

/// Neighbouring frequencies on each side from which the noise is read.
const NEIGHBOURS: usize = 12;
/// Neighbours nearer than this (in units of one over the record's length) still see the sine itself.
const FIRST_NEIGHBOUR: usize = 2;

/// y(t) = a cos ωt + b sin ωt + offset + trend (t − t̄).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// Coefficient a of cos ωt.
    pub cos: f64,
    /// Coefficient b of sin ωt.
    pub sin: f64,
    /// Constant part.
    pub offset: f64,
    /// Standard uncertainty of `cos` and of `sin`, from the noise near ω.
    pub std: f64,
    /// Degrees of freedom behind `std`.
    pub freedom: f64,
    /// Readings used.
    pub readings: usize,
}

/// Fits a sine of `hz` to the readings that are not NaN.
///
/// The noise of the coefficients is not taken from the scatter of single readings, which is right only
/// for white noise: the residual is projected on sines of up to 24 neighbouring frequencies, and the
/// variance of those projections is the variance of `cos` and `sin`. Records shorter than a few
/// cycles have no neighbours; there the scatter has to do.
pub fn fit(time_s: &[f64], values: &[f64], hz: f64) -> Result<Sine, Error> {
    let rows: Vec<usize> =
        (0..values.len()).filter(|&i| values[i].is_finite() && time_s[i].is_finite()).collect();
    let n = rows.len();
    if n < 5 {
        return Err(Error::TooFew { found: n, unknowns: 5 });
    }
    let omega = std::f64::consts::TAU * hz;
    let mean = rows.iter().map(|&i| time_s[i]).sum::<f64>() / n as f64;
    let (first, last) = (time_s[rows[0]], time_s[rows[n - 1]]);
    let length = (last - first).abs() * n as f64 / (n - 1) as f64;
    let phases: Vec<(f64, f64)> = rows.iter().map(|&i| (omega * time_s[i]).sin_cos()).collect();
    let design = Mat::from_fn(n, 4, |row, column| match column {
        0 => phases[row].1,
        1 => phases[row].0,
        2 => 1.0,
        _ => (time_s[rows[row]] - mean) / length,
    });
    let svd = Svd::of(design.as_ref(), 1e-10)?;
    if svd.rank() < 4 {
        return Err(Error::TooFew { found: svd.rank(), unknowns: 4 });
    }
    let y: Vec<f64> = rows.iter().map(|&i| values[i]).collect();
    let x = svd.solve(&y);
    let residual: Vec<f64> =
        (0..n).map(|i| y[i] - (0..4).map(|j| design[(i, j)] * x[j]).sum::<f64>()).collect();

    let cycles = hz * length;
    let lower = (FIRST_NEIGHBOUR..=NEIGHBOURS).filter(|&k| (k as f64) < cycles - 1.0);
    let nyquist = 0.5 * n as f64;
    let upper = (FIRST_NEIGHBOUR..=NEIGHBOURS).filter(|&k| cycles + (k as f64) < nyquist - 1.0);
    let turns: Vec<f64> = lower.map(|k| -(k as f64)).chain(upper.map(|k| k as f64)).collect();
    let (variance, freedom) = if turns.len() >= 6 {
        let power: f64 = turns
            .iter()
            .map(|turn| {
                let frequency = omega + std::f64::consts::TAU * turn / length;
                let (mut c, mut s) = (0.0, 0.0);
                for (row, r) in rows.iter().zip(&residual) {
                    let (sin, cos) = (frequency * time_s[*row]).sin_cos();
                    c += r * cos;
                    s += r * sin;
                }
                (c * c + s * s) * 2.0 / (n as f64).powi(2)
            })
            .sum();
        (power / turns.len() as f64, 2.0 * turns.len() as f64)
    } else {
        let covariance = svd.covariance();
        let scatter = residual.iter().map(|r| r * r).sum::<f64>() / (n as f64 - 4.0);
        (scatter * 0.5 * (covariance[(0, 0)] + covariance[(1, 1)]), n as f64 - 4.0)
    };
    Ok(Sine { cos: x[0], sin: x[1], offset: x[2], std: variance.sqrt(), freedom, readings: n })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_sine_with_gaps_and_uneven_times() {
        let time: Vec<f64> = (0..500).map(|i| i as f64 * 0.1 + 0.03 * (i as f64).sin()).collect();
        let values: Vec<f64> = time
            .iter()
            .enumerate()
            .map(|(i, t)| {
                let phase = std::f64::consts::TAU * 0.3 * t;
                if i % 17 == 3 { f64::NAN } else { 3.0 * phase.cos() - 4.0 * phase.sin() + 7.0 + 0.01 * t }
            })
            .collect();
        let sine = fit(&time, &values, 0.3).expect("a fit");
        assert!((sine.cos - 3.0).abs() < 1e-11 && (sine.sin + 4.0).abs() < 1e-11);
        assert!(sine.std < 1e-11);
    }

    #[test]
    fn less_than_a_cycle_is_refused_only_when_it_says_nothing() {
        let time: Vec<f64> = (0..50).map(f64::from).collect();
        assert!(fit(&time, &vec![1.0; 50], 0.0).is_err(), "no frequency, no sine");
    }
}
