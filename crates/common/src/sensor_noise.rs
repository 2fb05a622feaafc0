use serde::{Deserialize, Serialize};

use crate::{Extra, Findings, MergedSpectrum, Noise, Quantity, SpectralLine};

/// Noise of a sensor in a shield: P(f) = A f^-α + white + lines.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SensorNoise {
    /// The series, slowest first.
    pub series: Vec<NoiseSeriesResult>,
    /// A, nT²/Hz at 1 Hz.
    pub flicker_nt2_per_hz_at_1hz: Quantity,
    /// Upper 95 % bound of A where no flicker noise was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flicker_below_nt2_per_hz: Option<f64>,
    /// α.
    pub flicker_exponent: Quantity,
    /// White noise of one reading, rounding taken off, nT rms: the mean over the series.
    pub white_rms_nt: Quantity,
    /// Upper 95 % bound of the white noise where none was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub white_below_nt: Option<f64>,
    /// How the white noise of the series compares: `per_reading` (one rms for all), `density` (one density
    /// for all), `each`.
    pub white: String,
    /// Covariance of A, α and the rms of a reading of the fastest series, which move together: where the
    /// density is lower at one end it is higher at the other. Empty where one of them was not found.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariance: Vec<Vec<f64>>,
    /// What it runs over: `flicker_nt2_per_hz_at_1hz`, `flicker_exponent`, `series.white_rms_nt`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariance_order: Vec<String>,
    /// √P at 1 Hz of the flicker noise, nT/√Hz.
    pub density_at_1hz_nt_per_sqrt_hz: Quantity,
    /// Probability of a worse agreement of the spectrum with this form by chance.
    pub goodness_p: f64,
    /// Rms in bands.
    pub bands: Vec<BandRms>,
    /// The merged spectrum.
    pub spectrum: MergedSpectrum,
    /// Allan deviation of each series.
    pub allan: AllanDeviation,
    /// Spectral lines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<SpectralLine>,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl SensorNoise {
    /// The noise that was measured, in the form in which instruments declare theirs.
    pub fn as_noise(&self) -> Noise {
        Noise {
            white_rms_nt: Some(self.white_rms_nt.value()),
            flicker_nt2_per_hz_at_1hz: Some(self.flicker_nt2_per_hz_at_1hz.value()),
            flicker_exponent: Some(self.flicker_exponent.value()),
            ..Noise::default()
        }
    }
}

/// One series of a noise recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct NoiseSeriesResult {
    /// The recording.
    pub recording: String,
    /// Samples.
    pub samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// Mean reading as field, nT.
    pub mean_nt: f64,
    /// Rms about it, nT.
    pub rms_nt: f64,
    /// White noise of one reading, rounding included, nT rms.
    pub white_rms_nt: Quantity,
    /// Width of a code as the readings show it, nT; absent where they show none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code_nt: Option<f64>,
    /// Density of rounding to such codes, δ² Δt/6, nT²/Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounding_nt2_per_hz: Option<f64>,
    /// `sensor`, `both` or `quantiser`: what the fast end of this series shows.
    pub measured: String,
    /// Amplification before the converter that would bring rounding to a tenth of the density at the fast
    /// end; a lower bound where codes are larger than the noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplification_needed: Option<f64>,
}

/// Rms in a band.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BandRms {
    /// The band, Hz.
    pub band_hz: [f64; 2],
    /// √∫ A f^-α df, nT.
    pub flicker_rms_nt: Quantity,
}

/// Overlapping Allan deviation, as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AllanDeviation {
    /// Number of the series, from 0.
    pub series: Vec<usize>,
    /// Averaging time, s.
    pub averaging_s: Vec<f64>,
    /// Deviation, nT.
    pub deviation_nt: Vec<f64>,
    /// Lower end of the 95 % interval.
    pub low_nt: Vec<f64>,
    /// Upper end of the 95 % interval.
    pub high_nt: Vec<f64>,
}

impl AllanDeviation {
    /// Adds the deviation of a series at one averaging time with its 95 % interval.
    pub fn push(&mut self, series: usize, averaging_s: f64, deviation_nt: f64, [low_nt, high_nt]: [f64; 2]) {
        self.series.push(series);
        self.averaging_s.push(averaging_s);
        self.deviation_nt.push(deviation_nt);
        self.low_nt.push(low_nt);
        self.high_nt.push(high_nt);
    }
}

/// What a measured field is uncertain by, at one field and one temperature.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ErrorBudget {
    /// Field along the sensor, nT.
    pub field_nt: f64,
    /// Temperature of the sensor less its reference, K.
    pub warmer_k: f64,
    /// Standard uncertainty, nT (JCGM 100).
    pub standard_nt: f64,
    /// All terms added in size, each at twice its standard uncertainty or at its bound, nT (NASA eq. 16).
    pub worst_case_nt: f64,
    /// The terms, the largest first.
    pub terms: Vec<BudgetTerm>,
}

/// One term of an error budget.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BudgetTerm {
    /// What it is.
    pub term: String,
    /// Its standard uncertainty, nT.
    pub std_nt: f64,
    /// Its share of the variance.
    pub share: f64,
}
