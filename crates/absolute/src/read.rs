//! The readings of a theodolite and of the variometer beside it.

use common::number::{bare, counted, quoted, significant};
use common::time::Start;
use common::{Document, Error, Recording, procedure};
use nalgebra::Vector3;
use physics::Components;
use std::f64::consts::{FRAC_PI_2, PI};

use crate::variometer::{LONGEST_STEP_S, Variometer, components, needed, sensors};

/// Telescope readings whose zenith angle is nearer to the horizon than this, with the circle read, may be those
/// of the declination, rad.
const LEVEL: f64 = 0.035;

/// Measurements further apart than this are not of one baseline, s.
const LONGEST_S: f64 = 50.0 * 365.25 * 86_400.0;

#[derive(Clone, Debug)]
pub struct Row {
    pub row: usize,
    /// Unix time, s; NaN where it is not stated.
    pub time_s: f64,
    pub circle: Circle,
    /// The variometer then, nT; zero without one.
    pub variometer_nt: Vector3<f64>,
    /// The scalar magnetometer then, nT.
    pub scalar_nt: Option<f64>,
}

/// What was read of the circles, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Circle {
    /// Towards the mark, magnetometer above or below.
    Mark {
        horizontal: f64,
        above: bool,
    },
    Field {
        azimuth: Azimuth,
        zenith: f64,
        reading_nt: f64,
    },
    /// The scalar alone.
    None,
}

/// Where the horizontal circle stood, rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Azimuth {
    /// As it was read.
    Circle(f64),
    /// Where it was not read: from the magnetic meridian, as it should have stood.
    FromMeridian(f64),
}

impl Azimuth {
    /// From north, which the circle reads as `north`, at a declination.
    pub fn geographic(self, north: f64, declination: f64) -> f64 {
        match self {
            Self::Circle(circle) => circle - north,
            Self::FromMeridian(from) => from + declination,
        }
    }
}

impl Circle {
    pub fn is_level(&self) -> bool {
        matches!(self, Self::Field { azimuth: Azimuth::Circle(_), zenith, .. } if zenith.cos().abs() < LEVEL)
    }
}

pub struct Set {
    pub id: String,
    pub path: String,
    /// Azimuth of the mark, rad, and its standard uncertainty.
    pub azimuth: [f64; 2],
    /// F at the theodolite less F where the scalar magnetometer is, nT, and its standard uncertainty.
    pub pillar: [f64; 2],
    pub components: Option<Components>,
    pub rows: Vec<Row>,
    /// Rows of readings at which the variometer says nothing.
    pub without_variometer: Vec<usize>,
}

/// The measurements, in the order of time. Errors: what a measurement lacks; circles that none has.
pub fn sets(document: &Document, variometer: Option<&Variometer>) -> Result<Vec<Set>, Error> {
    let mut sets = Vec::new();
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure == procedure::ABSOLUTE {
            let path = format!("recordings[{index}]");
            recording.at_hand(&path)?;
            sets.push(set(recording, path, variometer)?);
        }
    }
    sets.sort_by(|a, b| time(a).total_cmp(&time(b)));
    if let [first, .., last] = &sets[..]
        && time(last) - time(first) > LONGEST_S
    {
        let middle = time(&sets[sets.len() / 2]);
        let odd = if middle - time(first) > time(last) - middle { first } else { last };
        let expected = "measurements within 50 years; check `start` and `time_s`";
        return Err(Error::document(&odd.path, format!("one of {}", moment(time(odd))), expected));
    }
    let components = |set: &Set| set.components.map_or("none", Components::name);
    if let Some(other) = sets.iter().find(|set| set.components != sets[0].components) {
        let found = format!("\"{}\" after \"{}\"", components(other), components(&sets[0]));
        let expected = "readings of one variometer, along the same components, in all measurements";
        return Err(Error::document(format!("{}.conditions.components", other.path), found, expected));
    }
    Ok(sets)
}

/// RFC 3339 to the second.
pub fn moment(unix_s: f64) -> String {
    Start { unix_s: unix_s.round(), offset_s: 0.0 }.text().unwrap_or_default()
}

/// Mean time of the readings of the field, Unix, s.
pub fn time(set: &Set) -> f64 {
    let times = set.rows.iter().filter(|row| matches!(row.circle, Circle::Field { .. }));
    let times: Vec<f64> = times.map(|row| row.time_s).filter(|time| time.is_finite()).collect();
    times.iter().sum::<f64>() / times.len() as f64
}

fn set(recording: &Recording, path: String, variometer: Option<&Variometer>) -> Result<Set, Error> {
    let residual = needed(recording, &path, "residual_nt")?;
    needed(recording, &path, "vertical_deg")?;
    let has_own = recording.columns.keys().any(|name| name.starts_with("sensor_") && name.ends_with("_nt"));
    let own = if has_own { Some(sensors(recording, &path)?) } else { None };
    let own_components = own.map(|_| components(recording, &path)).transpose()?;
    let start_s = recording.start().map_or(f64::NAN, |start| start.unix_s);
    let mut rows = Vec::new();
    let mut without_variometer = Vec::new();
    for row in 0..recording.rows() {
        let time_s = start_s + recording.column("time_s").map_or(f64::NAN, |times| times[row]);
        let circle = circle(recording, &path, row, residual[row])?;
        let scalar =
            recording.column("reference_nt").map(|column| column[row]).filter(|value| value.is_finite());
        let in_sheet = own.map(|columns| Vector3::from(columns.map(|column| column[row])));
        let (variometer_nt, beside) = match (in_sheet, variometer) {
            (Some(reading), _) => (Some(reading).filter(|one| one.iter().all(|v| v.is_finite())), f64::NAN),
            (None, Some(variometer)) => (
                variometer.reading_nt.at(time_s, LONGEST_STEP_S),
                variometer.scalar_nt.at(time_s, LONGEST_STEP_S).unwrap_or(f64::NAN),
            ),
            (None, None) => (Some(Vector3::zeros()), f64::NAN),
        };
        let is_field = matches!(circle, Circle::Field { .. });
        if variometer_nt.is_none() && is_field {
            without_variometer.push(row);
        }
        // A mark needs no variometer, the scalar alone says nothing without one.
        let used = match circle {
            Circle::Mark { .. } => true,
            Circle::Field { .. } => variometer_nt.is_some(),
            Circle::None => variometer_nt.is_some() && scalar.is_some(),
        };
        if used {
            // The scalar of the sheet stands before that beside the variometer.
            let scalar_nt = scalar.or(Some(beside).filter(|value| is_field && value.is_finite()));
            let scalar_nt = scalar_nt.filter(|_| variometer_nt.is_some());
            let variometer_nt = variometer_nt.unwrap_or_default();
            rows.push(Row { row, time_s, circle, variometer_nt, scalar_nt });
        }
    }
    if rows.iter().any(|row| row.scalar_nt.is_some() && matches!(row.circle, Circle::None)) {
        // F was read at the theodolite's pillar: that beside the variometer is not used as well.
        let of_sheet =
            |row: &Row| recording.column("reference_nt").is_some_and(|column| column[row.row].is_finite());
        rows.iter_mut().filter(|row| !of_sheet(row)).for_each(|row| row.scalar_nt = None);
    }
    let stated = |name: &str| recording.conditions.quantity(name, &path);
    let azimuth = stated("mark_azimuth_deg")?;
    if azimuth.is_none() {
        let expected = "the azimuth of the mark from geographic north towards east, degrees, a number or {\"value\", \"std\"}";
        return Err(Error::document(format!("{path}.conditions.mark_azimuth_deg"), "none", expected));
    }
    let both = |quantity: Option<common::Quantity>| {
        quantity.map_or([0.0; 2], |quantity| [quantity.value(), quantity.std().unwrap_or(0.0)])
    };
    let pillar = both(stated("pillar_difference_nt")?);
    let components = own_components.or(variometer.map(|variometer| variometer.components));
    let (id, azimuth) = (recording.id.clone(), both(azimuth).map(f64::to_radians));
    let set = Set { id, azimuth, pillar, components, rows, path, without_variometer };
    if own_components.is_some() && time(&set).is_nan() {
        let expected = "`start` and `time_s` of its readings: a baseline value holds at a moment";
        return Err(Error::document(set.path, "no times", expected));
    }
    Ok(set)
}

fn circle(recording: &Recording, path: &str, row: usize, reading_nt: f64) -> Result<Circle, Error> {
    let angle = |name: &str| -> Result<f64, Error> {
        let degrees = recording.column(name).map_or(f64::NAN, |column| column[row]);
        if degrees.is_nan() || (-360.0..=360.0).contains(&degrees) {
            return Ok(degrees.to_radians());
        }
        let expected =
            "degrees from −360 to 360; a circle in grades (gon) has 400: multiply its readings by 0.9";
        Err(Error::document(format!("{path}.columns.{name}[{row}]"), quoted(degrees), expected))
    };
    let (horizontal, zenith) = (angle("horizontal_deg")?, angle("vertical_deg")?);
    let direction = angle("direction_deg")?;
    let null = |name: &str, found: &str, expected: &str| {
        Err(Error::document(format!("{path}.columns.{name}[{row}]"), found, expected))
    };
    if reading_nt.is_nan() {
        return match (horizontal.is_nan(), zenith.is_nan()) {
            (true, _) => Ok(Circle::None),
            (false, true) => {
                let expected = "90 with the magnetometer above the telescope, 270 with it below: the collimation of the telescope has the other sign then";
                null("vertical_deg", "null in a reading of the mark", expected)
            }
            _ => Ok(Circle::Mark { horizontal, above: zenith.sin() > 0.0 }),
        };
    }
    if zenith.is_nan() {
        let expected = "the vertical circle of a reading of the magnetometer, as zenith angle";
        return null("vertical_deg", "null", expected);
    }
    let azimuth = match (horizontal.is_nan(), direction.is_nan()) {
        (false, _) => Azimuth::Circle(horizontal),
        // Beyond 180° of zenith angle the view is opposite to the circle.
        (true, false) => Azimuth::FromMeridian(direction + if zenith.sin() < 0.0 { PI } else { 0.0 }),
        (true, true) => {
            let expected = "the horizontal circle; where it was not read give `direction_deg`, 0 where the telescope looked to magnetic north and 180 where it looked south";
            return null("horizontal_deg", "null", expected);
        }
    };
    Ok(Circle::Field { azimuth, zenith, reading_nt })
}

impl Row {
    /// The position of the telescope, in words, at a declination on the circle.
    pub fn position(&self, magnetic_north: f64) -> String {
        match self.circle {
            Circle::Mark { above, .. } => format!("mark {}", face(above)),
            Circle::Field { azimuth, zenith, .. } => {
                let turned = if zenith.sin() > 0.0 { 0.0 } else { PI };
                let view = azimuth.geographic(magnetic_north, 0.0) + turned;
                let quarter = (view / FRAC_PI_2).round().rem_euclid(4.0) as usize;
                format!("{} {}", ["north", "east", "south", "west"][quarter], face(zenith.sin() > 0.0))
            }
            Circle::None => "scalar".into(),
        }
    }
}

fn face(above: bool) -> &'static str {
    if above { "up" } else { "down" }
}

/// What is said of readings at which the variometer was silent.
pub fn silent(set: &Set) -> Option<String> {
    let first = set.without_variometer.first()?;
    let (count, within) = (counted(set.without_variometer.len(), "reading"), significant(LONGEST_STEP_S, 2));
    let (id, first) = (&set.id, bare(*first as f64));
    Some(format!(
        "{count} of \"{id}\" without a reading of the variometer within {within} s, left out, the first in row {first}"
    ))
}
