use common::{Axis, Calibration, Error, Matrix3x3, Model, PerAxis};
use noise::Stream;
use serde::{Deserialize, Serialize};

use crate::differential::DifferentialTruth;
use crate::plan::{Plan, Profile};

/// What is true behind a simulated document. It goes to a file of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Truth {
    /// Format version, 1.
    pub fluxcal: u64,
    /// The seed.
    pub seed: u64,
    /// True constants and axes.
    pub calibration: Calibration,
    /// Effects that acted.
    pub model: Model,
    /// Field at the sensors with no drive, GEO, nT.
    pub residual_field_nt: [f64; 3],
    /// Field left in the shield, SEN, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shield_field_nt: Option<PerAxis<f64>>,
    /// Field of each coil along its axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil_profile: Option<PerAxis<Profile>>,
    /// Errors of resistors and voltmeter, where the drive is written as voltage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub electrical: Option<Electrical>,
    /// The two magnetometers of a differential recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub differential: Option<DifferentialTruth>,
    /// What was added to the offsets at each recording of `offset_drift`, nT.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub offset_wander: Vec<Wander>,
    /// True orientation of each recording.
    pub orientations: Vec<TrueOrientation>,
}

impl Truth {
    /// Itself, where all its numbers are finite. Errors: a number that is not finite, with its path.
    pub fn finite(&self) -> Result<&Self, Error> {
        common::all_finite("truth", self)?;
        Ok(self)
    }
}

/// The true orientation of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TrueOrientation {
    /// The recording.
    pub recording: String,
    /// R, GEO -> SEN.
    pub orientation: Matrix3x3,
}

/// How far a sensor's offset had wandered at a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Wander {
    /// The recording.
    pub recording: String,
    /// Added to the sensor's offset, nT.
    pub offset_nt: f64,
}

/// What resistors and voltmeter truly are, the same through the campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Electrical {
    /// True resistances, ohm.
    pub resistor_ohm: PerAxis<f64>,
    /// Relative error of the voltmeter.
    pub voltmeter_relative: f64,
    /// What the voltmeter adds, V.
    pub voltmeter_offset_v: f64,
}

impl Electrical {
    /// Draws them from the seed and the stated uncertainties.
    pub fn draw(plan: &Plan) -> Result<Self, Error> {
        let normal = |name: &str| Stream::new(plan.seed, name).normal();
        let facility = plan.facility.clone().unwrap_or_default();
        let voltmeter = facility.voltmeter.unwrap_or_default();
        let mut resistor_ohm = PerAxis::default();
        for (axis, coil) in facility.coils.iter().flat_map(PerAxis::iter) {
            if let Some(ohm) = coil.resistor_ohm {
                if !(ohm.is_finite() && ohm > 0.0) {
                    let path = format!("facility.coils.{axis}.resistor_ohm");
                    return Err(Error::document(path, ohm.to_string(), "a positive number"));
                }
                let relative = coil.resistor_relative_uncertainty.unwrap_or(0.0);
                let error = relative * normal(&format!("resistor_{axis}"));
                *resistor_ohm.entry(axis) = Some(ohm * (1.0 + error));
            }
        }
        Ok(Self {
            resistor_ohm,
            voltmeter_relative: voltmeter.relative.unwrap_or(0.0) * normal("voltmeter/relative"),
            voltmeter_offset_v: voltmeter.absolute_v.unwrap_or(0.0) * normal("voltmeter/offset"),
        })
    }

    /// What the voltmeter reads over a coil's resistor for a current.
    pub fn reads(&self, coil: Axis, current_a: f64) -> Option<f64> {
        let ohm = self.resistor_ohm.get(coil)?;
        Some(current_a * ohm * (1.0 + self.voltmeter_relative) + self.voltmeter_offset_v)
    }
}

/// What is stated, with what the truth says otherwise, key by key.
pub fn true_calibration(plan: &Plan) -> Result<Calibration, Error> {
    let stated = plan.calibration.clone().unwrap_or_default();
    let truth = plan.truth.calibration.clone().unwrap_or_default();
    let mut calibration = stated.overlaid(&truth, "truth.calibration")?;
    if let Some(differential) = &plan.truth.differential {
        calibration.differential = Some(differential.calibration()?);
    }
    Ok(calibration)
}
