//! Raw readings, a calibration and a model: the field, with the uncertainty of each sample.
//!
//! The forward chain of `physics` is run backwards, and its derivatives by everything that is known with an
//! uncertainty carry the covariances of the document to each row.
//!
//! A variometer is corrected by the baselines that `absolute` adopted (`variometer`), which `baselines` writes as
//! INTERMAGNET's yearly baseline file.
//!
//! `known` has every parameter behind the field with its uncertainty and the root of their covariance;
//! `recording` gives the field with its derivatives by each of them. Without effects behind the field both
//! are affine in the reading: `recording` takes them from four readings, and a row costs a matrix and six
//! quadratic forms. `table` goes through files in batches if every effect acts row by row
//! (`Kind::row_by_row`); otherwise it takes them whole.

mod baselines;
pub mod flags;
mod formats;
mod known;
mod noise;
mod recording;
mod table;
mod variometer;
mod words;

pub use baselines::ibf;
pub use common::Error;
pub use formats::{Observatory, Station};
pub use recording::{Corrected, Corrector};
pub use table::{Request, correct_table};
pub use words::{summary, table_summary};

use common::{Axis, Calibration, Column, Document, Quantity, Recording, procedure};
use physics::Unit;

/// The frame in which a field is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// Of the sensor block.
    #[default]
    Sen,
    /// North, east, down.
    Geo,
}

impl Frame {
    /// Names of the columns that a corrected recording gets: the field (`field_x_nt` in SEN, `field_geo_x_nt` in GEO), its
    /// standard uncertainty, the flags.
    pub fn columns(self) -> [String; 7] {
        let quantity = if self == Frame::Sen { "field" } else { "field_geo" };
        let [x, y, z] = Axis::ALL.map(|axis| format!("{quantity}_{axis}_nt"));
        let [sx, sy, sz] = Axis::ALL.map(|axis| format!("{quantity}_std_{axis}_nt"));
        [x, y, z, sx, sy, sz, "field_flags".into()]
    }
}

const NOTHING: &str = "no recording holds readings of three sensors; correct needs `sensor_x_v`, `sensor_y_v` and `sensor_z_v`, or the same in nT";

/// Corrects every recording that holds readings of three sensors: it gets the columns of [`Frame::columns`].
pub fn run(mut document: Document, frame: Frame) -> Result<Document, Error> {
    check(&document)?;
    let corrector = Corrector::of(&document, frame)?;
    let mut done: Vec<(usize, Corrected)> = Vec::new();
    let mut hidden = None;
    for (index, recording) in document.recordings.iter().enumerate() {
        let path = format!("recordings[{index}]");
        if recording.table.is_some() && recording.columns.is_empty() {
            let expected = "the readings under `columns`; correct a long series as the file that it is, with --calibration and this document";
            let found = "a file beside the document";
            return Err(Error::document(format!("{path}.table"), found, expected));
        }
        if !is_corrected(recording) {
            continue;
        }
        if !variometer::is_by_baselines(&document, recording) {
            check_sensitivities(&document, recording, &path)?;
        }
        match corrector.correct(recording, &path, None) {
            Ok(corrected) => done.push((index, corrected)),
            Err(Error::Unanswerable(why)) => {
                done.push((index, Corrected::not_invertible(recording.rows())));
                hidden = hidden.or(Some(why));
            }
            Err(error) => return Err(error),
        }
    }
    if done.is_empty() {
        let mut all = document.recordings.iter().enumerate();
        all.try_for_each(|(index, one)| one.at_hand(&format!("recordings[{index}]")))?;
        return Err(Error::Request(NOTHING.into()));
    }
    if let Some(why) = hidden.filter(|_| done.iter().all(|(_, corrected)| !corrected.has_field())) {
        return Err(Error::Unanswerable(why));
    }
    for (index, corrected) in done {
        let recording = &document.recordings[index];
        let by_baselines = variometer::is_by_baselines(&document, recording);
        let delta = by_baselines.then(|| variometer::delta_f(&document, recording, &corrected)).flatten();
        let frame = variometer::frame(&document, recording, frame);
        let columns = &mut document.recordings[index].columns;
        columns.extend(delta.map(|delta| (variometer::DELTA_F.to_string(), Column::from(delta))));
        for (name, values) in frame.columns().into_iter().zip(corrected.into_columns()) {
            columns.insert(name, Column::from(values));
        }
    }
    Ok(document)
}

/// Whether a recording has readings of three sensors in one unit.
fn is_corrected(recording: &Recording) -> bool {
    let all =
        |unit: &str| Axis::ALL.iter().all(|axis| recording.axis_column("sensor", *axis, unit).is_some());
    ![procedure::DIFFERENTIAL, procedure::ABSOLUTE].contains(&recording.procedure.as_str())
        && (all("v") || all("nt"))
}

/// Without any calibration there is nothing to correct with.
fn check(document: &Document) -> Result<(), Error> {
    let calibration = document.calibration.as_ref();
    let none = |one: &Calibration| one.sensors.is_none() && one.axes.is_none() && one.absolute.is_none();
    if calibration.is_none_or(none) {
        let expected =
            "what scalarcal, absolute, or sensorcal and axescal found, or what you state in their place";
        return Err(Error::document("calibration", "neither `sensors` nor `axes` nor `absolute`", expected));
    }
    Ok(())
}

/// Readings are in one unit, and those in V have a sensitivity.
fn check_sensitivities(document: &Document, recording: &Recording, path: &str) -> Result<(), Error> {
    for axis in Axis::ALL {
        let [volts, field] = ["v", "nt"].map(|unit| recording.axis_column("sensor", axis, unit).is_some());
        let sensor = document.calibration.as_ref().and_then(|calibration| calibration.sensor(axis));
        let unit = if volts { Unit::Volt } else { Unit::Nanotesla };
        let stated = sensor.and_then(|sensor| physics::sensitivity(sensor, unit)).map(Quantity::value);
        let nominal = document.instrument.as_ref().and_then(|i| i.nominal_sensitivity_nt_per_v);
        let key = format!("sensitivity_nt_per_{}", unit.suffix());
        if volts && field {
            let found = format!("sensor_{axis}_v beside sensor_{axis}_nt");
            let expected = "readings in V or in nT; remove one of the two columns";
            return Err(Error::document(format!("{path}.columns"), found, expected));
        }
        if volts && stated.or(nominal).is_none() {
            let expected =
                format!("calibration.sensors.{axis}.{key}, or instrument.nominal_sensitivity_nt_per_v");
            let path = format!("{path}.columns.sensor_{axis}_v");
            return Err(Error::document(path, "readings in V without a sensitivity", expected));
        }
        if stated.is_some_and(|value| value == 0.0 || !value.is_finite()) {
            let path = format!("calibration.sensors.{axis}.{key}");
            let expected = "the field for each unit of the reading, which is not zero";
            return Err(Error::document(path, "0", expected));
        }
    }
    Ok(())
}
