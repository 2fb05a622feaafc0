//! Linear least squares: dense, correlated, in one pass over rows without end, and what is read off a fit.

pub mod correlated;
mod dot;
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

pub use dot::dot;
pub use least_squares::{LinearFit, fit};
