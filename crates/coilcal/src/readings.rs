//! The readings of one coil, with what is wrong told by row.

use crate::Result;
use common::number::plural;
use common::range::{SCALAR_MARGIN, SCALAR_NT};
use common::{Axis, Document, Error, Recording, procedure};

pub struct Readings {
    pub coil: Axis,
    pub recordings: Vec<String>,
    /// Readings by time where each recording says when it began, else as they are listed.
    pub readings: Vec<Reading>,
    /// Whether the drive was read as a voltage.
    pub volts: bool,
}

#[derive(Clone, Copy, Debug)]
pub struct Reading {
    pub current_a: f64,
    /// Field along the coil, with the sign of the current, nT.
    pub field_nt: f64,
    /// When, s; the number of the reading where there are no times.
    pub time_s: f64,
}

/// The readings of a coil; None without a recording of it.
pub fn read(document: &Document, coil: Axis) -> Result<Option<Readings>> {
    let mut all = Readings { coil, recordings: Vec::new(), readings: Vec::new(), volts: false };
    let mut dated = true;
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure != procedure::COIL_CONSTANT {
            continue;
        }
        let path = format!("recordings[{index}]");
        let Some(of) = recording.conditions.coil else {
            let expected = "\"x\", \"y\" or \"z\", the coil that is driven";
            return Err(Error::document(format!("{path}.conditions.coil"), "no such key", expected));
        };
        if of == coil {
            one(document, recording, &path, &mut all)?;
            dated &= recording.start().is_some() && recording.column("time_s").is_some();
        }
    }
    if dated {
        all.readings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    }
    Ok((!all.recordings.is_empty()).then_some(all))
}

fn one(document: &Document, recording: &Recording, path: &str, all: &mut Readings) -> Result<()> {
    recording.at_hand(path)?;
    let (drive, volts) = drive(document, recording, all.coil, path)?;
    let Some(reference) = recording.column("reference_nt") else {
        let expected = "`reference_nt`, the readings of the scalar magnetometer";
        return Err(Error::document(format!("{path}.columns"), "no such column", expected));
    };
    check(document, reference, path)?;
    let time = recording.column("time_s").filter(|time| time.iter().all(|t| t.is_finite()));
    let start = recording.start().map_or(0.0, |start| start.unix_s);
    for (row, (current, field)) in drive.iter().zip(reference).enumerate() {
        if current.is_finite() && field.is_finite() && *current != 0.0 {
            let time_s = time.map_or(all.readings.len() as f64, |time| start + time[row]);
            all.readings.push(Reading { current_a: *current, field_nt: field * current.signum(), time_s });
        }
    }
    all.volts |= volts;
    all.recordings.push(recording.id.clone());
    Ok(())
}

/// The current, from its column or from the voltage over the resistor.
pub fn drive(document: &Document, recording: &Recording, coil: Axis, path: &str) -> Result<(Vec<f64>, bool)> {
    if let Some(current) = recording.axis_column("coil", coil, "a") {
        return Ok((current.to_vec(), false));
    }
    let Some(volts) = recording.axis_column("coil", coil, "v") else {
        let expected = format!("`coil_{coil}_a`, or `coil_{coil}_v` across the precision resistor");
        return Err(Error::document(format!("{path}.columns"), format!("no drive of coil {coil}"), expected));
    };
    let key = format!("facility.coils.{coil}.resistor_ohm");
    let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
    match coils.and_then(|coils| coils.get(coil)?.resistor_ohm) {
        Some(ohm) if ohm.is_finite() && ohm > 0.0 => Ok((volts.iter().map(|v| v / ohm).collect(), true)),
        Some(ohm) => Err(Error::document(key, ohm.to_string(), "a positive resistance")),
        None => {
            let expected = "the precision resistor across which the voltage was measured";
            Err(Error::document(key, "no such key", expected))
        }
    }
}

/// Fields that a scalar magnetometer can have read.
pub fn check(document: &Document, reference: &[f64], path: &str) -> Result<()> {
    let column = format!("{path}.columns.reference_nt");
    if let Some(row) = reference.iter().position(|field| *field < 0.0) {
        let found = format!("{} nT in row {row}", reference[row]);
        return Err(Error::document(column, found, "the field's magnitude, which is never negative"));
    }
    let stated = document.facility.as_ref().and_then(|facility| facility.reference_range_nt);
    let [low, high] = stated.unwrap_or(SCALAR_NT);
    let outside = |field: &f64| *field < low * (1.0 - SCALAR_MARGIN) || *field > high * (1.0 + SCALAR_MARGIN);
    let rows = reference.iter().enumerate().filter(|(_, field)| outside(field));
    let rows: Vec<String> = rows.map(|(row, _)| row.to_string()).collect();
    if rows.is_empty() {
        return Ok(());
    }
    let shown = rows.iter().take(10).cloned().collect::<Vec<_>>().join(", ");
    let more = if rows.len() > 10 { format!(" and {} more", rows.len() - 10) } else { String::new() };
    let rows = plural(rows.len(), "row", "rows");
    let found = format!("fields outside the scalar magnetometer's range in {rows} {shown}{more}");
    let expected = format!("{low} to {high} nT; remove the rows, or state `facility.reference_range_nt`");
    Err(Error::document(column, found, expected))
}
