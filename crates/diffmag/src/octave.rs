//! One octave of a pair: sums of products, and what they say alone.

use estimate::positive::Positive;
use faer::Mat;

/// The reference's x, y, z, the time, and what is to be explained.
pub const COLUMNS: usize = 5;
pub const UNKNOWNS: usize = COLUMNS - 1;

/// Sums over the coefficients, or the differences, of one octave.
pub struct Octave {
    pub count: f64,
    /// Σ z zᵀ of the columns z.
    pub products: [[f64; COLUMNS]; COLUMNS],
}

impl Octave {
    /// Σ of the squares that coefficients leave.
    pub fn squares(&self, coefficients: &[f64]) -> f64 {
        let rest = |i: usize| if i == UNKNOWNS { 1.0 } else { -coefficients[i] };
        let mut sum = 0.0;
        for i in 0..COLUMNS {
            for j in 0..COLUMNS {
                sum += rest(i) * rest(j) * self.products[i][j];
            }
        }
        sum
    }

    /// Least squares of the reference's axes alone: η, the inverse of their products, and the squares that are left.
    /// None where the field is not seen.
    pub fn alone(&self) -> Option<([f64; 3], Mat<f64>, f64)> {
        let inverse = Positive::of(&Mat::from_fn(3, 3, |i, j| self.products[i][j])).ok()?.inverse;
        let along = |i: usize| (0..3).map(|j| inverse[(i, j)] * self.products[j][UNKNOWNS]).sum();
        let eta: [f64; 3] = std::array::from_fn(along);
        let [x, y, z] = eta;
        Some((eta, inverse, self.squares(&[x, y, z, 0.0])))
    }
}
