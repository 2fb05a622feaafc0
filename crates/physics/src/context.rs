//! What a recording says besides its readings: times, drive, temperatures, orientation.

use common::{Axis, Document, Recording};
use nalgebra::{Matrix3, Vector3};

use crate::Error;
use crate::frames::{ARCSEC, Orientation};

/// The unit of the readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Raw output, V.
    Volt,
    /// Field, nT.
    Nanotesla,
}

impl Unit {
    /// The ending of column names.
    pub fn suffix(self) -> &'static str {
        match self {
            Unit::Volt => "v",
            Unit::Nanotesla => "nt",
        }
    }
}

/// Temperatures at which the constants hold, degC.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct References {
    /// Of the sensors.
    pub sensor_c: Option<f64>,
    /// Of the electronics.
    pub electronics_c: Option<f64>,
    /// Of the coils.
    pub coil_c: Option<f64>,
}

impl References {
    /// As `calibration.reference_conditions` gives them, else the mean of all recordings.
    pub fn of(document: &Document) -> Self {
        let given = document.calibration.as_ref().and_then(|c| c.reference_conditions.as_ref());
        let mean = |name: &str| {
            let all = document.recordings.iter().filter_map(|recording| recording.column(name)).flatten();
            let (sum, count) = all.filter(|t| t.is_finite()).fold((0.0, 0.0), |(s, n), t| (s + t, n + 1.0));
            (count > 0.0).then(|| sum / count)
        };
        Self {
            sensor_c: given.and_then(|g| g.sensor_temperature_c).or_else(|| mean("sensor_temperature_c")),
            electronics_c: given
                .and_then(|g| g.electronics_temperature_c)
                .or_else(|| mean("electronics_temperature_c")),
            coil_c: given.and_then(|g| g.coil_temperature_c).or_else(|| mean("coil_temperature_c")),
        }
    }
}

/// One recording as the chain sees it.
#[derive(Clone, Debug)]
pub struct Context<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Number of rows.
    pub rows: usize,
    /// Current in the coils x, y, z for each row, A; zero where a coil has no column, NaN where a reading is missing.
    pub current_a: Vec<Vector3<f64>>,
    /// Field besides the coils', GEO, nT, for each row.
    pub ambient_nt: Vec<Vector3<f64>>,
    /// R, GEO -> SEN.
    pub orientation: Orientation,
    /// Unit of the readings.
    pub unit: Unit,
    /// Reference temperatures.
    pub references: References,
}

impl<'a> Context<'a> {
    /// Reads a recording of a document.
    pub fn new(document: &Document, recording: &'a Recording, references: References) -> Result<Self, Error> {
        let rows = recording.rows();
        let has = |unit: Unit| {
            Axis::ALL.iter().any(|a| recording.axis_column("sensor", *a, unit.suffix()).is_some())
        };
        Ok(Self {
            recording,
            rows,
            current_a: currents(document, recording, rows)?,
            ambient_nt: ambient(recording, rows),
            orientation: orientation(document, recording)?,
            unit: if has(Unit::Nanotesla) && !has(Unit::Volt) { Unit::Nanotesla } else { Unit::Volt },
            references,
        })
    }

    /// The times, which an effect with memory needs: all there, never running backwards.
    pub fn times(&self, who: &str) -> Result<&'a [f64], Error> {
        let times = self.column("time_s", who)?;
        match times.windows(2).position(|pair| pair[1].is_nan() || pair[0].is_nan() || pair[1] < pair[0]) {
            Some(row) => Err(Error::Missing {
                recording: self.recording.id.clone(),
                who: who.into(),
                what: format!(
                    "times that do not run backwards; after row {row} `time_s` is missing or falls"
                ),
            }),
            None => Ok(times),
        }
    }

    /// A column that `who` cannot do without.
    pub fn column(&self, name: &str, who: &str) -> Result<&'a [f64], Error> {
        self.recording.column(name).ok_or_else(|| self.missing(who, &format!("the column `{name}`")))
    }

    /// The error that `who` lacks `what`.
    pub fn missing(&self, who: &str, what: &str) -> Error {
        Error::Missing { recording: self.recording.id.clone(), who: who.into(), what: what.into() }
    }
}

/// I from `coil_*_a`, or from `coil_*_v` over `facility.coils.*.resistor_ohm`.
fn currents(document: &Document, recording: &Recording, rows: usize) -> Result<Vec<Vector3<f64>>, Error> {
    let mut currents = vec![Vector3::zeros(); rows];
    for axis in Axis::ALL {
        let (column, divisor) = match recording.axis_column("coil", axis, "a") {
            Some(column) => (column, 1.0),
            None => match recording.axis_column("coil", axis, "v") {
                Some(column) => (column, resistor(document, recording, axis)?),
                None => continue,
            },
        };
        for (current, value) in currents.iter_mut().zip(column) {
            current[axis.index()] = value / divisor;
        }
    }
    Ok(currents)
}

fn resistor(document: &Document, recording: &Recording, axis: Axis) -> Result<f64, Error> {
    let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
    let ohm = coils.and_then(|coils| coils.get(axis)).and_then(|coil| coil.resistor_ohm);
    ohm.filter(|ohm| ohm.is_finite() && *ohm > 0.0).ok_or_else(|| Error::Missing {
        recording: recording.id.clone(),
        who: format!("the drive `coil_{axis}_v`"),
        what: format!("the precision resistor, a positive number at `facility.coils.{axis}.resistor_ohm`"),
    })
}

/// `ambient_*_nt` (GEO) as columns, or as conditions that hold throughout.
fn ambient(recording: &Recording, rows: usize) -> Vec<Vector3<f64>> {
    let mut ambient = vec![Vector3::zeros(); rows];
    for axis in Axis::ALL {
        let name = format!("ambient_{axis}_nt");
        let constant = recording.conditions.extra.get(&name).and_then(|value| value.as_f64());
        let column = recording.column(&name);
        for (row, field) in ambient.iter_mut().enumerate() {
            field[axis.index()] = column.map_or(constant.unwrap_or(0.0), |column| column[row]);
        }
    }
    ambient
}

/// R of a recording, from its matrix or from its theodolites; absent: the block is aligned with GEO.
pub fn orientation(document: &Document, recording: &Recording) -> Result<Orientation, Error> {
    let conditions = &recording.conditions;
    let sigma =
        document.facility.as_ref().and_then(|facility| facility.theodolite_arcsec).map(|s| s * ARCSEC);
    match (&conditions.theodolite, &conditions.orientation) {
        (Some(angles), given) => {
            Orientation::from_theodolite(angles, angles.nominal_rotation.as_ref().or(given.as_ref()), sigma)
        }
        (None, Some(rows)) => Orientation::from_matrix(rows, sigma),
        (None, None) => Ok(Orientation {
            rotation: Matrix3::identity(),
            uncertainty: Matrix3::identity() * sigma.unwrap_or(0.0),
            moved_rad: 0.0,
        }),
    }
}
