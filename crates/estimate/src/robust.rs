//! Fits and judgements that single bad readings do not spoil.

pub mod normality;
mod reweighted;

pub use reweighted::{RobustFit, bisquare, scale_of, solve_robust};
