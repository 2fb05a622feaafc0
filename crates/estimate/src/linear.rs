//! Linear least squares: dense, correlated, in one pass over rows without end, and what is read off a fit.

pub mod correlated;
pub mod exact;
pub mod hac;
pub mod influence;
mod least_squares;
pub mod mixture;
pub mod positive;
pub mod svd;
pub mod triangle;
pub mod tsqr;
pub mod wander;

pub use least_squares::{LinearFit, fit};

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
