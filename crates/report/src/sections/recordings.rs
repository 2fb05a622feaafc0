//! What was recorded, with drawings of what no stage has read, and the field that `correct` made of it.

use common::{Axis, Document, Recording, procedure};
use page::words::{counted, key, slug};
use std::collections::BTreeMap;

use super::effects;
use super::shared::Clock;
use crate::plot::{Dimension, Mark, Plot, STYLES, Series};
use crate::{Cell, Finding, Section, Table, number};

/// Most recordings that are drawn; the longest.
const DRAWN: usize = 6;
/// Most recordings whose field is drawn; the longest.
const FIELDS_DRAWN: usize = 4;

pub fn section(document: &Document) -> Option<Section> {
    let mut section = Section::new("recordings", "Recordings");
    let mut procedures: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    let mut list = Table::new("Each recording", "id | procedure | start | rows | missing readings | columns");
    for recording in &document.recordings {
        let readings = recording.columns.values().flat_map(|column| column.iter());
        let missing = readings.filter(|value| !value.is_finite()).count();
        let counts = procedures.entry(&recording.procedure).or_default();
        *counts = [counts[0] + 1, counts[1] + recording.rows(), counts[2] + missing];
        let names: Vec<&str> = recording.columns.keys().map(String::as_str).collect();
        let columns =
            recording.table.as_ref().map_or(names.join(", "), |table| format!("in the table {table}"));
        let (id, procedure) = (&recording.id, &recording.procedure);
        list.row((id, procedure, &recording.start, recording.rows(), missing, columns));
    }
    let procedures = procedures.into_iter().map(|(procedure, [a, b, c])| (procedure, a, b, c));
    section.rows("By procedure", "procedure | recordings | rows | missing readings", procedures);
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
    let corrected = recording.columns.keys().any(|name| name.starts_with("field_"));
    if corrected || document.diagnosis.as_ref().is_some_and(|all| !all.is_empty()) {
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
        let id = format!("recording-{}-{}", slug(&recording.id), number + 1);
        let mut plot = Plot::new(id, format!("{}: {}", recording.id, words.join(", ")))
            .axes(along.clone(), Dimension::linear("reading", unit));
        for (style, (name, word)) in names.iter().zip(words).enumerate() {
            let column = recording.column(name).unwrap_or_default();
            plot.push(Series::points(word, style, &x, column));
        }
        plot
    };
    units.into_iter().enumerate().map(plot).collect()
}

/// The field that `correct` made of the readings.
pub fn corrected(document: &Document) -> Option<Section> {
    let mut section = Section::new("corrected", "Corrected field");
    let mut table = Table::new(
        "Recordings with a field",
        "recording | frame | component | rows with a field | rows | lowest [nT] | highest [nT] | \
         smallest standard uncertainty [nT] | largest [nT]",
    );
    let mut corrected: Vec<(&Recording, &str, &str)> = Vec::new();
    for recording in &document.recordings {
        for (quantity, frame) in [("field", "SEN"), ("field_geo", "GEO")] {
            if recording.axis_column(quantity, Axis::X, "nt").is_some() {
                corrected.push((recording, quantity, frame));
            }
        }
    }
    corrected.sort_by_key(|(recording, ..)| std::cmp::Reverse(recording.rows()));
    for (recording, quantity, frame) in &corrected {
        for axis in Axis::ALL {
            let Some((field, std)) = columns(recording, quantity, axis) else { continue };
            let ends = |column: &[f64], cell: fn(f64) -> Cell| {
                let ends = number::ends(column.iter().copied());
                ends.map_or([Cell::Empty, Cell::Empty], |ends| ends.map(cell))
            };
            let [low, high] = ends(field, Cell::Number);
            let [small, large] = ends(std, |std| Cell::Figures(std, 2));
            let found = field.iter().filter(|value| value.is_finite()).count();
            table.row((&recording.id, *frame, axis, found, recording.rows(), low, high, small, large));
        }
        if let Some(flags) = recording.column("field_flags") {
            let count = |bit: u32| flags.iter().filter(|flags| (**flags as u32) & bit != 0).count();
            let counts = (0..32).map(|bit| 1u32 << bit).map(|bit| (bit, count(bit)));
            let counts: Vec<String> = counts
                .filter(|(_, count)| *count > 0)
                .map(|(bit, count)| format!("{bit} in {}", counted(count, "row")))
                .collect();
            if !counts.is_empty() {
                let words = format!(
                    "{}: flagged in `field_flags`: {}; the page of `correct` says what each flag means",
                    recording.id,
                    counts.join(", ")
                );
                section.warnings.push(Finding::of(words, effects::LEFT_OUT));
            }
        }
    }
    section.table(table);
    for (recording, quantity, frame) in corrected.iter().take(FIELDS_DRAWN) {
        for axis in Axis::ALL {
            let Some((field, std)) = columns(recording, quantity, axis) else { continue };
            let (along, x) = Clock::axis(recording);
            let id = format!("corrected-{}-{}-{axis}", slug(&recording.id), slug(quantity));
            section.plot(
                Plot::new(id, format!("Field along {axis} in {frame}, {}", recording.id))
                    .axes(along, "field [nT]")
                    .with(Series::new("field", Mark::Line, axis.index(), &x, field).with_std(std))
                    .note("Band: one standard uncertainty; it may be narrower than the line."),
            );
        }
    }
    if corrected.len() > FIELDS_DRAWN {
        section.say(format!("Drawn are the {FIELDS_DRAWN} longest of {}.", corrected.len()));
    }
    (!section.items.is_empty()).then_some(section)
}

/// A component with its standard uncertainty.
fn columns<'a>(recording: &'a Recording, quantity: &str, axis: Axis) -> Option<(&'a [f64], &'a [f64])> {
    let std = recording.axis_column(&format!("{quantity}_std"), axis, "nt").unwrap_or_default();
    Some((recording.axis_column(quantity, axis, "nt")?, std))
}
