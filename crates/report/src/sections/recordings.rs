//! What was recorded, with drawings of what no stage has read, and the field that `correct` made of it.

use crate::page::words::{counted, key, slug};
use common::{Axis, Document, PerAxis, Recording, procedure};
use minijinja::{Value, context};
use std::collections::BTreeMap;
use std::ops::Range;

use super::time::Clock;
use super::{Plots, events};
use crate::plot::{Dimension, Mark, Plot, STYLES, Series};
use crate::{Effect, Finding, number};

/// Most recordings that are drawn; the longest.
const DRAWN: usize = 6;
/// Columns have plots of their own where none spans more than this share of all.
const FLAT: f64 = 0.25;
/// A recording of more rows is drawn as lines.
const FEW: usize = 1000;
/// Most recordings whose field is drawn; the longest.
const FIELDS_DRAWN: usize = 4;

fn missing(recording: &Recording) -> usize {
    let readings = recording.columns.values().flat_map(|column| column.iter());
    readings.filter(|value| !value.is_finite()).count()
}

/// Of each procedure its name, and how many recordings, rows and missing readings there are.
pub fn procedures(document: &Document) -> Vec<(&str, [usize; 3])> {
    let mut procedures: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    for recording in &document.recordings {
        let counts = procedures.entry(&recording.procedure).or_default();
        *counts = [counts[0] + 1, counts[1] + recording.rows(), counts[2] + missing(recording)];
    }
    procedures.into_iter().collect()
}

pub fn list(document: &Document) -> Vec<Value> {
    let one = |recording: &Recording| {
        let names: Vec<&str> = recording.columns.keys().map(String::as_str).collect();
        let columns =
            recording.table.as_ref().map_or(names.join(", "), |table| format!("in the table {table}"));
        context! {
            id => recording.id,
            procedure => recording.procedure,
            start => recording.start,
            rows => recording.rows(),
            missing => missing(recording),
            columns,
        }
    };
    document.recordings.iter().map(one).collect()
}

/// Draws the longest recordings of which no other section speaks: how many there are, and are drawn.
pub fn unread(all: &mut Plots, document: &Document) -> Value {
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
    let drawn = || unread.iter().take(DRAWN);
    all.insert("recordings".into(), drawn().flat_map(|one| plots(one)).collect());
    let (gaps, events): (Vec<usize>, Vec<Vec<Value>>) = drawn().map(|one| events::of(one)).unzip();
    let gaps: usize = gaps.into_iter().sum();
    context! { count => unread.len(), drawn => unread.len().min(DRAWN), gaps, events => events.concat() }
}

/// Whether a stage's result speaks of recordings of this procedure.
fn is_read(document: &Document, recording: &Recording) -> bool {
    let corrected = recording.columns.keys().any(|name| name.starts_with("field_"));
    if corrected || document.diagnosis.as_ref().is_some_and(|all| !all.is_empty()) {
        return true;
    }
    let Some(calibration) = &document.calibration else { return false };
    let mut coils = calibration.coils.iter().flat_map(PerAxis::iter).map(|(_, coil)| coil);
    let mut sensors = calibration.sensors.iter().flat_map(PerAxis::iter).map(|(_, sensor)| sensor);
    match recording.procedure.as_str() {
        procedure::COIL_CONSTANT => coils.any(|coil| coil.constant.is_some()),
        procedure::COIL_GRADIENT => coils.any(|coil| !coil.surveys.is_empty()),
        procedure::NULLING_RESIDUAL => calibration.nulling.is_some(),
        procedure::SENSOR_SENSITIVITY => sensors.any(|sensor| sensor.sensitivity.is_some()),
        procedure::SENSOR_OFFSET_REVERSAL => sensors.any(|sensor| sensor.reversal.is_some()),
        procedure::SENSOR_NOISE => sensors.any(|sensor| sensor.noise.is_some()),
        procedure::OFFSET_DRIFT => sensors.any(|sensor| sensor.drift.is_some()),
        procedure::TEMPERATURE_RUN => sensors.any(|sensor| sensor.temperature.is_some()),
        procedure::CROSS_FIELD => sensors.any(|sensor| sensor.cross_field.is_some()),
        procedure::AXES_ORIENTATION => {
            calibration.axes.as_ref().is_some_and(|axes| axes.fit.is_some() || axes.subset.is_some())
        }
        procedure::DIFFERENTIAL => calibration.differential.as_ref().is_some_and(|found| found.fit.is_some()),
        procedure::FREE_RUN => {
            calibration.scalar.as_ref().is_some_and(|scalar| scalar.recordings.contains(&recording.id))
                || calibration.flight.as_ref().is_some_and(|flight| flight.recordings.contains(&recording.id))
        }
        procedure::ABSOLUTE | procedure::VARIOMETER => calibration.absolute.as_ref().is_some_and(|found| {
            found.variometer.contains(&recording.id)
                || found.sets.iter().any(|set| set.recording == recording.id)
        }),
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
    let (along, x, time) = Clock::axis(recording);
    let segments = events::segments(recording);
    let mut plots = Vec::new();
    for (unit, names) in &units {
        // All in one plot, or each in its own.
        let most = if would_lie_flat(recording, names) { 1 } else { names.len() };
        let styled: Vec<(usize, &&str)> = names.iter().enumerate().collect();
        for names in styled.chunks(most) {
            let words: Vec<String> = names.iter().map(|(_, name)| key(name).0).collect();
            let id = format!("recording-{}-{}", slug(&recording.id), plots.len() + 1);
            let plot = Plot::new(id, format!("{}: {}", recording.id, words.join(", ")))
                .axes(along.clone(), Dimension::linear("reading", unit.as_str()));
            let plot = names.iter().zip(words).fold(plot, |plot, ((style, name), word)| {
                let column = recording.column(name).unwrap_or_default();
                plot.with(series(word, *style, &x, column, &segments))
            });
            plots.push(Plot { time: time.clone(), ..plot });
        }
    }
    plots
}

/// Whether columns are so far apart that none of them would be seen to vary in one plot.
fn would_lie_flat(recording: &Recording, names: &[&str]) -> bool {
    let ends =
        |name: &&str| number::ends(recording.column(name)?.iter().copied().filter(|value| value.is_finite()));
    let all: Vec<[f64; 2]> = names.iter().filter_map(ends).collect();
    let widest = all.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
    widest < FLAT * number::span(all.iter().flatten().copied())
}

/// A shape for each reading of a short recording; lines of a long one, parted at its gaps.
fn series(name: String, style: usize, x: &[f64], column: &[f64], segments: &[Range<usize>]) -> Series {
    if column.len() <= FEW {
        return Series::points(name, style, x, column);
    }
    let mut series = Series { name, mark: Mark::Line, style, points: Vec::new() };
    for rows in segments {
        series.append(&x[rows.clone()], &column[rows.clone()]);
    }
    series
}

/// The recordings with a field that `correct` made of the readings, the longest first, with its quantity and
/// its frame.
fn with_field(document: &Document) -> Vec<(&Recording, &'static str, &'static str)> {
    let frames =
        |recording| [("field", "SEN"), ("field_geo", "GEO")].map(|(of, frame)| (recording, of, frame));
    let all = document.recordings.iter().flat_map(frames);
    let mut found: Vec<(&Recording, &str, &str)> =
        all.filter(|(recording, of, _)| recording.axis_column(of, Axis::X, "nt").is_some()).collect();
    found.sort_by_key(|(recording, ..)| std::cmp::Reverse(recording.rows()));
    found
}

/// The corrected fields, component by component; those of the longest recordings are drawn.
pub fn corrected(all: &mut Plots, document: &Document) -> Value {
    let found = with_field(document);
    let (mut components, mut plots) = (Vec::new(), Vec::new());
    let (mut rows, mut all_rows, mut largest) = (0, 0, 0.0_f64);
    for (place, (recording, quantity, frame)) in found.iter().enumerate() {
        for axis in Axis::ALL {
            let Some((field, std)) = columns(recording, quantity, axis) else { continue };
            let known = field.iter().filter(|value| value.is_finite()).count();
            let stds = number::ends(std.iter().copied());
            if axis == Axis::X {
                (rows, all_rows) = (rows + known, all_rows + field.len());
            }
            largest = stds.map_or(largest, |[_, most]| largest.max(most));
            components.push(context! {
                recording => recording.id,
                frame,
                axis,
                found => known,
                rows => recording.rows(),
                field => number::ends(field.iter().copied()),
                std => stds,
            });
            if place < FIELDS_DRAWN {
                let (along, x, time) = Clock::axis(recording);
                let id = format!("corrected-{}-{}-{axis}", slug(&recording.id), slug(quantity));
                let plot = Plot::new(id, format!("Field along {axis} in {frame}, {}", recording.id))
                    .axes(along, "field [nT]")
                    .with(Series::new("field", Mark::Line, axis.index(), &x, field).with_std(std))
                    .note("Band: one standard uncertainty; it may be narrower than the line.");
                plots.push(Plot { time, ..plot });
            }
        }
    }
    all.insert("corrected".into(), plots);
    context! { components, count => found.len(), drawn => FIELDS_DRAWN, rows, all => all_rows, std => largest }
}

pub fn flagged(document: &Document) -> Vec<Finding> {
    let found = with_field(document).into_iter().filter_map(|(recording, ..)| {
        let flags = recording.column("field_flags")?;
        let count = |bit: u32| flags.iter().filter(|flags| (**flags as u32) & bit != 0).count();
        let counts = (0..32).map(|bit| 1u32 << bit).map(|bit| (bit, count(bit)));
        let counts = counts.filter(|(_, count)| *count > 0);
        let counts: Vec<String> =
            counts.map(|(bit, count)| format!("{bit} in {}", counted(count, "row"))).collect();
        let (id, counts) = (&recording.id, counts.join(", "));
        let words = format!(
            "{id}: flagged in `field_flags`: {counts}; the page of `correct` says what each flag means"
        );
        let finding = Finding::of(words, Effect::Unstated("left out of the result"));
        let first = flags.iter().position(|flags| *flags != 0.0)?;
        let last = flags.iter().rposition(|flags| *flags != 0.0)?;
        Some(match recording.column("time_s") {
            Some(time) => finding.within(&recording.id, [time[first], time[last]]),
            None => finding,
        })
    });
    found.collect()
}

fn columns<'a>(recording: &'a Recording, quantity: &str, axis: Axis) -> Option<(&'a [f64], &'a [f64])> {
    let std = recording.axis_column(&format!("{quantity}_std"), axis, "nt").unwrap_or_default();
    Some((recording.axis_column(quantity, axis, "nt")?, std))
}
