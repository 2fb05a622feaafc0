//! The readings of a theodolite and of the variometer beside it.

use common::number::{bare, quoted, significant};
use common::{Axis, Document, Error, Recording, procedure};
use nalgebra::Vector3;
use physics::Components;
use std::f64::consts::{FRAC_PI_2, PI};

/// Telescope readings whose zenith angle is nearer to the horizon than this, with the circle read, may be those
/// of the declination, rad.
const LEVEL: f64 = 0.035;
/// Rows of the variometer further apart than this do not say what the field was between them, s.
const LONGEST_STEP_S: f64 = 90.0;

/// The variometer: rows with all of what is used, in the order of time.
pub struct Variometer {
    pub components: Components,
    pub recordings: Vec<String>,
    /// Unix time, s.
    pub time_s: Vec<f64>,
    pub reading_nt: Vec<Vector3<f64>>,
    /// The scalar magnetometer beside it, NaN where it did not read.
    pub scalar_nt: Vec<f64>,
}

/// One row of a measurement.
#[derive(Clone, Debug)]
pub struct Row {
    /// Of the recording.
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
    Mark { horizontal: f64, above: bool },
    /// Of the field; where the horizontal circle was not read the azimuth from magnetic north that it should have had.
    Field { horizontal: Result<f64, f64>, zenith: f64, reading_nt: f64 },
    /// The scalar alone.
    None,
}

/// One measurement.
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

impl Variometer {
    /// Readings and scalar at a moment, on the line between its neighbours.
    pub fn at(&self, time_s: f64) -> Option<(Vector3<f64>, f64)> {
        let next = self.time_s.partition_point(|time| *time < time_s);
        if self.time_s.get(next) == Some(&time_s) {
            return Some((self.reading_nt[next], self.scalar_nt[next]));
        }
        let before = next.checked_sub(1)?;
        let (from, to) = (self.time_s[before], *self.time_s.get(next)?);
        if to - from > LONGEST_STEP_S {
            return None;
        }
        let share = (time_s - from) / (to - from);
        let scalar = self.scalar_nt[before] + share * (self.scalar_nt[next] - self.scalar_nt[before]);
        Some((self.reading_nt[before].lerp(&self.reading_nt[next], share), scalar))
    }
}

/// The variometer's recordings as one series.
///
/// Errors: recordings without a start, or along other components.
pub fn variometer(document: &Document) -> Result<Option<Variometer>, Error> {
    let mut found: Option<Variometer> = None;
    let mut rows: Vec<(f64, Vector3<f64>, f64)> = Vec::new();
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure != procedure::VARIOMETER {
            continue;
        }
        let path = format!("recordings[{index}]");
        recording.at_hand(&path)?;
        let Some(start) = recording.start() else {
            let expected = "the moment at which time_s is zero, such as 2026-11-30T00:00:00Z";
            return Err(Error::document(format!("{path}.start"), "none", expected));
        };
        let components = components(recording, &path)?;
        let all = found.get_or_insert_with(|| Variometer {
            components,
            recordings: Vec::new(),
            time_s: Vec::new(),
            reading_nt: Vec::new(),
            scalar_nt: Vec::new(),
        });
        if all.components != components {
            let stated = format!("\"{}\" after \"{}\"", components.name(), all.components.name());
            let expected = "one variometer in a document";
            return Err(Error::document(format!("{path}.conditions.components"), stated, expected));
        }
        all.recordings.push(recording.id.clone());
        let times = needed(recording, &path, "time_s")?;
        let readings = sensors(recording, &path)?;
        let scalar = recording.column("reference_nt");
        for row in 0..times.len() {
            let reading = readings.map(|column| column[row]);
            if times[row].is_finite() && reading.iter().all(|value| value.is_finite()) {
                let scalar = scalar.map_or(f64::NAN, |column| column[row]);
                rows.push((start.unix_s + times[row], Vector3::from(reading), scalar));
            }
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    if let Some(all) = &mut found {
        for (time, reading, scalar) in rows {
            all.time_s.push(time);
            all.reading_nt.push(reading);
            all.scalar_nt.push(scalar);
        }
    }
    Ok(found)
}

fn needed<'a>(recording: &'a Recording, path: &str, name: &str) -> Result<&'a [f64], Error> {
    recording.column(name).ok_or_else(|| {
        let expected = format!("{name}, which the procedure `{}` needs", recording.procedure);
        Error::document(format!("{path}.columns"), format!("no column {name}"), expected)
    })
}

fn sensors<'a>(recording: &'a Recording, path: &str) -> Result<[&'a [f64]; 3], Error> {
    let [x, y, z] = Axis::ALL.map(|axis| needed(recording, path, &format!("sensor_{axis}_nt")));
    Ok([x?, y?, z?])
}

fn components(recording: &Recording, path: &str) -> Result<Components, Error> {
    let Some(stated) = recording.conditions.extra.get("components") else { return Ok(Components::default()) };
    stated.as_str().and_then(Components::of).ok_or_else(|| {
        Error::document(
            format!("{path}.conditions.components"),
            stated.to_string(),
            "\"hez\", sensors along the magnetic meridian, across it and down, or \"xyz\", along geographic north, east and down",
        )
    })
}

/// The measurements, in the order of time.
///
/// Errors: what a measurement lacks; circles that none has.
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
    Ok(sets)
}

/// Mean time of the readings of the field, Unix, s.
pub fn time(set: &Set) -> f64 {
    let times = set.rows.iter().filter(|row| matches!(row.circle, Circle::Field { .. }));
    let times: Vec<f64> = times.map(|row| row.time_s).filter(|time| time.is_finite()).collect();
    times.iter().sum::<f64>() / times.len() as f64
}

fn set(recording: &Recording, path: String, variometer: Option<&Variometer>) -> Result<Set, Error> {
    let angle = |name: &str, row: usize| -> Result<f64, Error> {
        let degrees = recording.column(name).map_or(f64::NAN, |column| column[row]);
        if degrees.is_nan() || (-360.0..=360.0).contains(&degrees) {
            return Ok(degrees.to_radians());
        }
        let expected =
            "degrees from 0 to 360; a circle in grades (gon) has 400: multiply its readings by 0.9";
        Err(Error::document(format!("{path}.columns.{name}[{row}]"), quoted(degrees), expected))
    };
    let residual = needed(recording, &path, "residual_nt")?;
    needed(recording, &path, "vertical_deg")?;
    let own = sensors(recording, &path).ok();
    let own_components = own.map(|_| components(recording, &path)).transpose()?;
    let start_s = recording.start().map_or(f64::NAN, |start| start.unix_s);
    let mut rows = Vec::new();
    let mut without_variometer = Vec::new();
    for row in 0..recording.rows() {
        let time_s = start_s + recording.column("time_s").map_or(f64::NAN, |times| times[row]);
        let (horizontal, zenith) = (angle("horizontal_deg", row)?, angle("vertical_deg", row)?);
        let direction = angle("direction_deg", row)?;
        let circle = if residual[row].is_nan() {
            match (horizontal.is_nan(), zenith.is_nan()) {
                (true, _) => Circle::None,
                (false, true) => {
                    let expected = "90 with the magnetometer above the telescope, 270 with it below: the collimation of the telescope has the other sign then";
                    return Err(Error::document(
                        format!("{path}.columns.vertical_deg[{row}]"),
                        "null in a reading of the mark",
                        expected,
                    ));
                }
                _ => Circle::Mark { horizontal, above: zenith.sin() > 0.0 },
            }
        } else {
            let (horizontal, missing) = match (horizontal.is_nan(), direction.is_nan()) {
                (false, _) => (Ok(horizontal), "vertical_deg"),
                // Beyond 180° of zenith angle the view is opposite to the circle.
                (true, false) => (Err(direction + if zenith.sin() < 0.0 { PI } else { 0.0 }), "vertical_deg"),
                (true, true) => (Ok(horizontal), "horizontal_deg"),
            };
            if zenith.is_nan() || matches!(horizontal, Ok(angle) if angle.is_nan()) {
                let expected = "the circle of this reading; without the horizontal circle give `direction_deg`, 0 where the telescope looked to magnetic north and 180 to the south";
                return Err(Error::document(format!("{path}.columns.{missing}[{row}]"), "null", expected));
            }
            Circle::Field { horizontal, zenith, reading_nt: residual[row] }
        };
        let scalar =
            recording.column("reference_nt").map(|column| column[row]).filter(|value| value.is_finite());
        let in_sheet = own.map(|columns| Vector3::from(columns.map(|column| column[row])));
        let (variometer_nt, beside) = match (in_sheet, variometer) {
            (Some(reading), _) => {
                (Some(reading).filter(|reading| reading.iter().all(|v| v.is_finite())), f64::NAN)
            }
            (None, Some(variometer)) => match variometer.at(time_s) {
                Some((reading, scalar)) => (Some(reading), scalar),
                None => (None, f64::NAN),
            },
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
            rows.push(Row {
                row,
                time_s,
                circle,
                variometer_nt: variometer_nt.unwrap_or_default(),
                scalar_nt,
            });
        }
    }
    if rows.iter().any(|row| row.scalar_nt.is_some() && matches!(row.circle, Circle::None)) {
        // F was read at the theodolite's pillar: that beside the variometer is not used as well.
        let of_sheet =
            |row: &Row| recording.column("reference_nt").is_some_and(|column| column[row.row].is_finite());
        rows.iter_mut().filter(|row| !of_sheet(row)).for_each(|row| row.scalar_nt = None);
    }
    let stated = |name: &str| recording.conditions.quantity(name);
    let azimuth = stated("mark_azimuth_deg");
    if azimuth.is_none() {
        let expected = "the azimuth of the mark from geographic north towards east, degrees, a number or {\"value\", \"std\"}";
        return Err(Error::document(format!("{path}.conditions.mark_azimuth_deg"), "none", expected));
    }
    let both = |quantity: Option<common::Quantity>| {
        quantity.map_or([0.0; 2], |quantity| [quantity.value(), quantity.std().unwrap_or(0.0)])
    };
    Ok(Set {
        id: recording.id.clone(),
        azimuth: both(azimuth).map(f64::to_radians),
        pillar: both(stated("pillar_difference_nt")),
        components: own_components.or(variometer.map(|variometer| variometer.components)),
        rows,
        path,
        without_variometer,
    })
}

impl Row {
    /// The position of the telescope, in words, at a declination on the circle.
    pub fn position(&self, magnetic_north: f64) -> String {
        match self.circle {
            Circle::Mark { above, .. } => format!("mark {}", face(above)),
            Circle::Field { horizontal, zenith, .. } => {
                let turned = if zenith.sin() > 0.0 { 0.0 } else { PI };
                let view =
                    horizontal.map_or_else(|direction| direction, |angle| angle - magnetic_north) + turned;
                let quarter = (view / FRAC_PI_2).round().rem_euclid(4.0) as usize;
                format!("{} {}", ["north", "east", "south", "west"][quarter], face(zenith.sin() > 0.0))
            }
            Circle::None => "scalar".into(),
        }
    }

    /// Whether the telescope was level and its circle read.
    pub fn is_level(&self) -> bool {
        matches!(self.circle, Circle::Field { horizontal: Ok(_), zenith, .. } if zenith.cos().abs() < LEVEL)
    }
}

fn face(above: bool) -> &'static str {
    if above { "up" } else { "down" }
}

/// What is said of readings at which the variometer was silent.
pub fn silent(set: &Set) -> Option<String> {
    let first = set.without_variometer.first()?;
    Some(format!(
        "{} of \"{}\" without a reading of the variometer within {} s, left out, the first in row {}",
        common::number::counted(set.without_variometer.len(), "reading"),
        set.id,
        significant(LONGEST_STEP_S, 2),
        bare(*first as f64)
    ))
}
