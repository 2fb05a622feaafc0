//! Least squares in one pass: a triangular factor that takes blocks of rows and other factors.

use faer::Mat;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::exact::Sum;
use crate::stats::sum_from;
use crate::triangle::Triangle;

/// What a column leaves of itself beside the others counts as nothing below this share of it.
const DEPENDENT: f64 = 1e-13;

/// Count, sums and the triangular factor U of p centred columns X°: UᵀU = X°ᵀX°.
///
/// The constant is not a column: with it first, Householder's first step takes the means off, which is done
/// here with sums that keep their rounding. So a mean of 50 000 takes no digits from residuals of 0.01. Two
/// sets of rows, A and B, have the factor of their two factors and the row √(n_A n_B/(n_A + n_B)) (mean_B −
/// mean_A) stacked.
///
/// Source: J. Demmel, L. Grigori, M. Hoemmen, J. Langou, Communication-optimal parallel and sequential QR and
/// LU factorizations, SIAM J. Sci. Comput. 34 (2012) A206–A239; T. F. Chan, G. H. Golub, R. J. LeVeque,
/// Algorithms for computing the sample variance, Am. Stat. 37 (1983) 242–247.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Tsqr {
    count: u64,
    sums: Vec<Sum>,
    factor: Triangle,
}

/// Some columns on others, with a constant.
#[derive(Clone, Debug)]
pub struct Regression {
    /// For each response the coefficients of the predictors.
    pub coefficients: Vec<Vec<f64>>,
    /// (X°ᵀX°)⁻¹ of the predictors.
    pub inverse: Mat<f64>,
    /// For each response the sum of its squared residuals.
    pub squares: Vec<f64>,
    /// Rows less predictors less one.
    pub freedom: f64,
}

impl Tsqr {
    /// No rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { count: 0, sums: vec![Sum::default(); columns], factor: Triangle::new(columns) }
    }

    /// Rows taken.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Whether the parts fit each other, after reading them from outside.
    pub fn is_whole(&self, columns: usize) -> bool {
        self.sums.len() == columns && self.factor.is_whole(columns)
    }

    /// Mean of a column.
    pub fn mean(&self, column: usize) -> f64 {
        self.sums[column].over(self.count as f64).value()
    }

    /// Takes a block of rows, column by column; one factorisation.
    ///
    /// Panics: unless there are as many columns as told, of one length.
    pub fn push(&mut self, columns: &[&[f64]]) {
        let rows = columns[0].len();
        assert!(columns.len() == self.sums.len() && columns.iter().all(|c| c.len() == rows));
        if rows == 0 {
            return;
        }
        let count = rows as f64;
        let sum = |column: &&[f64]| {
            let mut sum = Sum::of(sum_from(column, column[0]));
            sum.add_times(count, Sum::of(column[0]));
            sum
        };
        let sums: Vec<Sum> = columns.iter().map(sum).collect();
        let head = self.between(rows as u64, &sums);
        self.factor.take(1 + rows, |j, below| {
            let mean = sums[j].over(count).value();
            below[0] = head[j];
            below[1..].iter_mut().zip(columns[j]).for_each(|(to, from)| *to = from - mean);
        });
        self.add(rows as u64, &sums);
    }

    /// Takes what another factor has taken.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let head = self.between(other.count, &other.sums);
        self.factor.take(1 + other.sums.len(), |j, below| {
            below[0] = head[j];
            (0..=j).for_each(|i| below[1 + i] = other.factor.at(i, j));
        });
        self.add(other.count, &other.sums);
    }

    /// The row that stands for the distance of two means.
    fn between(&self, count: u64, sums: &[Sum]) -> Vec<f64> {
        if self.count == 0 {
            return vec![0.0; sums.len()];
        }
        let (here, there) = (self.count as f64, count as f64);
        let weight = (here * (there / (here + there))).sqrt();
        self.sums.iter().zip(sums).map(|(a, b)| weight * b.over(there).less(a.over(here))).collect()
    }

    fn add(&mut self, count: u64, sums: &[Sum]) {
        self.count += count;
        self.sums.iter_mut().zip(sums).for_each(|(to, from)| to.add_sum(*from));
    }

    /// Least squares of each response by the predictors and a constant: the factor of those columns alone, by
    /// which U_xx β = U_xy and Σ r² = |U_yy|².
    ///
    /// Errors: [`Error::TooFew`] without more rows than unknowns, [`Error::Decomposition`] where the
    /// predictors depend on each other.
    pub fn regress(&self, predictors: &[usize], responses: &[usize]) -> Result<Regression, Error> {
        let (width, known) = (self.sums.len(), predictors.len());
        if self.count <= known as u64 + 1 {
            return Err(Error::TooFew { found: self.count as usize, unknowns: known + 1 });
        }
        let chosen: Vec<usize> = predictors.iter().chain(responses).copied().collect();
        let columns = Mat::from_fn(width, chosen.len(), |i, j| self.factor.at(i, chosen[j]));
        let qr = columns.qr();
        let upper = qr.thin_R();
        for k in 0..known {
            let length = (0..=k).map(|i| upper[(i, k)].powi(2)).sum::<f64>().sqrt();
            if upper[(k, k)].abs() <= DEPENDENT * length || length == 0.0 {
                let reason = format!("column {k} does not vary, or follows from those before it");
                return Err(Error::Decomposition { rows: self.count as usize, columns: known, reason });
            }
        }
        let factor = upper.submatrix(0, 0, known, known);
        let mut root = Mat::identity(known, known);
        factor.solve_upper_triangular_in_place(root.as_mut());
        let mut solved = upper.submatrix(0, known, known, responses.len()).to_owned();
        factor.solve_upper_triangular_in_place(solved.as_mut());
        let left = |column: usize| (known..upper.nrows().min(column + 1)).map(move |i| upper[(i, column)]);
        Ok(Regression {
            coefficients: (0..responses.len()).map(|place| solved.col_as_slice(place).to_vec()).collect(),
            inverse: &root * root.transpose(),
            squares: (known..chosen.len()).map(|column| left(column).map(|u| u * u).sum()).collect(),
            freedom: self.count as f64 - known as f64 - 1.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_solved_is_told() {
        let mut factor = Tsqr::new(3);
        let (x, y) = ([1.0, 2.0, 3.0, 5.0], [2.0, 4.0, 6.0, 10.0]);
        factor.push(&[&x, &y, &x]);
        assert!(matches!(factor.regress(&[0, 1], &[2]), Err(Error::Decomposition { .. })));
        let line = factor.regress(&[0], &[1]).expect("a line");
        assert!((line.coefficients[0][0] - 2.0).abs() < 1e-14 && line.squares[0] < 1e-28);
        assert!(matches!(Tsqr::new(3).regress(&[0], &[1]), Err(Error::TooFew { .. })));
    }
}
