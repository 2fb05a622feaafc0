//! What is given: spectra of series, what each source gives to them, and what is known besides.

use crate::cross_spectrum::CrossSpectra;

/// Series that are sums of independent sources.
pub struct Mixture<'a> {
    /// Their spectral matrices, of the whole series without a taper.
    pub spectra: &'a CrossSpectra,
    /// From one sample to the next, s.
    pub step_s: f64,
    /// What each source gives to each series.
    pub columns: Vec<Vec<f64>>,
    /// What is in them besides and is known.
    pub known: Vec<KnownNoise>,
}

/// Sources of known noise, up to one factor with an uncertainty.
pub struct KnownNoise {
    /// What each gives to each series.
    pub columns: Vec<Vec<f64>>,
    /// Density of each at the frequencies of the spectra (unit²/Hz).
    pub densities: Vec<Vec<f64>>,
    /// Relative standard uncertainty of the densities, the same factor in all.
    pub relative_std: f64,
}
