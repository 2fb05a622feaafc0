//! Linear least squares: by products where the columns are well apart, else by the singular value
//! decomposition.

use faer::{Mat, MatRef};

use crate::positive::Positive;
use crate::{Error, Svd};

/// Singular values below this share of the largest count as zero, for columns of unit length.
const RANK_TOLERANCE: f64 = 1e-15;
/// Products are good up to this variance inflation factor: the covariance then has ten digits, and the
/// refined solution all.
const MOST_INFLATION: f64 = 1e6;

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

/// Fits y ≈ X β, each row divided by its standard deviation where these are given; one refinement of the
/// solution by its residuals.
pub fn fit(design: MatRef<'_, f64>, y: &[f64], std: Option<&[f64]>) -> Result<LinearFit, Error> {
    let (rows, unknowns) = (design.nrows(), design.ncols());
    if rows < unknowns {
        return Err(Error::TooFew { found: rows, unknowns });
    }
    let weight = |row: usize| std.map_or(1.0, |std| 1.0 / std[row]);
    let weighted = Mat::from_fn(rows, unknowns, |i, j| design[(i, j)] * weight(i));
    let decomposed = Decomposed::of(&weighted)?;
    let residuals = |coefficients: &[f64]| -> Vec<f64> {
        let mut left = y.to_vec();
        for (j, coefficient) in coefficients.iter().enumerate() {
            left.iter_mut().zip(design.col(j).iter()).for_each(|(left, x)| *left -= x * coefficient);
        }
        left
    };
    let solve = |right: &[f64]| {
        let right: Vec<f64> = right.iter().enumerate().map(|(i, r)| r * weight(i)).collect();
        let inverse = match &decomposed {
            Decomposed::Products(inverse) => inverse,
            Decomposed::Singular(svd) => return svd.solve(&right),
        };
        let times = |matrix: &Mat<f64>, right: &[f64]| -> Vec<f64> {
            let of = |j: usize| matrix.col_as_slice(j).iter().zip(right).map(|(a, b)| a * b).sum();
            (0..unknowns).map(of).collect()
        };
        times(inverse, &times(&weighted, &right))
    };
    let mut coefficients = solve(y);
    let correction = solve(&residuals(&coefficients));
    coefficients.iter_mut().zip(correction).for_each(|(value, step)| *value += step);
    let residuals = residuals(&coefficients);
    let standardised: Vec<f64> = residuals.iter().enumerate().map(|(i, r)| r * weight(i)).collect();
    let sum_of_squares = standardised.iter().map(|r| r * r).sum();
    let (rank, covariance) = match decomposed {
        Decomposed::Products(inverse) => (unknowns, inverse),
        Decomposed::Singular(svd) => (svd.rank(), svd.covariance()),
    };
    Ok(LinearFit {
        coefficients,
        covariance,
        residuals,
        standardised,
        sum_of_squares,
        freedom: (rows - rank) as f64,
        rank,
    })
}

/// What solves a linear problem with a matrix A.
enum Decomposed {
    /// (AᵀA)⁻¹.
    Products(Mat<f64>),
    Singular(Svd),
}

impl Decomposed {
    fn of(matrix: &Mat<f64>) -> Result<Self, Error> {
        let products = matrix.transpose() * matrix;
        // An element of the diagonal of (AᵀA)⁻¹ AᵀA is the variance inflation factor 1/(1 − R²) of a column
        // on the others.
        let apart = |inverse: &Mat<f64>| {
            (0..matrix.ncols()).all(|j| inverse[(j, j)] * products[(j, j)] <= MOST_INFLATION)
        };
        match Positive::of(&products) {
            Ok(positive) if apart(&positive.inverse) => Ok(Self::Products(positive.inverse)),
            _ => Ok(Self::Singular(Svd::of(matrix.as_ref(), RANK_TOLERANCE)?)),
        }
    }
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

    #[test]
    fn products_and_singular_values_agree() {
        // The third column is nearly the sum of the others: inflation some 5e4, so products do.
        let third = |i: usize| 1.0 + 0.1 * i as f64 + if i.is_multiple_of(7) { 0.05 } else { 0.0 };
        let design = Mat::from_fn(60, 3, |i, j| [1.0, 0.1 * i as f64, third(i)][j]);
        let y: Vec<f64> = (0..60).map(|i| (i * i % 11) as f64).collect();
        let products = fit(design.as_ref(), &y, None).expect("a fit");
        assert!(matches!(Decomposed::of(&design), Ok(Decomposed::Products(..))));
        let svd = Svd::of(design.as_ref(), RANK_TOLERANCE).expect("finite");
        let covariance = svd.covariance();
        for (k, value) in svd.solve(&y).into_iter().enumerate() {
            assert!((products.coefficients[k] / value - 1.0).abs() < 1e-9, "{k}");
            assert!((products.covariance[(k, k)] / covariance[(k, k)] - 1.0).abs() < 1e-9, "{k}");
        }
        // A column twice is for singular values.
        let twice = Mat::from_fn(60, 2, |i, _| i as f64);
        assert_eq!(fit(twice.as_ref(), &y, None).expect("a fit").rank, 1);
    }
}
