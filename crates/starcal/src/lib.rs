//! Calibration in flight: a vector magnetometer beside star cameras, in a field that a model gives.
//!
//! A star camera tells how its head is turned, a model what the field is; the sensors read that field along their axes.
//! Scale factors, offsets, the angles between the sensors and those between sensors and heads are found together, with
//! what adds to them: temperatures, time, currents, the Sun.
//!
//! - `layout` says which columns are used, `field` gives the field of a row, `taking` makes products of the rows, which
//!   `partial` keeps by windows of time. All that follows works on these products.
//! - `fit` is the least squares, `terms` are the parameters that it may have, `choose` takes those for which the evidence
//!   is, `heads` applies them to the sensors and the first camera, and to the other cameras against the first. `axes` takes
//!   sensors and camera out of the coefficients, `result` writes all. `mistakes` knows wrong attitudes.
//!
//! Source: N. Olsen et al., Calibration of the Ørsted vector magnetometer, Earth Planets Space 55 (2003) 11–18.

mod axes;
mod choose;
mod field;
mod fit;
mod heads;
mod layout;
mod mistakes;
mod partial;
mod result;
mod taking;
mod terms;
mod values;
mod words;

pub use self::partial::Partial;
pub use common::Error;
pub use taking::Columns;
pub use words::summary;

use ::partial::{Series, Take, merge};
use common::{Code, Document, Findings, Recording, procedure};
use physics::{Basic, Unit};

use crate::fit::Flight;

/// The procedure that is read.
pub const PROCEDURES: [&str; 1] = [procedure::FREE_RUN];

/// Finds the calibration by the recordings of a document that have a star camera.
/// Errors: no such recording; rows that do not determine it, or attitudes that do not fit, with the remedy.
pub fn run(document: Document, columns: &Columns) -> Result<Document, Error> {
    let (mut pieces, mut ids) = (Vec::new(), Vec::new());
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure != procedure::FREE_RUN {
            continue;
        }
        let path = format!("recordings[{index}]");
        recording.at_hand(&path)?;
        if columns.of_recording(recording, &path)?.is_some() {
            pieces.push(piece(recording, &path, columns)?);
            ids.push(recording.id.clone());
        }
    }
    if pieces.is_empty() {
        return Err(Error::Request("no recording with the procedure `free_run` and the attitude by a star camera; it needs time_s, sensor_x_nt, …, camera_1_w, camera_1_x, camera_1_y, camera_1_z, and the field or the place".into()));
    }
    let joined = merge(pieces).map_err(Into::<Error>::into)?;
    let mut document = answer(&joined, document)?;
    let flight = document.calibration.as_mut().and_then(|calibration| calibration.flight.as_mut());
    flight.into_iter().for_each(|flight| flight.recordings = ids.clone());
    Ok(document)
}

fn piece(recording: &Recording, path: &str, columns: &Columns) -> Result<Partial, Error> {
    // A column without any value says nothing.
    let known = |name: &&String| {
        let values = recording.column(name).unwrap_or_default();
        name.starts_with("camera_") || values.iter().any(|value| value.is_finite())
    };
    let there: Vec<String> = recording.columns.keys().filter(known).cloned().collect();
    let columns = columns.of_recording(recording, path)?.unwrap_or_else(|| columns.clone());
    let (names, mut taking) = columns
        .begin(&there)
        .map_err(|missing| Error::document(format!("{path}.columns"), there.join(", "), missing))?;
    let start_s = recording.start().map_or(0.0, |start| start.unix_s);
    let mut values: Vec<&[f64]> = names.iter().filter_map(|name| recording.column(name)).collect();
    let times: Vec<f64> = values[0].iter().map(|time| start_s + time).collect();
    values[0] = &times;
    taking.push(&values).and_then(|()| taking.finish()).map_err(|error| match error {
        self::partial::Error::NoField { row, found, expected } => {
            Error::document(format!("{path}.columns.time_s[{row}]"), found, expected)
        }
        error => Error::document(path, error.to_string(), "rows of rising times"),
    })
}

/// The calibration by what was kept of a flight, written into a document. Errors: as [`run`].
pub fn answer(partial: &Partial, mut document: Document) -> Result<Document, Error> {
    mistakes::check(partial)?;
    if let Some(model) = &mut document.model {
        // What was found before is found anew.
        model.effects.retain(|effect| effect.extra.get("found_by").is_none_or(|by| by != "starcal"));
        if let Some(effect) = model.effects.first() {
            let expected =
                "no effects but those that starcal found, as it cannot subtract others; leave them out";
            return Err(Error::document("model.effects", format!("\"{}\"", effect.effect), expected));
        }
    }
    let stated = Basic::found(&document, Unit::Nanotesla).mu;
    let flight = Flight::of(partial, 0);
    let first = heads::first(&flight, &partial.layout, &stated)?;
    let (mut others, mut findings) = (Vec::new(), Findings::default());
    for camera in 1..partial.layout.cameras.len() {
        let flight = Flight::of(partial, camera);
        match heads::head(&flight, &partial.layout, camera) {
            Ok(head) => others.push((flight, head)),
            Err(why) => {
                let number = partial.layout.cameras[camera];
                findings.push(Code::NotDetermined.said(format!("camera_{number} is left out: {why}")));
            }
        }
    }
    result::put(&mut document, partial, (&flight, &first), &others, (&stated, findings))?;
    Ok(document)
}
