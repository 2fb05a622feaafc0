//! The variometer and the scalar magnetometer beside the theodolite, as series of the whole document.

use common::{Axis, Document, Error, Recording, procedure};
use nalgebra::Vector3;
use physics::Components;
use std::ops::{Add, Mul, Sub};

/// Rows further apart than this do not say what the field was between them, s.
pub const LONGEST_STEP_S: f64 = 90.0;

pub struct Variometer {
    pub components: Components,
    pub recordings: Vec<String>,
    pub reading_nt: Series<Vector3<f64>>,
    pub scalar_nt: Series<f64>,
}

/// Values in the order of their Unix times, s.
pub struct Series<T>(Vec<(f64, T)>);

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Series<T> {
    pub fn of(mut rows: Vec<(f64, T)>) -> Self {
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(rows)
    }

    /// The value at a moment, on the line between its neighbours; None where they are further apart than this, s.
    pub fn at(&self, time_s: f64, longest_s: f64) -> Option<T> {
        let next = self.0.partition_point(|(time, _)| *time < time_s);
        let (to, after) = *self.0.get(next)?;
        if to == time_s {
            return Some(after);
        }
        let (from, before) = self.0[next.checked_sub(1)?];
        let share = (time_s - from) / (to - from);
        (to - from <= longest_s).then(|| before + (after - before) * share)
    }
}

/// All recordings of the procedure `variometer`; None where none has three sensors.
/// Errors: recordings without a start, or along other components.
pub fn variometer(document: &Document) -> Result<Option<Variometer>, Error> {
    let (mut readings, mut scalars, mut recordings) = (Vec::new(), Vec::new(), Vec::new());
    let mut along: Option<Components> = None;
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
        let times = needed(recording, &path, "time_s")?;
        let scalar = recording.column("reference_nt");
        let at = |row: usize| start.unix_s + times[row];
        let there = |row: &usize| times[*row].is_finite();
        if let Some(scalar) = scalar {
            let rows = (0..times.len()).filter(there).filter(|row| scalar[*row].is_finite());
            scalars.extend(rows.map(|row| (at(row), scalar[row])));
        }
        let is_scalar = scalar.is_some() && !recording.columns.keys().any(|name| name.starts_with("sensor_"));
        if is_scalar {
            continue;
        }
        let components = components(recording, &path)?;
        if let Some(other) = along.filter(|other| *other != components) {
            let stated = format!("\"{}\" after \"{}\"", components.name(), other.name());
            let expected = "one variometer in a document";
            return Err(Error::document(format!("{path}.conditions.components"), stated, expected));
        }
        along = Some(components);
        recordings.push(recording.id.clone());
        let columns = sensors(recording, &path)?;
        for row in (0..times.len()).filter(there) {
            let reading = Vector3::from(columns.map(|column| column[row]));
            if reading.iter().all(|value| value.is_finite()) {
                readings.push((at(row), reading));
            }
        }
    }
    let (reading_nt, scalar_nt) = (Series::of(readings), Series::of(scalars));
    Ok(along.map(|components| Variometer { components, recordings, reading_nt, scalar_nt }))
}

/// A column that the procedure needs. Errors: there is none.
pub fn needed<'a>(recording: &'a Recording, path: &str, name: &str) -> Result<&'a [f64], Error> {
    recording.column(name).ok_or_else(|| {
        let expected = format!("{name}, which the procedure `{}` needs", recording.procedure);
        Error::document(format!("{path}.columns"), format!("no column {name}"), expected)
    })
}

/// The columns of three sensors in nT. Errors: one is missing.
pub fn sensors<'a>(recording: &'a Recording, path: &str) -> Result<[&'a [f64]; 3], Error> {
    let [x, y, z] = Axis::ALL.map(|axis| needed(recording, path, &format!("sensor_{axis}_nt")));
    Ok([x?, y?, z?])
}

/// What the sensors are along, as the conditions say. Errors: a name that is none.
pub fn components(recording: &Recording, path: &str) -> Result<Components, Error> {
    let Some(stated) = recording.conditions.extra.get("components") else { return Ok(Components::default()) };
    stated.as_str().and_then(Components::of).ok_or_else(|| {
        let expected = "\"hez\", sensors along the magnetic meridian, across it and down, or \"xyz\", along geographic north, east and down";
        Error::document(format!("{path}.conditions.components"), stated.to_string(), expected)
    })
}
