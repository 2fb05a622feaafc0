use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, PerAxis, Quantity};

/// What the nulling leaves, by coilcal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct NullingCalibration {
    /// Each condition of the site by its name.
    pub sites: IndexMap<String, SiteSpectra>,
    /// The condition with the smallest rms of a measurement of the longest length in the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quietest: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Spectra of one condition of the site.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SiteSpectra {
    /// The series, slowest first.
    pub series: Vec<SeriesOfSpectrum>,
    /// Bands between the series that none of them shows, Hz.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gaps_hz: Vec<[f64; 2]>,
    /// One merged spectrum for each sensor.
    pub spectra: PerAxis<MergedSpectrum>,
    /// Expected rms error of a measurement, by its length.
    pub expected: Vec<ExpectedRms>,
    /// Spectral lines.
    pub lines: Vec<SpectralLine>,
}

/// How one series entered the spectrum.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SeriesOfSpectrum {
    /// The recording.
    pub recording: String,
    /// Samples per second.
    pub rate_hz: f64,
    /// How far its times are from even ones, s, where they are not: it was interpolated, which lowers its
    /// white noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uneven_s: Option<f64>,
    /// `hann`.
    pub window: String,
    /// Samples of a segment.
    pub segment_samples: usize,
    /// Share by which segments overlap.
    pub overlap: f64,
    /// Segments averaged.
    pub segments: usize,
    /// Equivalent degrees of freedom of one estimate.
    pub freedom: f64,
    /// Band for which it stands in the merged spectrum, Hz.
    pub band_hz: [f64; 2],
}

/// A merged spectrum, averaged over ten bins a decade.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct MergedSpectrum {
    /// Middle of each bin, Hz.
    pub frequency_hz: Vec<f64>,
    /// One-sided power density, nT²/Hz.
    pub density_nt2_per_hz: Vec<f64>,
    /// Lower end of the 95 % band.
    pub low_nt2_per_hz: Vec<f64>,
    /// Upper end of the 95 % band.
    pub high_nt2_per_hz: Vec<f64>,
}

/// Expected rms error of a measurement: √∫ P df from one over its length to the instrument's Nyquist
/// frequency (NASA).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ExpectedRms {
    /// Length of the measurement, s.
    pub length_s: f64,
    /// The band that was integrated: what was not recorded is not in it, Hz.
    pub band_hz: [f64; 2],
    /// By sensor, nT.
    pub rms_nt: PerAxis<Quantity>,
}

/// A spectral line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SpectralLine {
    /// The recording.
    pub recording: String,
    /// The sensor, `x`, `y` or `z`.
    pub sensor: String,
    /// Where it stands, Hz.
    pub frequency_hz: f64,
    /// Amplitude, nT.
    pub amplitude_nt: f64,
    /// What it is: mains or railway power, or an alias of it; absent where it has no name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}
