//! Least squares from products: coefficients, their covariance, and what is left of each row.

use estimate::positive::Positive;
use faer::Mat;

/// What others leave of a column is at least this share of it, or it follows from them.
const INDEPENDENT: f64 = 1e-9;

/// A regression on those of some columns that are independent of each other.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The columns that have a coefficient, and it.
    pub columns: Vec<usize>,
    /// Their coefficients.
    pub coefficients: Vec<f64>,
    /// (Xᵀ C⁻¹ X)⁻¹.
    pub inverse: Mat<f64>,
    /// The sum of squares that is left.
    pub left: f64,
}

impl Fit {
    /// Of column `y` on others, from their products.
    pub fn of(gram: &Mat<f64>, y: usize, columns: &[usize]) -> Self {
        let kept = independent(gram, columns);
        let count = kept.len();
        let own = Mat::from_fn(count, count, |i, j| gram[(kept[i], kept[j])]);
        let inverse = Positive::of(&own).map_or_else(|_| Mat::zeros(count, count), |found| found.inverse);
        let coefficients: Vec<f64> =
            (0..count).map(|i| (0..count).map(|j| inverse[(i, j)] * gram[(kept[j], y)]).sum()).collect();
        let explained: f64 =
            coefficients.iter().zip(&kept).map(|(value, column)| value * gram[(*column, y)]).sum();
        Self { left: (gram[(y, y)] - explained).max(0.0), columns: kept, coefficients, inverse }
    }

    /// The coefficient of a column; zero where it follows from others.
    pub fn coefficient(&self, column: usize) -> f64 {
        self.place(column).map_or(0.0, |place| self.coefficients[place])
    }

    /// Where a column's coefficient is.
    pub fn place(&self, column: usize) -> Option<usize> {
        self.columns.iter().position(|known| *known == column)
    }

    /// What is left of a series.
    pub fn rest(&self, columns: &[Vec<f64>], y: &[f64]) -> Vec<f64> {
        let mut rest = y.to_vec();
        for (column, coefficient) in self.columns.iter().zip(&self.coefficients) {
            rest.iter_mut().zip(&columns[*column]).for_each(|(rest, value)| *rest -= coefficient * value);
        }
        rest
    }
}

/// The columns that do not follow from those before them.
fn independent(gram: &Mat<f64>, columns: &[usize]) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        // The column along the orthogonal directions of those that are kept.
        let mut own = Vec::with_capacity(kept.len());
        for (row, other) in rows.iter().zip(&kept) {
            let known: f64 = row.iter().zip(&own).map(|(a, b): (&f64, &f64)| a * b).sum();
            own.push((gram[(*other, *column)] - known) / row[own.len()]);
        }
        let pivot = gram[(*column, *column)] - own.iter().map(|value| value * value).sum::<f64>();
        if pivot > INDEPENDENT * gram[(*column, *column)] {
            own.push(pivot.sqrt());
            rows.push(own);
            kept.push(*column);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_that_follows_from_others_has_no_coefficient() {
        // Columns (1, 1, 1), (1, 2, 3), (3, 4, 5) = 2 × first + second, and y = (2, 4, 6).
        let columns = [[1.0, 1.0, 1.0], [1.0, 2.0, 3.0], [3.0, 4.0, 5.0], [2.0, 4.0, 6.0]];
        let gram = Mat::from_fn(4, 4, |i, j| (0..3).map(|row| columns[i][row] * columns[j][row]).sum());
        let fit = Fit::of(&gram, 3, &[0, 1, 2]);
        assert_eq!(fit.columns, [0, 1]);
        assert!(fit.coefficient(0).abs() < 1e-9 && (fit.coefficient(1) - 2.0).abs() < 1e-9);
        assert!(fit.coefficient(2) == 0.0 && fit.left < 1e-9);
    }
}
