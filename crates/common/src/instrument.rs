use serde::{Deserialize, Deserializer, Serialize};

use crate::quantity::not_negative;
use crate::{Axis, Extra, PerAxis};

/// The magnetometer as its makers state it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Instrument {
    /// Its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Largest field that it reads, nT (nominal).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_nt: Option<f64>,
    /// The sensors that it has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// Sensitivity where no calibration gives one, nT/V.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_sensitivity_nt_per_v: Option<f64>,
    /// Width of one code of the converter, V (nominal).
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub quantisation_v: Option<f64>,
    /// Width of one code for instruments that give field, nT (nominal).
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub quantisation_nt: Option<f64>,
    /// Noise of a reading: the same for all sensors, or keyed by sensor. Absent: estimated from the
    /// recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseOfSensors>,
    /// Place of each sensor in SEN, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub positions_m: Option<PerAxis<[f64; 3]>>,
    /// Standard uncertainty of each coordinate of those places, m.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub positions_std_m: Option<f64>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Instrument {
    /// The declared noise of one sensor, where it is declared.
    pub fn noise_of(&self, sensor: Axis) -> Option<&Noise> {
        self.noise.as_ref()?.of(sensor)
    }
}

/// Noise of the sensors: one description for all, or an object keyed by sensor.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum NoiseOfSensors {
    /// The same for all sensors.
    Same(Noise),
    /// One for each sensor.
    Each(Box<PerAxis<Noise>>),
}

impl NoiseOfSensors {
    /// That of one sensor, where it is declared.
    pub fn of(&self, sensor: Axis) -> Option<&Noise> {
        match self {
            NoiseOfSensors::Each(each) => each.get(sensor),
            NoiseOfSensors::Same(noise) => Some(noise),
        }
    }
}

impl<'de> Deserialize<'de> for NoiseOfSensors {
    /// Keyed by sensor when one of the keys is a sensor's.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keys = Extra::deserialize(deserializer)?;
        let keyed = Axis::ALL.iter().any(|axis| keys.contains_key(axis.letter()));
        let value = serde_json::Value::Object(keys);
        if keyed {
            PerAxis::deserialize(value).map(|each| NoiseOfSensors::Each(Box::new(each)))
        } else {
            Noise::deserialize(value).map(NoiseOfSensors::Same)
        }
        .map_err(serde::de::Error::custom)
    }
}

/// Noise of a reading: white, flicker P(f) = A f^-α, one-sided, down to one over the record's length, and a
/// random walk.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Noise {
    /// White noise of one reading, nT rms.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub white_rms_nt: Option<f64>,
    /// Flicker power density at 1 Hz, nT²/Hz.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub flicker_nt2_per_hz_at_1hz: Option<f64>,
    /// Exponent α of the flicker noise (1 where absent).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flicker_exponent: Option<f64>,
    /// Random walk: rms change after one second, nT/√s.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub random_walk_nt_per_sqrt_s: Option<f64>,
    /// Relative standard uncertainty of this declaration.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub relative_std: Option<f64>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Noise {
    /// One-sided power density of readings `step_s` apart, nT²/Hz: 2 σ² Δt + A f^-α + r²/(2π² f²), r that of
    /// the random walk.
    pub fn density(&self, frequency_hz: f64, step_s: f64) -> f64 {
        let white = self.white_rms_nt.unwrap_or(0.0);
        let flicker = self.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0);
        let walk = self.random_walk_nt_per_sqrt_s.unwrap_or(0.0) / (std::f64::consts::PI * frequency_hz);
        2.0 * white * white * step_s
            + flicker * frequency_hz.powf(-self.flicker_exponent.unwrap_or(1.0))
            + 0.5 * walk * walk
    }

    /// Rms of one reading in a record of `length_s` seconds sampled each `step_s` seconds, nT: √(white² + ∫ A
    /// f^-α df + r² length/6), the integral from 1/length to the Nyquist frequency 1/(2 step), the last term
    /// the variance of a random walk about its mean over the record. Without times only the white part is
    /// known.
    pub fn rms_nt(&self, length_s: f64, step_s: f64) -> f64 {
        let white = self.white_rms_nt.unwrap_or(0.0);
        let amplitude = self.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0);
        let alpha = self.flicker_exponent.unwrap_or(1.0);
        let (low, high) = (1.0 / length_s, 0.5 / step_s);
        let flicker = if amplitude <= 0.0 || !low.is_finite() || !high.is_finite() || high <= low {
            0.0
        } else if (alpha - 1.0).abs() < 1e-9 {
            amplitude * (high / low).ln()
        } else {
            amplitude * (high.powf(1.0 - alpha) - low.powf(1.0 - alpha)) / (1.0 - alpha)
        };
        let rate = self.random_walk_nt_per_sqrt_s.unwrap_or(0.0);
        let walk = if length_s.is_finite() { rate * rate * length_s / 6.0 } else { 0.0 };
        (white * white + flicker + walk).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_decades_of_flicker_as_in_nasa_figure_7() {
        // 26e-3 nT rms over any three decades of a 1/f spectrum: A = 0.026²/ln 1000.
        let amplitude = 0.026f64.powi(2) / 1000f64.ln();
        let noise = Noise { flicker_nt2_per_hz_at_1hz: Some(amplitude), ..Noise::default() };
        assert!((noise.rms_nt(100.0, 0.05) - 0.026).abs() < 1e-12);
        assert!((noise.rms_nt(1e5, 50.0) - 0.026).abs() < 1e-12);
        // A random walk of 0.01 nT/√s over 600 s: 0.1 nT about its mean.
        let walk = Noise { random_walk_nt_per_sqrt_s: Some(0.01), ..Noise::default() };
        assert!((walk.rms_nt(600.0, 1.0) - 0.1).abs() < 1e-12);
        assert_eq!(walk.rms_nt(f64::INFINITY, f64::INFINITY), 0.0);
        let steep = Noise { flicker_exponent: Some(1.000_001), ..noise };
        assert!((steep.rms_nt(100.0, 0.05) - 0.026).abs() < 1e-6);
    }
}
