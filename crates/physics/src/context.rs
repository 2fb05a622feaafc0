//! What a recording says besides its readings: times, drive, temperatures, orientation.

use common::number::bare;
use common::{Axis, Document, Instrument, Quantity, Recording, procedure};
use nalgebra::{Matrix3, Vector3};
use std::borrow::Cow;

use crate::frames::{ARCSEC, Orientation};
use crate::memory::{bridged, held};
use crate::{Error, Real};

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

    /// Width of one code of the converter in this unit, as the instrument states it.
    pub fn code_width(self, instrument: Option<&Instrument>) -> Option<f64> {
        match self {
            Unit::Volt => instrument?.quantisation_v,
            Unit::Nanotesla => instrument?.quantisation_nt,
        }
    }
}

/// 0 degC in K.
pub const KELVIN: f64 = 273.15;

/// Whose temperature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Thermometer {
    /// Of the sensors.
    Sensor,
    /// Of the electronics.
    Electronics,
    /// Of the coils.
    Coil,
}

impl Thermometer {
    /// All of them.
    pub const ALL: [Thermometer; 3] = [Thermometer::Sensor, Thermometer::Electronics, Thermometer::Coil];

    /// Name of its column.
    pub const fn column(self) -> &'static str {
        match self {
            Thermometer::Sensor => "sensor_temperature_c",
            Thermometer::Electronics => "electronics_temperature_c",
            Thermometer::Coil => "coil_temperature_c",
        }
    }
}

/// What a whole document has in common: the temperatures at which the constants hold, degC, the field outside from which
/// its variations count, and its zero of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct References {
    /// Of the sensors.
    pub sensor_c: Option<f64>,
    /// Of the electronics.
    pub electronics_c: Option<f64>,
    /// Of the coils.
    pub coil_c: Option<f64>,
    /// Of the station outside, GEO, nT.
    pub outside_nt: [Option<f64>; 3],
    /// The campaign's beginning: the earliest `start` of the document, seconds since 1970.
    pub beginning_s: Option<f64>,
}

impl References {
    /// As `calibration.reference_conditions` states them.
    pub fn stated(document: &Document) -> Self {
        let stated = document.calibration.as_ref().and_then(|c| c.reference_conditions.as_ref());
        Self {
            sensor_c: stated.and_then(|stated| stated.sensor_temperature_c),
            electronics_c: stated.and_then(|stated| stated.electronics_temperature_c),
            coil_c: stated.and_then(|stated| stated.coil_temperature_c),
            outside_nt: stated.map_or([None; 3], |s| [s.outside_x_nt, s.outside_y_nt, s.outside_z_nt]),
            beginning_s: beginning(document),
        }
    }

    /// As stated, else the mean of all recordings: for a stage that finds constants and coefficients, which
    /// hold there. It writes them down then ([`crate::state_references`]).
    pub fn of(document: &Document) -> Self {
        let stated = Self::stated(document);
        let mean = |name: &str| {
            let columns = document.recordings.iter().filter_map(|recording| series(recording, name));
            finite_mean(columns.flat_map(Cow::into_owned))
        };
        let temperature = |which: Thermometer| mean(which.column());
        let outside = |axis: Axis| mean(&format!("outside_{axis}_nt"));
        Self {
            sensor_c: stated.sensor_c.or_else(|| temperature(Thermometer::Sensor)),
            electronics_c: stated.electronics_c.or_else(|| temperature(Thermometer::Electronics)),
            coil_c: stated.coil_c.or_else(|| temperature(Thermometer::Coil)),
            outside_nt: Axis::ALL.map(|axis| stated.outside_nt[axis.index()].or_else(|| outside(axis))),
            ..stated
        }
    }

    /// The reference of a thermometer, degC.
    pub fn temperature_c(&self, which: Thermometer) -> Option<f64> {
        match which {
            Thermometer::Sensor => self.sensor_c,
            Thermometer::Electronics => self.electronics_c,
            Thermometer::Coil => self.coil_c,
        }
    }
}

/// The mean of those values that are there.
pub(crate) fn finite_mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let known = values.filter(|value| value.is_finite());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    (count > 0.0).then(|| sum / count)
}

/// One recording as the chain sees it.
#[derive(Clone, Debug)]
pub struct Context<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Number of rows.
    pub rows: usize,
    /// Current in the coils x, y, z, A; zero without a column, NaN where a reading is missing.
    pub current_a: Vec<Vector3<f64>>,
    /// Whether coil offsets act: it has a column of drive, or is a nulling residual.
    pub in_coils: bool,
    /// Rows in which the drive is held; see [`held`].
    pub held: Vec<bool>,
    /// Field besides the coils', GEO, nT: for each row, or one that holds throughout.
    pub ambient_nt: Vec<Vector3<f64>>,
    /// R, GEO -> SEN, where it holds throughout.
    pub orientation: Orientation,
    /// R for each row, where the attitude changes; else empty.
    pub attitude: Vec<Matrix3<f64>>,
    /// Differential recordings: what the reference reads, which stands in place of the field in SEN.
    pub reference_nt: Option<Vec<Vector3<f64>>>,
    /// Noise of the readings as field along each sensor, where it is simulated; else empty, nT.
    pub noise_nt: Vec<Vector3<f64>>,
    /// Unit of the readings.
    pub unit: Unit,
    /// Reference temperatures.
    pub references: References,
    /// The recording's zero of time on the campaign's clock, s.
    pub clock_s: f64,
    /// `start` on the clock of its own offset, seconds since 1970.
    pub local_start_s: Option<f64>,
    /// Places of the sensors in SEN, m.
    pub positions_m: Option<[Vector3<f64>; 3]>,
    /// Gradients of the coils along their axes, nT/(m A); zero where not stated.
    pub gradient_nt_per_m_a: Vector3<f64>,
}

impl<'a> Context<'a> {
    /// Reads a recording of a document.
    pub fn new(document: &Document, recording: &'a Recording, references: References) -> Result<Self, Error> {
        let rows = recording.rows();
        let has = |unit: Unit| {
            Axis::ALL.iter().any(|a| recording.axis_column("sensor", *a, unit.suffix()).is_some())
        };
        let start = recording.start();
        let positions = document.instrument.as_ref().and_then(|instrument| instrument.positions_m.as_ref());
        let current_a = currents(document, recording, rows)?;
        let held = match recording.column("time_s") {
            Some(time) => {
                held(time, current_a.iter().map(|current| current.data.0[0]).collect::<Vec<_>>().as_slice())
            }
            None => Vec::new(),
        };
        Ok(Self {
            recording,
            rows,
            current_a,
            held,
            in_coils: recording.procedure == procedure::NULLING_RESIDUAL
                || recording.columns.keys().any(|name| is_drive(name)),
            ambient_nt: ambient(recording, rows),
            orientation: orientation(document, recording)?,
            attitude: attitude(recording)?,
            reference_nt: (recording.procedure == procedure::DIFFERENTIAL)
                .then(|| reference(recording, rows)),
            noise_nt: Vec::new(),
            unit: if has(Unit::Nanotesla) && !has(Unit::Volt) { Unit::Nanotesla } else { Unit::Volt },
            references,
            clock_s: start.map_or(0.0, |start| start.unix_s - references.beginning_s.unwrap_or(start.unix_s)),
            local_start_s: start.map(|start| start.local_s()),
            positions_m: positions.map(|positions| {
                Axis::ALL.map(|axis| positions.get(axis).map_or_else(Vector3::zeros, |p| Vector3::from(*p)))
            }),
            gradient_nt_per_m_a: gradients(document),
        })
    }

    /// The times, which an effect with memory needs: all there, never running backwards.
    pub fn times(&self, who: &str) -> Result<&'a [f64], Error> {
        let times =
            self.recording.column("time_s").ok_or_else(|| self.missing(who, "the column `time_s`"))?;
        let faulty = |pair: &[f64]| pair.iter().any(|t| !t.is_finite()) || pair[1] < pair[0];
        let fault = times.windows(2).position(faulty);
        match fault.or((times.len() == 1 && !times[0].is_finite()).then_some(0)) {
            Some(row) => Err(self.missing(
                who,
                &format!("times that do not run backwards; after row {row} `time_s` is missing or falls"),
            )),
            None => Ok(times),
        }
    }

    /// The times on the campaign's clock, s; recordings without `start` are on that clock already.
    pub fn clock(&self, who: &str) -> Result<Vec<f64>, Error> {
        Ok(self.times(who)?.iter().map(|t| t + self.clock_s).collect())
    }

    /// A temperature and its reference, degC.
    pub fn temperature(&self, which: Thermometer, who: &str) -> Result<(Cow<'a, [f64]>, f64), Error> {
        let column = self.column(which.column(), who)?;
        let reference = self.references.temperature_c(which);
        Ok((column, reference.ok_or_else(|| self.missing(who, "a reference temperature"))?))
    }

    /// A column that `who` cannot do without, or the condition of that name, which holds throughout.
    pub fn column(&self, name: &str, who: &str) -> Result<Cow<'a, [f64]>, Error> {
        self.optional(name).ok_or_else(|| self.missing(who, &format!("the column `{name}`")))
    }

    /// A column or condition, where there is one; missing samples are bridged where times are known.
    pub fn optional(&self, name: &str) -> Option<Cow<'a, [f64]>> {
        let series = series(self.recording, name)?;
        match self.recording.column("time_s") {
            Some(time) if series.iter().any(|value| value.is_nan()) && time.iter().all(|t| t.is_finite()) => {
                Some(Cow::Owned(bridged(time, series.into_owned())))
            }
            _ => Some(series),
        }
    }

    /// The sum of the sizes of the coil currents in each row, A.
    pub fn coils_a(&self) -> impl Iterator<Item = f64> {
        self.current_a.iter().map(|current| current.abs().sum())
    }

    /// R of a row.
    pub fn rotation(&self, row: usize) -> Matrix3<f64> {
        self.attitude.get(row).copied().unwrap_or(self.orientation.rotation)
    }

    /// The field besides the coils' in a row, GEO, nT.
    pub fn ambient(&self, row: usize) -> Vector3<f64> {
        match self.ambient_nt.as_slice() {
            [throughout] => *throughout,
            rows => rows[row],
        }
    }

    /// An angle from its column in rad or in deg, rad.
    pub fn angle(&self, name: &str) -> Option<Cow<'a, [f64]>> {
        self.optional(&format!("{name}_rad")).or_else(|| {
            let degrees = self.optional(&format!("{name}_deg"))?;
            Some(Cow::Owned(degrees.iter().map(|angle| angle.to_radians()).collect()))
        })
    }

    /// What means over `conditions.integration_s` leave of a wave: sin(πfw)/(πfw).
    pub(crate) fn averaged<T: Real>(&self, frequency_hz: T) -> T {
        match self.recording.conditions.integration_s {
            Some(width) if width > 0.0 && frequency_hz.re() != 0.0 => {
                let angle = frequency_hz * (std::f64::consts::PI * width);
                angle.sin() / angle
            }
            _ => T::from(1.0),
        }
    }

    /// The error that `who` lacks `what`.
    pub fn missing(&self, who: &str, what: &str) -> Error {
        Error::Missing { recording: self.recording.id.clone(), who: who.into(), what: what.into() }
    }
}

/// A column, or the condition of that name in every row.
fn series<'a>(recording: &'a Recording, name: &str) -> Option<Cow<'a, [f64]>> {
    recording.column(name).map(Cow::Borrowed).or_else(|| {
        let value = recording.conditions.extra.get(name)?.as_f64()?;
        Some(Cow::Owned(vec![value; recording.rows()]))
    })
}

/// The earliest `start`, seconds since 1970: the zero of the campaign's clock.
fn beginning(document: &Document) -> Option<f64> {
    document
        .recordings
        .iter()
        .filter_map(|recording| recording.start())
        .map(|start| start.unix_s)
        .reduce(f64::min)
}

fn gradients(document: &Document) -> Vector3<f64> {
    let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
    let gradient = |axis| coils?.get(axis)?.gradient_nt_per_m_a.as_ref().map(Quantity::value);
    Vector3::from(Axis::ALL.map(|axis| gradient(axis).unwrap_or(0.0)))
}

/// R for each row from `attitude_{w,x,y,z}`, a unit quaternion GEO -> SEN; empty without such columns.
fn attitude(recording: &Recording) -> Result<Vec<Matrix3<f64>>, Error> {
    let column = |part: &str| recording.column(&format!("attitude_{part}"));
    let (Some(w), Some(x), Some(y), Some(z)) = (column("w"), column("x"), column("y"), column("z")) else {
        return Ok(Vec::new());
    };
    let rotation = |row: usize| {
        let parts = [w[row], x[row], y[row], z[row]];
        // A row without an attitude has none in what follows.
        let size = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
        if !size.is_finite() {
            return Ok(Matrix3::from_element(f64::NAN));
        }
        crate::frames::attitude(parts).ok_or_else(|| Error::NotARotation {
            found: format!("an attitude of length {} in row {row} of \"{}\"", bare(size), recording.id),
            expected: "unit quaternions in attitude_{w,x,y,z}".into(),
        })
    };
    (0..recording.rows()).map(rotation).collect()
}

/// `reference_{x,y,z}_nt` of a differential recording; what is missing is NaN.
fn reference(recording: &Recording, rows: usize) -> Vec<Vector3<f64>> {
    let columns = Axis::ALL.map(|axis| recording.axis_column("reference", axis, "nt"));
    (0..rows).map(|row| Vector3::from(columns.map(|c| c.map_or(f64::NAN, |c| c[row])))).collect()
}

/// Whether a column is `coil_{x,y,z}_a` or `coil_{x,y,z}_v`.
fn is_drive(name: &str) -> bool {
    Axis::ALL.iter().any(|axis| name == format!("coil_{axis}_a") || name == format!("coil_{axis}_v"))
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

/// `ambient_*_nt` (GEO) as columns, or as conditions that hold throughout. In a reversal the field that holds
/// in position +1 is −1 times itself in position −1: turning the sensor is turning the field.
fn ambient(recording: &Recording, rows: usize) -> Vec<Vector3<f64>> {
    let columns = Axis::ALL.map(|axis| recording.axis_column("ambient", axis, "nt"));
    let constant = Axis::ALL.map(|axis| {
        let value = recording.conditions.extra.get(&format!("ambient_{axis}_nt"));
        value.and_then(|value| value.as_f64()).unwrap_or(0.0)
    });
    let reversal =
        [procedure::SENSOR_OFFSET_REVERSAL, procedure::OFFSET_DRIFT].contains(&recording.procedure.as_str());
    let position = recording.column("position").filter(|_| reversal);
    if position.is_none() && columns.iter().all(Option::is_none) {
        return vec![Vector3::from(constant)];
    }
    (0..rows)
        .map(|row| {
            let field = Vector3::from_fn(|k, _| columns[k].map_or(constant[k], |column| column[row]));
            field * position.map_or(1.0, |position| position[row])
        })
        .collect()
}

/// R of a recording, from its matrix or from its theodolites; absent: the block is aligned with GEO.
pub fn orientation(document: &Document, recording: &Recording) -> Result<Orientation, Error> {
    let conditions = &recording.conditions;
    let sigma = |readings: usize| {
        document.facility.as_ref()?.theodolite_std_arcsec(readings).map(|arcsec| arcsec * ARCSEC)
    };
    match (&conditions.theodolite, &conditions.orientation) {
        (Some(angles), given) => {
            Orientation::from_theodolite(angles, angles.nominal_rotation.as_ref().or(given.as_ref()), sigma)
        }
        (None, Some(rows)) => Orientation::from_matrix(rows, sigma(1)),
        (None, None) => Ok(Orientation {
            rotation: Matrix3::identity(),
            uncertainty: Matrix3::identity() * sigma(1).unwrap_or(0.0),
            moved_rad: 0.0,
        }),
    }
}
