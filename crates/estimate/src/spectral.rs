//! Spectra of even series, noise models fitted to them, and regression under noise of a known spectrum.

pub mod allan;
pub(crate) mod bins;
pub mod cosine;
pub mod cross_spectrum;
pub mod haar;
pub mod periodogram;
pub(crate) mod plans;
mod regression;
pub mod sine;
pub mod sources;
pub mod spectrum;
pub mod whittle;

pub use regression::{SpectralFit, Transform, Transformer, WeightedFit, Weights, agreement_p, regress};
