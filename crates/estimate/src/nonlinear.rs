//! Nonlinear fits: least squares, likelihoods, and searches along a line.

pub mod gauss_newton;
pub mod line_search;
pub(crate) mod scoring;
