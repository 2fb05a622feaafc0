//! Steps of any damping, from one decomposition.

use faer::Mat;

use super::descent::Linear;
use crate::positive::eigen;
use crate::{Error, Svd};

/// Of products: directions of scaled columns with less than this share of their squared length are rounding.
const ROUNDING: f64 = 1e-12;

/// min |r − A δ| along directions V that do not mix: A D⁻¹ = U diag(σ) Vᵀ, D the columns' lengths.
#[derive(Clone, Debug)]
pub struct Directions<T> {
    /// What they were made of: A, or its decomposition.
    pub of: T,
    lengths: Vec<f64>,
    /// V, of the directions that show.
    directions: Mat<f64>,
    /// σ².
    squares: Vec<f64>,
    /// σ Uᵀ r.
    along: Vec<f64>,
}

impl Directions<Svd> {
    /// Of a matrix that was decomposed, and a residual.
    pub fn of_svd(svd: Svd, residual: &[f64]) -> Self {
        Self {
            lengths: svd.lengths().to_vec(),
            directions: svd.directions().to_owned(),
            squares: svd.sigma()[..svd.rank()].iter().map(|sigma| sigma * sigma).collect(),
            along: svd.projections(residual).zip(svd.sigma()).map(|(along, sigma)| along * sigma).collect(),
            of: svd,
        }
    }
}

impl Directions<Mat<f64>> {
    /// Of a matrix of many rows and a residual, by their products: faster where there are many more rows than
    /// unknowns, and blind to directions that show less than a millionth of what the columns do.
    ///
    /// Errors: [`Error::Decomposition`] for what is not finite.
    pub fn of_products(matrix: Mat<f64>, residual: &[f64]) -> Result<Self, Error> {
        let count = matrix.ncols();
        let lengths: Vec<f64> = (0..count)
            .map(|j| match matrix.col(j).norm_l2() {
                length if length > 0.0 && length.is_finite() => length,
                _ => f64::INFINITY,
            })
            .collect();
        let products = crate::gram(matrix.as_ref());
        let products = Mat::from_fn(count, count, |i, j| products[(i, j)] / lengths[i] / lengths[j]);
        let right = Mat::from_fn(count, 1, |j, _| crate::dot(matrix.col_as_slice(j), residual) / lengths[j]);
        let (values, vectors) = eigen(products.as_ref())?;
        let shown: Vec<usize> = (0..count).filter(|k| values[*k] > ROUNDING).collect();
        let directions = Mat::from_fn(count, shown.len(), |j, k| vectors[(j, shown[k])]);
        let along = directions.transpose() * right;
        Ok(Self {
            of: matrix,
            lengths,
            directions,
            squares: shown.iter().map(|k| values[*k]).collect(),
            along: (0..shown.len()).map(|k| along[(k, 0)]).collect(),
        })
    }
}

impl<T> Linear for Directions<T> {
    /// δ = D⁻¹ V (σ² + λ)⁻¹ σ Uᵀ r: undamped the shortest step of least squares in units of 1/D.
    fn step(&self, damping: f64) -> Vec<f64> {
        let mut step = vec![0.0; self.lengths.len()];
        for (k, (along, square)) in self.along.iter().zip(&self.squares).enumerate() {
            let part = along / (square + damping);
            for (step, direction) in step.iter_mut().zip(self.directions.col_as_slice(k)) {
                *step += part * direction;
            }
        }
        step.iter_mut().zip(&self.lengths).for_each(|(step, length)| *step /= length);
        step
    }

    /// ‖A δ‖, in standard deviations.
    fn shift(&self, damping: f64) -> f64 {
        let moved = |(along, square): (&f64, &f64)| square * (along / (square + damping)).powi(2);
        self.along.iter().zip(&self.squares).map(moved).sum::<f64>().sqrt()
    }

    fn rank(&self) -> usize {
        self.squares.len()
    }
}
