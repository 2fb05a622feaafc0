use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Findings, Matrix3x3, PerAxis, Quantity};

/// Noise of the reference: with R = B + e instead of the field B, least squares gives (1 − M⁻¹N) η for η,
/// where M = Σ S_RR/P_d and N = Σ P_e/P_d over the frequencies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ReferenceNoise {
    /// How it is known.
    pub known_from: ReferenceNoiseSource,
    /// Each element of the matrix by its place, `xy` from the reference's x to the test's y.
    pub elements: IndexMap<String, PulledElement>,
    /// Share of the difference's power that is the reference's, along each axis of the reference; absent
    /// where its noise is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<PerAxis<Quantity>>,
    /// Noise of the test instrument alone, that of the reference taken off; absent where that is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test: Option<PerAxis<OwnNoise>>,
    /// What the spectra of two instruments say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub in_spectrum: Option<InSpectrum>,
    /// Whose noise the difference is, and why.
    pub ascribed: String,
    /// What looks wrong, or is worth knowing, in words.
    #[serde(flatten)]
    pub findings: Findings,
}

/// From where the noise of the reference is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ReferenceNoiseSource {
    /// It is not; how far it may pull is bounded.
    #[default]
    Unknown,
    /// Declared in `conditions.reference_noise`.
    Declared,
    /// From a third instrument in the same field.
    ThirdInstrument,
    /// From the spectra of the two instruments.
    Spectrum,
}

/// One element of the matrix with what noise of the reference does to it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct PulledElement {
    /// As weighted, pulled toward zero.
    pub pulled: f64,
    /// Its standard uncertainty, the pull not in it.
    pub pulled_std: f64,
    /// Corrected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected: Option<Quantity>,
    /// Pulled less corrected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pull: Option<f64>,
    /// The largest pull, to either side, if all of the difference were noise of the reference.
    pub largest_pull: f64,
    /// The same over `pulled_std`.
    pub largest_pull_over_std: f64,
}

/// Noise of one axis of one instrument, P(f) = A f^-α + white.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct OwnNoise {
    /// White noise of one reading, nT; 0 where it is not significant (1 %).
    pub white_rms_nt: Quantity,
    /// Its 95 % interval; from 0 to a bound of 97.5 % where it is not significant, nT.
    pub white_interval_nt: [f64; 2],
    /// √A, density of the flicker noise at 1 Hz, nT/√Hz; 0 where it is not significant (1 %).
    pub density_at_1hz_nt_per_sqrt_hz: Quantity,
    /// Its 95 % interval; from 0 to a bound of 97.5 %, for α = 1, where it is not significant, nT/√Hz.
    pub density_interval_nt_per_sqrt_hz: [f64; 2],
    /// α; held at 1 where flicker is not significant.
    pub flicker_exponent: Quantity,
}

/// Noise of the reference in the spectra of two instruments: where the field is weak the coefficients fall,
/// as ⟨R* v⟩ = −P_e; everywhere else they give η.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct InSpectrum {
    /// Share of the difference's power that is the reference's, along each of its axes.
    pub share: PerAxis<Quantity>,
    /// Probability of shares so far above zero without noise of the reference.
    pub p: f64,
    /// Probability of bands that agree worse with one matrix and one share for each axis.
    pub consistency_p: f64,
    /// Whether the matrix was corrected by it: noise is significant (1 %), the bands agree (1 %), and no
    /// share is above one.
    pub used: bool,
}

/// Three instruments in one field: the noise of each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ThreeCornered {
    /// Of the reference.
    pub reference: PerAxis<OwnNoise>,
    /// Of the test instrument.
    pub test: PerAxis<OwnNoise>,
    /// Of the third.
    pub third: PerAxis<OwnNoise>,
    /// C = R ζ: column j holds what the reference's x, y, z give to the third's axis j.
    pub third_matrix: Matrix3x3,
    /// Probability of spectra that agree worse with independent noises of that form.
    pub goodness_p: f64,
}
