#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use common::{Error, Matrix3x3, Versioned};

use crate::conformity::verdict::Side;

/// Largest factor of the guard band. Beyond it the probability that a verdict is wrong is no number of double
/// precision.
const LARGEST_FACTOR: f64 = 30.0;

/// The conditions of requirements, in the order in which they are checked.
const CONDITIONS: [&str; 8] = [
    "band_hz",
    "over_s",
    "sensor_temperature_c",
    "electronics_temperature_c",
    "years",
    "range_nt",
    "nominal_matrix",
    "nominal_std_arcsec",
];

/// What an instrument must do, and how it is decided whether it does.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// Format version, 1.
    pub fluxcal: u64,
    /// Its name.
    pub title: String,
    /// Where it stands.
    pub source: Option<String>,
    /// Guard band in standard uncertainties, for a limit that can be missed on one side: 1.645 is 95 %.
    #[serde(default = "one_sided_95")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 30.0)))]
    pub guard_factor: f64,
    /// The requirements, in the order of the table.
    pub requirements: Vec<Requirement>,
}

fn one_sided_95() -> f64 {
    1.645
}

/// One requirement. Which conditions belong to it depends on its kind; others are refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Requirement {
    /// What is required.
    pub kind: RequirementKind,
    /// The limit, in the unit at the end of the kind's name.
    pub limit: f64,
    /// The requirement in a few words.
    pub title: String,
    /// Where it stands.
    pub source: Option<String>,
    /// Lowest and highest frequency, Hz.
    pub band_hz: Option<[f64; 2]>,
    /// How long it is measured, s.
    pub over_s: Option<f64>,
    /// Temperatures of the sensors.
    pub sensor_temperature_c: Option<Temperatures>,
    /// Temperatures of the electronics.
    pub electronics_temperature_c: Option<Temperatures>,
    /// How long after the calibration it must hold, years of 365.25 days.
    pub years: Option<f64>,
    /// Largest magnitude of the field, nT.
    pub range_nt: Option<f64>,
    /// Directions that the sensors must have: columns = vectors in SEN, of any length.
    pub nominal_matrix: Option<Matrix3x3>,
    /// Standard uncertainty of each of these directions, arcsec.
    pub nominal_std_arcsec: Option<f64>,
}

/// What can be required; the unit of the limit ends the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum RequirementKind {
    /// How far the angle between two sensors may be from 90°.
    OrthogonalityDeg,
    /// Standard uncertainty of the directions of the sensors.
    AxesArcsec,
    /// How far a sensor may be turned from `nominal_matrix`.
    AxesFromNominalArcsec,
    /// How far a sensor may turn over `sensor_temperature_c`.
    AxesOverTemperatureArcsec,
    /// The field that each sensor reads at least, of either sign.
    RangeNt,
    /// Width of a code.
    ResolutionNt,
    /// The frequency up to which a sensor follows the field at least.
    BandwidthHz,
    /// Zero to peak of the noise of a sensor in `band_hz` over `over_s`.
    NoiseZeroToPeakNt,
    /// How far an offset may change over temperatures, `years`, or both.
    OffsetStabilityNt,
    /// Error of a component of the corrected field in SEN, up to `range_nt`, over temperatures and `years`
    /// where they are given.
    AbsoluteAccuracyNt,
}

/// A range of temperatures, degC.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged, expecting = "[lowest, highest] in degC, or \"calibrated\"")]
pub enum Temperatures {
    /// Lowest and highest.
    Range([f64; 2]),
    /// Those of the calibration.
    Word(Calibrated),
}

/// The word for what the calibration went through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Calibrated {
    /// The range of the temperature run.
    Calibrated,
}

impl RequirementKind {
    /// The kind as it is written.
    pub fn name(self) -> String {
        let name = serde_json::to_value(self).unwrap_or_default();
        name.as_str().unwrap_or_default().into()
    }

    /// The unit of limit and value.
    pub fn unit(self) -> &'static str {
        self.about().0
    }

    /// On which side of its limit it is met.
    pub fn side(self) -> Side {
        self.about().1
    }

    /// The unit, the side, the conditions that it must have, and those that it may have.
    fn about(self) -> (&'static str, Side, &'static [&'static str], &'static [&'static str]) {
        use Side::{Above, Below, Within};
        const OVER: &[&str] = &["sensor_temperature_c", "electronics_temperature_c", "years"];
        match self {
            RequirementKind::OrthogonalityDeg => ("deg", Within, &[], &[]),
            RequirementKind::AxesArcsec => ("arcsec", Below, &[], &[]),
            RequirementKind::AxesFromNominalArcsec => {
                ("arcsec", Below, &[], &["nominal_matrix", "nominal_std_arcsec"])
            }
            RequirementKind::AxesOverTemperatureArcsec => ("arcsec", Below, &["sensor_temperature_c"], &[]),
            RequirementKind::RangeNt => ("nT", Above, &[], &[]),
            RequirementKind::ResolutionNt => ("nT", Below, &[], &[]),
            RequirementKind::BandwidthHz => ("Hz", Above, &[], &[]),
            RequirementKind::NoiseZeroToPeakNt => ("nT", Below, &["band_hz", "over_s"], &[]),
            RequirementKind::OffsetStabilityNt => ("nT", Within, &[], OVER),
            RequirementKind::AbsoluteAccuracyNt => ("nT", Within, &["range_nt"], OVER),
        }
    }
}

impl Versioned for Spec {
    fn format_version(&self) -> Option<u64> {
        Some(self.fluxcal)
    }
}

impl Spec {
    /// Reads and checks a specification.
    ///
    /// # Errors
    ///
    /// What is no specification or cannot be followed, with its JSON path.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let spec: Spec = common::parse(text)?;
        if spec.requirements.is_empty() {
            return Err(Error::document("requirements", "none", "at least one requirement"));
        }
        if !(0.0..=LARGEST_FACTOR).contains(&spec.guard_factor) {
            let expected = "a factor from zero to 30; 1.645 is 95 % on one side";
            return Err(Error::document("guard_factor", spec.guard_factor.to_string(), expected));
        }
        for (index, requirement) in spec.requirements.iter().enumerate() {
            requirement.check(&format!("requirements[{index}]"))?;
        }
        Ok(spec)
    }
}

impl Requirement {
    fn check(&self, path: &str) -> Result<(), Error> {
        let refused = |key: &str, found: String, expected: &str| {
            Err(Error::document(format!("{path}.{key}"), found, expected))
        };
        let kind = self.kind.name();
        let stated = serde_json::to_value(self).unwrap_or_default();
        let given = |key: &str| !stated[key].is_null();
        let (.., must, may) = self.kind.about();
        for key in CONDITIONS {
            let needed = must.contains(&key);
            if given(key) && !needed && !may.contains(&key) {
                let expected = format!("no such key in `{kind}`; take it out, or is another kind meant?");
                return refused(key, "a condition".into(), &expected);
            }
            if needed && !given(key) {
                let found = format!("`{kind}` without `{key}`");
                return Err(Error::document(path, found, format!("`{key}`, which it needs")));
            }
        }
        let above_zero = |value: f64| value.is_finite() && value > 0.0;
        for (key, value) in [
            ("limit", Some(self.limit)),
            ("over_s", self.over_s),
            ("years", self.years),
            ("range_nt", self.range_nt),
        ] {
            if let Some(value) = value.filter(|value| !above_zero(*value)) {
                return refused(key, value.to_string(), "a number above zero");
            }
        }
        if let Some([low, high]) = self.band_hz.filter(|[low, high]| !(above_zero(*low) && low < high)) {
            return refused("band_hz", format!("{low} to {high}"), "[lowest, highest], both above zero");
        }
        for (key, range) in [
            ("sensor_temperature_c", self.sensor_temperature_c),
            ("electronics_temperature_c", self.electronics_temperature_c),
        ] {
            if let Some(Temperatures::Range([low, high])) = range
                && !(low.is_finite() && low <= high)
            {
                return refused(key, format!("{low} to {high}"), "[lowest, highest] in degC");
            }
        }
        if self.nominal_std_arcsec.is_some_and(|std| !(std.is_finite() && std >= 0.0)) {
            return refused("nominal_std_arcsec", "less than zero".into(), "arcseconds of zero or more");
        }
        if self.nominal_matrix.is_some_and(|matrix| (0..3).any(|j| matrix.iter().all(|row| row[j] == 0.0))) {
            let expected = "three columns with a direction each";
            return refused("nominal_matrix", "a column of zeros".into(), expected);
        }
        let asks = may.iter().any(|key| given(key));
        if self.kind == RequirementKind::OffsetStabilityNt && !asks {
            return Err(Error::document(
                path,
                format!("`{kind}` with neither temperatures nor years"),
                "`sensor_temperature_c`, `electronics_temperature_c` or `years`: over what the offset must be stable",
            ));
        }
        Ok(())
    }
}
