use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    AxesCalibration, Axis, CoilFit, CoilSurvey, CommonExtremum, DifferentialCalibration, Extra, GradientCoil,
    NullingCalibration, PerAxis, Quantity, SensorCalibration,
};

/// What the stages found; a stage with no recording of its own may be given these instead.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Calibration {
    /// The coils, by coilcal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coils: Option<PerAxis<CoilCalibration>>,
    /// What the nulling leaves, by coilcal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nulling: Option<Box<NullingCalibration>>,
    /// The sensors, by sensorcal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<PerAxis<SensorCalibration>>,
    /// Temperatures at which no sensor changes, by sensorcal.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub common_extrema: Vec<CommonExtremum>,
    /// The directions of sensors and coils, by axescal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<AxesCalibration>,
    /// One magnetometer against another, by diffmag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub differential: Option<DifferentialCalibration>,
    /// Temperatures at which the constants hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_conditions: Option<ReferenceConditions>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Calibration {
    /// What is known of a coil.
    pub fn coil(&self, axis: Axis) -> Option<&CoilCalibration> {
        self.coils.as_ref()?.get(axis)
    }

    /// What is known of a sensor.
    pub fn sensor(&self, axis: Axis) -> Option<&SensorCalibration> {
        self.sensors.as_ref()?.get(axis)
    }
}

/// One coil: B = k I + B0, along the coil's own axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CoilCalibration {
    /// Coil constant k, nT/A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constant_nt_per_a: Option<Quantity>,
    /// Coil offset B0, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_nt: Option<Quantity>,
    /// Covariance of the keys in `covariance_order`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// The keys that `covariance` runs over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance_order: Option<Vec<String>>,
    /// How they were found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constant: Option<Box<CoilFit>>,
    /// Surveys of its field along its axis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surveys: Vec<CoilSurvey>,
    /// How its gradient coil is to be set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient_coil: Option<GradientCoil>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Temperatures at which the constants hold; absent ones are the mean of the recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReferenceConditions {
    /// Temperature of the sensors, degC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor_temperature_c: Option<f64>,
    /// Temperature of the electronics, degC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub electronics_temperature_c: Option<f64>,
    /// Temperature of the coils, degC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil_temperature_c: Option<f64>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}
