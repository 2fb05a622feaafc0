//! Which of many groups of columns explain a residual, from nothing but the products of all columns.
//!
//! Residual and columns are whitened. The products are gathered block by block of rows; projection, gains,
//! their distribution by chance and prediction of rows left out follow from them.

mod chance;
mod projection;

pub use chance::{Chance, Search};
pub use projection::{Column, Gain, Screen, left_out};
