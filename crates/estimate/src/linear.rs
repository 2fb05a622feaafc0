//! Linear least squares of independent readings, and products of columns.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};

use crate::positive::Positive;
use crate::{Error, Svd};

/// Rows of which products are gathered at a time.
const ROWS: usize = 1024;

/// AᵀA.
pub fn gram(a: MatRef<'_, f64>) -> Mat<f64> {
    let mut gram = Mat::zeros(a.ncols(), a.ncols());
    add_lower(&mut gram, a);
    mirrored(gram)
}

/// Adds AᵀA of further rows, given column after column, to the lower triangle of `sum`; [`mirrored`] completes it.
pub fn add_gram(sum: &mut Mat<f64>, columns: &[f64]) {
    let count = sum.ncols();
    if let Some(rows) = columns.len().checked_div(count) {
        add_lower(sum, MatRef::from_column_major_slice(columns, rows, count));
    }
}

/// AᵀA of the columns of A, by blocks of rows.
pub fn gram_of<C: AsRef<[f64]>>(columns: &[C]) -> Mat<f64> {
    let (rows, count) = (columns.first().map_or(0, |column| column.as_ref().len()), columns.len());
    let mut gram = Mat::zeros(count, count);
    let mut part = Mat::zeros(ROWS.min(rows), count);
    for from in (0..rows).step_by(ROWS) {
        let some = ROWS.min(rows - from);
        for (number, column) in columns.iter().enumerate() {
            part.col_as_slice_mut(number)[..some].copy_from_slice(&column.as_ref()[from..from + some]);
        }
        add_lower(&mut gram, part.subrows(0, some));
    }
    mirrored(gram)
}

fn add_lower(gram: &mut Mat<f64>, a: MatRef<'_, f64>) {
    let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    matmul(gram.as_mut(), lower, Accum::Add, a.transpose(), whole, a, whole, 1.0, Par::Seq);
}

/// Completes a symmetric matrix from its lower triangle.
pub fn mirrored(mut gram: Mat<f64>) -> Mat<f64> {
    for j in 0..gram.ncols() {
        (0..j).for_each(|i| gram[(i, j)] = gram[(j, i)]);
    }
    gram
}

/// Σ a_i b_i, in eight sums, which need not wait for one another.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 8;
    let mut sums = [0.0; SUMS];
    let count = a.len().min(b.len());
    let (a, b) = (a[..count].chunks_exact(SUMS), b[..count].chunks_exact(SUMS));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        sums.iter_mut().zip(a).zip(b).for_each(|((sum, a), b)| *sum += a * b);
    }
    sums.iter().sum::<f64>() + rest
}

/// Singular values below this share of the largest count as zero, for columns of unit length.
const RANK_TOLERANCE: f64 = 1e-15;
/// Products are good up to this variance inflation factor: the covariance has ten digits, β all.
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

/// Fits y ≈ X β, each row divided by its standard deviation where these are given: by products where the columns are
/// well apart, else by the singular value decomposition. The solution is refined once by its residuals.
pub fn fit(design: MatRef<'_, f64>, y: &[f64], std: Option<&[f64]>) -> Result<LinearFit, Error> {
    let (rows, unknowns) = (design.nrows(), design.ncols());
    if rows < unknowns {
        return Err(Error::TooFew { found: rows, unknowns });
    }
    let weight = |row: usize| std.map_or(1.0, |std| 1.0 / std[row]);
    let weighted = Mat::from_fn(rows, unknowns, |i, j| design[(i, j)] * weight(i));
    let products = weighted.transpose() * &weighted;
    // The diagonal of (AᵀA)⁻¹ AᵀA has the variance inflation factors 1/(1 − R²) of the columns.
    let apart =
        |inverse: &Mat<f64>| (0..unknowns).all(|j| inverse[(j, j)] * products[(j, j)] <= MOST_INFLATION);
    let decomposed = match Positive::of(&products) {
        Ok(positive) if apart(&positive.inverse) => Decomposed::Products(positive.inverse),
        _ => Decomposed::Singular(Svd::of(weighted.as_ref(), RANK_TOLERANCE)?),
    };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_and_singular_values_agree() {
        // The third column is nearly the sum of the others: inflation some 5e4, so products do.
        let third = |i: usize| 1.0 + 0.1 * i as f64 + if i.is_multiple_of(7) { 0.05 } else { 0.0 };
        let design = Mat::from_fn(60, 3, |i, j| [1.0, 0.1 * i as f64, third(i)][j]);
        let y: Vec<f64> = (0..60).map(|i| (i * i % 11) as f64).collect();
        let products = fit(design.as_ref(), &y, None).expect("a fit");
        let svd = Svd::of(design.as_ref(), RANK_TOLERANCE).expect("finite");
        let covariance = svd.covariance();
        for (k, value) in svd.solve(&y).into_iter().enumerate() {
            assert!((products.coefficients[k] / value - 1.0).abs() < 1e-9, "{k}");
            assert!((products.covariance[(k, k)] / covariance[(k, k)] - 1.0).abs() < 1e-9, "{k}");
        }
        // A column twice is for singular values.
        let twice = Mat::from_fn(60, 2, |i, _| i as f64);
        assert_eq!(fit(twice.as_ref(), &y, None).expect("a fit").rank, 1);
        assert!(matches!(fit(design.as_ref().subrows(0, 2), &y[..2], None), Err(Error::TooFew { .. })));
    }
}
