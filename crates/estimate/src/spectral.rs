//! Spectra of even series, noise models fitted to them, and regression under noise of a known spectrum.

pub mod allan;
pub mod cosine;
pub mod cross_spectrum;
pub mod haar;
pub mod periodogram;
mod regression;
pub mod sine;
pub mod sources;
pub mod spectrum;
pub mod whittle;

pub use regression::{
    SpectralFit, Transform, WeightedFit, agreement_p, regress, regress_transforms, weighted,
};
