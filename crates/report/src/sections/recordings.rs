//! What was recorded, and drawings of what no stage has read.

use common::{Document, Recording, procedure};
use page::words::{counted, key, slug};
use std::collections::BTreeMap;

use super::clock::Clock;
use crate::plot::{Dimension, Mark, Plot, STYLES, Series};
use crate::{Section, Table};

/// Most recordings that are drawn; the longest.
const DRAWN: usize = 6;

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let mut section = Section::new("recordings", "Recordings");
    let mut procedures: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    let mut list = Table::new(
        "Each recording",
        [
            ("id", ""),
            ("procedure", ""),
            ("start", ""),
            ("rows", ""),
            ("missing readings", ""),
            ("columns", ""),
        ],
    );
    for recording in &document.recordings {
        let missing = recording
            .columns
            .values()
            .flat_map(|column| column.iter())
            .filter(|value| !value.is_finite())
            .count();
        let counts = procedures.entry(&recording.procedure).or_default();
        *counts = [counts[0] + 1, counts[1] + recording.rows(), counts[2] + missing];
        let names: Vec<&str> = recording.columns.keys().map(String::as_str).collect();
        let columns =
            recording.table.as_ref().map_or(names.join(", "), |table| format!("in the table {table}"));
        list.row([
            recording.id.as_str().into(),
            recording.procedure.as_str().into(),
            recording.start.clone().into(),
            recording.rows().into(),
            missing.into(),
            columns.into(),
        ]);
    }
    let mut table = Table::new(
        "By procedure",
        [("procedure", ""), ("recordings", ""), ("rows", ""), ("missing readings", "")],
    );
    for (procedure, [recordings, rows, missing]) in procedures {
        table.row([procedure.into(), recordings.into(), rows.into(), missing.into()]);
    }
    section.table(table);
    section.table(list);
    draw(&mut section, document);
    (!section.items.is_empty()).then_some(section)
}

/// Draws the recordings of which no other section speaks.
fn draw(section: &mut Section, document: &Document) {
    let mut unread: Vec<&Recording> = document
        .recordings
        .iter()
        .filter(|recording| !recording.columns.is_empty() && !is_read(document, recording))
        .collect();
    // Of as many rows, in the order taken: that of the document means nothing.
    let moment = |recording: &Recording| recording.start().map_or(f64::NEG_INFINITY, |start| start.unix_s);
    unread.sort_by(|a, b| {
        b.rows().cmp(&a.rows()).then(moment(a).total_cmp(&moment(b))).then_with(|| a.id.cmp(&b.id))
    });
    if unread.is_empty() {
        return;
    }
    let drawn = unread.len().min(DRAWN);
    let which = if drawn < unread.len() { format!("; drawn are the {drawn} longest") } else { String::new() };
    section.say(format!("No program has read {} as yet{which}.", counted(unread.len(), "recording")));
    for recording in unread.iter().take(DRAWN) {
        plots(recording).into_iter().for_each(|plot| section.plot(plot));
    }
}

/// Whether a stage's result speaks of recordings of this procedure.
fn is_read(document: &Document, recording: &Recording) -> bool {
    if recording.columns.keys().any(|name| name.starts_with("field_")) {
        return true;
    }
    if document.diagnosis.as_ref().is_some_and(|all| !all.is_empty()) {
        return true;
    }
    let Some(calibration) = &document.calibration else { return false };
    let coil = |test: fn(&common::CoilCalibration) -> bool| {
        calibration.coils.as_ref().is_some_and(|coils| coils.iter().any(|(_, coil)| test(coil)))
    };
    let sensor = |test: fn(&common::SensorCalibration) -> bool| {
        calibration.sensors.as_ref().is_some_and(|sensors| sensors.iter().any(|(_, sensor)| test(sensor)))
    };
    match recording.procedure.as_str() {
        procedure::COIL_CONSTANT => coil(|coil| coil.constant.is_some()),
        procedure::COIL_GRADIENT => coil(|coil| !coil.surveys.is_empty()),
        procedure::NULLING_RESIDUAL => calibration.nulling.is_some(),
        procedure::SENSOR_SENSITIVITY => sensor(|sensor| sensor.sensitivity.is_some()),
        procedure::SENSOR_OFFSET_REVERSAL => sensor(|sensor| sensor.reversal.is_some()),
        procedure::SENSOR_NOISE => sensor(|sensor| sensor.noise.is_some()),
        procedure::OFFSET_DRIFT => sensor(|sensor| sensor.drift.is_some()),
        procedure::TEMPERATURE_RUN => sensor(|sensor| sensor.temperature.is_some()),
        procedure::CROSS_FIELD => sensor(|sensor| sensor.cross_field.is_some()),
        procedure::AXES_ORIENTATION => {
            calibration.axes.as_ref().is_some_and(|axes| axes.fit.is_some() || axes.subset.is_some())
        }
        procedure::DIFFERENTIAL => calibration.differential.as_ref().is_some_and(|found| found.fit.is_some()),
        procedure::FREE_RUN => {
            calibration.scalar.as_ref().is_some_and(|scalar| scalar.recordings.contains(&recording.id))
        }
        _ => false,
    }
}

/// A plot for each unit, with the columns that have it.
fn plots(recording: &Recording) -> Vec<Plot> {
    let mut units: Vec<(String, Vec<&str>)> = Vec::new();
    for name in recording.columns.keys().filter(|name| *name != "time_s") {
        let (_, unit) = key(name);
        match units.iter_mut().find(|(of, names)| *of == unit && names.len() < STYLES) {
            Some((_, names)) => names.push(name),
            None => units.push((unit, vec![name])),
        }
    }
    let (along, x) = Clock::axis(recording);
    let plot = |(number, (unit, names)): (usize, (String, Vec<&str>))| {
        let words: Vec<String> = names.iter().map(|name| key(name).0).collect();
        let mut plot = Plot::new(
            format!("recording-{}-{}", slug(&recording.id), number + 1),
            format!("{}: {}", recording.id, words.join(", ")),
            along.clone(),
            Dimension::linear("reading", unit),
        );
        for (style, (name, word)) in names.iter().zip(words).enumerate() {
            let column = recording.column(name).unwrap_or_default();
            plot.push(Series::new(word, Mark::Points, style, &x, column));
        }
        plot
    };
    units.into_iter().enumerate().map(plot).collect()
}
