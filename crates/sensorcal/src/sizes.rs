//! A size of the noise for each recording: one is made on a quiet night, another by day beside traffic.

use estimate::{linear, stats};
use faer::Mat;

use crate::Error;
use crate::fit::Fit;
use crate::shape::Allowed;

/// Prior degrees of freedom of the common variance, towards which the variance of each recording is shrunk.
const COMMON: f64 = 4.0;
/// Rounds in which sizes and fit settle.
const ROUNDS: usize = 6;

/// The noise with each recording's size, and the degrees of freedom of these.
pub struct Sized {
    /// The covariances.
    pub allowed: Allowed,
    /// Of each covariance and recording.
    freedoms: Vec<Vec<f64>>,
    rows: Vec<usize>,
}

impl Sized {
    /// Of the readings of a fit, so many in each recording.
    ///
    /// σ² = (ν σ₀² + r'r)/(ν + n − p) for each recording, with the whitened residuals r, their degrees of freedom n − p (readings less
    /// the trace of their part of the projection on the design), σ₀² the geometric mean over the recordings and ν = 4.
    pub fn of(allowed: &Allowed, fit: &Fit, rows: Vec<usize>) -> Result<Self, Error> {
        let (mut freedoms, mut scales) = (Vec::new(), Vec::new());
        for whitening in &allowed.whitenings {
            let mut freedom = vec![fit.linear.freedom; rows.len()];
            let mut sizes = vec![1.0; rows.len()];
            for _ in 0..if rows.len() > 1 { ROUNDS } else { 0 } {
                let white = whitening.scaled(&sizes);
                let design = white.apply(fit.design.as_ref());
                let left = linear::fit(design.as_ref(), &white.apply_to(&fit.linear.residuals), None)?;
                let along = &design * &left.covariance;
                let mut from = 0;
                let mut own = Vec::new();
                for (rows, size) in rows.iter().zip(&sizes) {
                    let of = from..from + rows;
                    let squares: f64 = left.residuals[of.clone()].iter().map(|r| (r * size).powi(2)).sum();
                    let taken: f64 = of
                        .map(|i| (0..design.ncols()).map(|j| along[(i, j)] * design[(i, j)]).sum::<f64>())
                        .sum();
                    own.push((squares, (*rows as f64 - taken).max(0.0)));
                    from += rows;
                }
                let shared = |(squares, freedom): &(f64, f64)| freedom * (squares / freedom).ln();
                let known = own.iter().filter(|(squares, freedom)| *squares > 0.0 && *freedom >= 1.0);
                let count: f64 = known.clone().map(|(_, freedom)| freedom).sum();
                if count < 1.0 {
                    break;
                }
                let common = (known.map(shared).sum::<f64>() / count).exp();
                let size = |(squares, freedom): &(f64, f64)| {
                    ((COMMON * common + squares) / (COMMON + freedom)).sqrt()
                };
                sizes = own.iter().map(size).collect();
                freedom = own.iter().map(|(_, freedom)| COMMON + freedom).collect();
            }
            scales.push(sizes);
            freedoms.push(freedom);
        }
        Ok(Self { allowed: allowed.scaled(&scales), freedoms, rows })
    }

    /// The smallest of the effective degrees of freedom of some unknowns of a fit under this noise (Welch and Satterthwaite), and
    /// the factor from standard uncertainty to 95 % interval.
    pub fn freedom(&self, fit: &Fit, unknowns: &[usize]) -> Result<(f64, f64), Error> {
        let best = self.allowed.best(&fit.linear);
        let white = &self.allowed.whitenings[best];
        let design = white.apply(fit.design.as_ref());
        let none = vec![0.0; design.nrows()];
        let along: Mat<f64> = &design * &linear::fit(design.as_ref(), &none, None)?.covariance;
        let effective = |unknown: &usize| {
            let mut from = 0;
            let (mut sum, mut squares) = (0.0, 0.0);
            for (rows, freedom) in self.rows.iter().zip(&self.freedoms[best]) {
                let part: f64 = (from..from + rows).map(|i| along[(i, *unknown)].powi(2)).sum();
                sum += part;
                squares += part * part / freedom;
                from += rows;
            }
            sum * sum / squares
        };
        let freedom = unknowns.iter().map(effective).fold(fit.linear.freedom, f64::min);
        Ok((freedom, stats::coverage_factor(0.95, freedom)))
    }
}
