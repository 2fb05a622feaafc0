use indexmap::IndexMap;
use serde::{Deserialize, Deserializer, Serialize, de};
use std::fmt;

use crate::column::Unread;
use crate::number::{bare, counted, quoted};
use crate::time::Start;
use crate::{Axis, Column, Error, Extra, Matrix3x3, NoiseOfSensors, Quantity, range};

/// Names of the procedures that recordings follow.
pub mod procedure {
    /// Field of one coil against its current, read by coilcal.
    pub const COIL_CONSTANT: &str = "coil_constant";
    /// Field of one coil along its axis, read by coilcal.
    pub const COIL_GRADIENT: &str = "coil_gradient";
    /// What the nulling leaves, in a site condition, read by coilcal.
    pub const NULLING_RESIDUAL: &str = "nulling_residual";
    /// Readings of one sensor against a coil's field, read by sensorcal.
    pub const SENSOR_SENSITIVITY: &str = "sensor_sensitivity";
    /// Readings of one sensor in two opposite positions, read by sensorcal.
    pub const SENSOR_OFFSET_REVERSAL: &str = "sensor_offset_reversal";
    /// Readings in a shield, read by sensorcal.
    pub const SENSOR_NOISE: &str = "sensor_noise";
    /// One of many reversals at different dates, read by sensorcal.
    pub const OFFSET_DRIFT: &str = "offset_drift";
    /// Sensitivity at many temperatures, read by sensorcal.
    pub const TEMPERATURE_RUN: &str = "temperature_run";
    /// Sensitivity with fields across the sensor, read by sensorcal.
    pub const CROSS_FIELD: &str = "cross_field";
    /// Directions of sensors and coils, read by axescal.
    pub const AXES_ORIENTATION: &str = "axes_orientation";
    /// Two magnetometers side by side, read by diffmag.
    pub const DIFFERENTIAL: &str = "differential";
    /// Directions of the field by a theodolite, read by absolute.
    pub const ABSOLUTE: &str = "absolute";
    /// Readings of a variometer, read by absolute and correct.
    pub const VARIOMETER: &str = "variometer";
    /// Any drive and any readings, read by diagnose.
    pub const FREE_RUN: &str = "free_run";
    /// All of them.
    pub const ALL: &[&str] = &[
        COIL_CONSTANT,
        COIL_GRADIENT,
        NULLING_RESIDUAL,
        SENSOR_SENSITIVITY,
        SENSOR_OFFSET_REVERSAL,
        SENSOR_NOISE,
        OFFSET_DRIFT,
        TEMPERATURE_RUN,
        CROSS_FIELD,
        AXES_ORIENTATION,
        DIFFERENTIAL,
        ABSOLUTE,
        VARIOMETER,
        FREE_RUN,
    ];
}

/// One recording: what was done, under which conditions, and the columns that came of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Recording {
    /// Unique within the document.
    pub id: String,
    /// The procedure that it follows.
    pub procedure: String,
    /// When it began, RFC 3339. Absent: `time_s` is on the campaign's clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// What held throughout.
    #[serde(default)]
    pub conditions: Conditions,
    /// The readings, by column name; all of one length.
    #[serde(default, skip_serializing_if = "Columns::is_empty", deserialize_with = "unique_columns")]
    pub columns: Columns,
    /// Instead of `columns`: a file beside the document, as a relative path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// What the readings were before a stage left them out (`--drop-recordings`). Readings that are put back
    /// are held to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dropped: Option<Dropped>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Readings that were left out of a document.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Dropped {
    /// How many rows there were.
    pub rows: usize,
    /// SHA-256 of the columns in the order of their names, in hexadecimal: of each its name in UTF-8, a zero
    /// byte, and its values as IEEE 754 doubles, the lowest byte first; a missing reading is the NaN
    /// 7ff8000000000000.
    pub sha256: String,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Columns by name, in the document's order.
pub type Columns = IndexMap<String, Column>;

impl Recording {
    /// When it began, where that is said.
    pub fn start(&self) -> Option<Start> {
        self.start.as_deref().and_then(Start::parse)
    }

    /// The readings are at hand: the program has read the table where they stand in a file.
    ///
    /// # Errors
    ///
    /// A table of which no column was read; readings that a stage left out.
    pub fn at_hand(&self, path: &str) -> Result<(), Error> {
        match &self.table {
            Some(table) if self.columns.is_empty() => {
                let found = format!("the table \"{table}\", which was not read");
                Err(Error::document(format!("{path}.table"), found, "the readings under `columns`"))
            }
            None if self.columns.is_empty() => match &self.dropped {
                Some(dropped) => Err(Error::document(
                    format!("{path}.dropped"),
                    format!(
                        "{} of recording \"{}\" that an earlier stage left out (SHA-256 {})",
                        counted(dropped.rows, "row"),
                        self.id,
                        dropped.sha256
                    ),
                    "the readings; put back those of this digest, run that stage without --drop-recordings, or this one before it",
                )),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    /// Every reading is one that an instrument can give, also one that holds throughout, and times do not run
    /// backwards.
    ///
    /// # Errors
    ///
    /// The column and the row of one that none can, or the condition; the row in which a time is before another.
    pub fn check(&self, path: &str) -> Result<(), Error> {
        for (name, column) in &self.columns {
            let [low, high] = range::bounds(name);
            if let Some(row) = column.first_outside([low, high]) {
                return Err(Error::document(
                    format!("{path}.columns.{name}[{row}]"),
                    format!("{} in recording \"{}\"", quoted(column[row]), self.id),
                    format!(
                        "a reading between {} and {}; write null for a missing reading",
                        bare(low),
                        bare(high)
                    ),
                ));
            }
        }
        for (name, value) in &self.conditions.extra {
            if let Some(value) = value.as_f64() {
                range::number(format!("{path}.conditions.{name}"), value)?;
            }
        }
        self.check_times(path)
    }

    fn check_times(&self, path: &str) -> Result<(), Error> {
        let times = self.column("time_s").unwrap_or_default();
        if times.is_sorted() {
            return Ok(());
        }
        let mut latest = f64::NEG_INFINITY;
        for (row, time) in times.iter().enumerate() {
            if *time < latest {
                return Err(Error::document(
                    format!("{path}.columns.time_s[{row}]"),
                    format!("{} after {} in recording \"{}\"", quoted(*time), quoted(latest), self.id),
                    "times that do not run backwards; sort the rows, or make two recordings where a clock was set back",
                ));
            }
            latest = latest.max(*time);
        }
        Ok(())
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.values().map(|column| column.len()).max().unwrap_or(0)
    }

    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.get(name).map(|column| column.as_slice())
    }

    /// The column `{quantity}_{axis}_{unit}`.
    pub fn axis_column(&self, quantity: &str, axis: Axis, unit: &str) -> Option<&[f64]> {
        self.column(&format!("{quantity}_{axis}_{unit}"))
    }
}

/// Columns by name; a name that comes twice is an error and not a choice.
fn unique_columns<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Columns, D::Error> {
    struct Visitor;
    impl<'de> de::Visitor<'de> for Visitor {
        type Value = Columns;
        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an object of columns")
        }
        fn visit_map<M: de::MapAccess<'de>>(self, mut map: M) -> Result<Columns, M::Error> {
            let mut columns = Columns::new();
            while let Some((name, Unread(column))) = map.next_entry::<String, Unread>()? {
                if columns.contains_key(&name) {
                    return Err(de::Error::custom(format!(
                        "the column `{name}` twice, expected each name once"
                    )));
                }
                columns.insert(name, column);
            }
            Ok(columns)
        }
    }
    deserializer.deserialize_map(Visitor)
}

/// What held throughout a recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Conditions {
    /// The sensor under test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Axis>,
    /// The coil under test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil: Option<Axis>,
    /// R, GEO -> SEN: rows = SEN axes in GEO. Beside `theodolite` it is the nominal rotation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Matrix3x3>,
    /// The theodolites' readings, from which R is made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub theodolite: Option<Theodolite>,
    /// Name of the setting of the block. Recordings of one orientation share a setting, and with it the
    /// errors of the theodolites; give names where the same orientation was set anew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setting: Option<String>,
    /// Frequency of an AC drive, one for all coils, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive_hz: Option<f64>,
    /// Time over which one sample is averaged, s. Absent: samples are instantaneous.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integration_s: Option<f64>,
    /// Whether the sensors are mounted on the body whose iron turns with them (a satellite, a vehicle), or
    /// away from it. Absent: it is not said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mounted: Option<bool>,
    /// Noise of the reference magnetometer of a differential recording, as its makers or an earlier
    /// comparison state it: the same for its three axes, or keyed by axis. It is taken from the difference,
    /// and what it pulls off the matrix is put back; absent, it is sought in the readings.
    /// (`instrument.noise` is that of the test instrument.)
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_noise: Option<NoiseOfSensors>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Conditions {
    /// A condition of another name that is a number, with its uncertainty where one is stated. `path` is that of the
    /// recording.
    ///
    /// # Errors
    ///
    /// Something else under that name.
    pub fn quantity(&self, name: &str, path: &str) -> Result<Option<Quantity>, Error> {
        let read = |stated: &serde_json::Value| {
            serde_json::from_value(stated.clone()).map_err(|_| {
                let expected = "a number, or {\"value\": number, \"std\": number}";
                Error::document(format!("{path}.conditions.{name}"), stated.to_string(), expected)
            })
        };
        self.extra.get(name).map(read).transpose()
    }
}

/// Readings of the two theodolites (NASA eq. 7 to 9): azimuth φ and polar angle θ of the faces that
/// look north (x) and east (y), rad. R = nominal rotation × the rotation that the mean angles give.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Theodolite {
    /// Azimuth of the north face from north, rad.
    pub phi_x_rad: TheodoliteAngle,
    /// Polar angle of the north face from down, rad (about π/2).
    pub theta_x_rad: TheodoliteAngle,
    /// Azimuth of the east face from east, rad.
    pub phi_y_rad: TheodoliteAngle,
    /// Polar angle of the east face from down, rad (about π/2).
    pub theta_y_rad: TheodoliteAngle,
    /// The fixture's nominal rotation, rows = SEN axes along the (north, east, down) faces. Absent: identity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal_rotation: Option<Matrix3x3>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// An angle that was read once, or several times in the same setting of the block.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum TheodoliteAngle {
    /// One reading, rad.
    Once(f64),
    /// Readings of the same angle, rad; at least one.
    Repeated(#[cfg_attr(feature = "schema", schemars(length(min = 1)))] Vec<f64>),
}

impl TheodoliteAngle {
    /// The readings, rad.
    pub fn readings(&self) -> &[f64] {
        match self {
            TheodoliteAngle::Once(reading) => std::slice::from_ref(reading),
            TheodoliteAngle::Repeated(readings) => readings,
        }
    }

    /// Their mean, rad.
    pub fn mean(&self) -> f64 {
        let readings = self.readings();
        readings.iter().sum::<f64>() / readings.len() as f64
    }
}

impl<'de> Deserialize<'de> for TheodoliteAngle {
    /// A number, or a list of at least one.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "an angle in rad, or a list of readings of it")]
        enum Read {
            Once(f64),
            Repeated(Vec<f64>),
        }
        match Read::deserialize(deserializer)? {
            Read::Once(reading) => Ok(TheodoliteAngle::Once(reading)),
            Read::Repeated(readings) if readings.is_empty() => {
                Err(de::Error::custom("an empty list, expected at least one reading of the angle"))
            }
            Read::Repeated(readings) => Ok(TheodoliteAngle::Repeated(readings)),
        }
    }
}
