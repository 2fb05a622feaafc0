use serde::{Deserialize, Deserializer, Serialize};
use serde_json::value::RawValue;

use crate::uncertainty::joint::Uncertainty;
use crate::{
    AbsoluteCalibration, AxesCalibration, Axis, CoilFit, CoilSurvey, CommonExtremum, DifferentialCalibration,
    Error, Extra, FlightCalibration, GradientCoil, NullingCalibration, PerAxis, Quantity, ScalarCalibration,
    SensorCalibration, json, parse, undetermined,
};

/// What the stages found; a stage with no recording of its own may be given these instead.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// The sensors by the magnitude of the field, by scalarcal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scalar: Option<Box<ScalarCalibration>>,
    /// Absolute measurements and baselines, by absolute.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absolute: Option<Box<AbsoluteCalibration>>,
    /// A magnetometer beside star cameras, by starcal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flight: Option<Box<FlightCalibration>>,
    /// The joint uncertainty of all that is calibrated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
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

    /// What is stated here, with what `other` states put over it key by key. `path` is that of `other`.
    ///
    /// # Errors
    ///
    /// The two together are no calibration.
    pub fn overlaid(&self, other: &Self, path: &str) -> Result<Self, Error> {
        Self::read(&json::overlaid(self, other)).map_err(|error| error.below(path))
    }

    /// Not generic, so that the code of all these types is made in this crate alone.
    fn read(text: &str) -> Result<Self, Error> {
        undetermined::part(text)
    }

    /// Every number is there.
    fn determined(self) -> Result<Self, Error> {
        match undetermined::undetermined("", &self).into_iter().next() {
            Some(one) => {
                Err(Error::document(one.path.trim_start_matches('.'), "null", "a number, as all of a plan"))
            }
            None => Ok(self),
        }
    }
}

/// Reads a calibration that stands in a plan, by the code that is made for the document's: for
/// `deserialize_with`.
///
/// # Errors
///
/// As of a document, below the path at which the calibration stands; a number that is undetermined.
pub fn calibration_of<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Calibration>, D::Error> {
    let text = Option::<Box<RawValue>>::deserialize(deserializer)?;
    let read = |text: Box<RawValue>| Calibration::read(text.get())?.determined();
    text.map(|text| read(text).map_err(parse::carried)).transpose()
}

/// One coil: B = k I + B0, along the coil's own axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// Temperatures at which the constants hold, and the field outside from which its variations count; absent ones are the
/// mean of the recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    /// Field of the station outside (`outside_x_nt`, ...) from which variations count, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside_x_nt: Option<f64>,
    /// The same along y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside_y_nt: Option<f64>,
    /// The same along z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside_z_nt: Option<f64>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}
