//! Linear least squares by the singular value decomposition.

use faer::{Mat, MatRef};

use crate::{Error, Svd};

/// Singular values below this share of the largest count as zero, for columns of unit length.
const RANK_TOLERANCE: f64 = 1e-15;

/// A linear fit y ≈ X β.
#[derive(Clone, Debug)]
pub struct LinearFit {
    /// β, minimum-norm where the rank is short.
    pub coefficients: Vec<f64>,
    /// (Xᵀ W X)⁻¹: the covariance of β for rows of the given standard deviations, or of one.
    pub covariance: Mat<f64>,
    /// y − X β.
    pub residuals: Vec<f64>,
    /// The same, each over its standard deviation.
    pub standardised: Vec<f64>,
    /// Σ of the squared residuals, each over its standard deviation.
    pub sum_of_squares: f64,
    /// Rows less rank.
    pub freedom: f64,
    /// Rank of X.
    pub rank: usize,
}

/// Fits y ≈ X β, each row divided by its standard deviation where these are given; one refinement of the solution
/// by its residuals.
pub fn fit(design: MatRef<'_, f64>, y: &[f64], std: Option<&[f64]>) -> Result<LinearFit, Error> {
    let (rows, unknowns) = (design.nrows(), design.ncols());
    if rows < unknowns {
        return Err(Error::TooFew { found: rows, unknowns });
    }
    let weight = |row: usize| std.map_or(1.0, |std| 1.0 / std[row]);
    let weighted = Mat::from_fn(rows, unknowns, |i, j| design[(i, j)] * weight(i));
    let svd = Svd::of(weighted.as_ref(), RANK_TOLERANCE)?;
    let residuals = |coefficients: &[f64]| -> Vec<f64> {
        (0..rows)
            .map(|i| y[i] - (0..unknowns).map(|j| design[(i, j)] * coefficients[j]).sum::<f64>())
            .collect()
    };
    let solve =
        |right: &[f64]| svd.solve(&right.iter().enumerate().map(|(i, r)| r * weight(i)).collect::<Vec<_>>());
    let mut coefficients = solve(y);
    let correction = solve(&residuals(&coefficients));
    coefficients.iter_mut().zip(correction).for_each(|(value, step)| *value += step);
    let residuals = residuals(&coefficients);
    let standardised: Vec<f64> = residuals.iter().enumerate().map(|(i, r)| r * weight(i)).collect();
    let sum_of_squares = standardised.iter().map(|r| r * r).sum();
    Ok(LinearFit {
        coefficients,
        covariance: svd.covariance(),
        residuals,
        standardised,
        sum_of_squares,
        freedom: (rows - svd.rank()) as f64,
        rank: svd.rank(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nasa_line_of_101_points() {
        // 0 to 50 000 nT in steps of 500 at 0.1 V: (C⁻¹)₀₀ = 0.03902, (C⁻¹)₁₁ = 0.0011648.
        let design = Mat::from_fn(101, 2, |i, j| if j == 0 { 1.0 } else { 0.1 * i as f64 });
        let y: Vec<f64> = (0..101).map(|i| 7.0 + 500.0 * i as f64).collect();
        let line = fit(design.as_ref(), &y, None).expect("a fit");
        assert!((line.covariance[(0, 0)] - 0.03902).abs() < 5e-6);
        assert!((line.covariance[(1, 1)] - 0.001_164_8).abs() < 5e-8);
        assert!((line.coefficients[1] - 5000.0).abs() < 1e-9 && (line.coefficients[0] - 7.0).abs() < 1e-8);
        // Two of the rows, told to be ten times less sure, weigh a hundredth.
        let std: Vec<f64> = (0..101).map(|i| if i < 2 { 10.0 } else { 1.0 }).collect();
        let weighted = fit(design.as_ref(), &y, Some(&std)).expect("a fit");
        assert!(weighted.covariance[(0, 0)] > line.covariance[(0, 0)]);
        assert!(matches!(fit(design.as_ref().subrows(0, 1), &y[..1], None), Err(Error::TooFew { .. })));
    }
}
