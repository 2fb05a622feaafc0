//! What people are told.

use common::number::{counted, figures, plural, significant, uncertain};
use common::{Axis, Document, Recording};
use estimate::stats::median_of;

use crate::flags::MEANINGS;
use crate::{Corrected, Frame, variometer};

/// What became of many rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    rows: u64,
    found: u64,
    flagged: [u64; MEANINGS.len()],
    /// Smallest and largest standard uncertainty of each component, nT.
    std_nt: [Option<[f64; 2]>; 3],
    left: Vec<String>,
}

impl Tally {
    pub fn add(&mut self, corrected: &Corrected) {
        self.count(&corrected.flags, &[0, 1, 2].map(|k| corrected.std_nt[k].as_slice()));
        for left in &corrected.left {
            if !self.left.contains(left) {
                self.left.push(left.clone());
            }
        }
    }

    pub fn is_empty(&self) -> bool {
        self.rows == 0
    }

    fn count(&mut self, flags: &[u32], std_nt: &[&[f64]; 3]) {
        self.rows += flags.len() as u64;
        for flags in flags {
            let counts = self.flagged.iter_mut().zip(MEANINGS);
            counts.for_each(|(count, (flag, _))| *count += u64::from(flags & flag != 0));
        }
        self.found += std_nt[0].iter().filter(|std| std.is_finite()).count() as u64;
        for (span, column) in self.std_nt.iter_mut().zip(std_nt) {
            for std in column.iter().filter(|std| std.is_finite()) {
                let [low, high] = span.unwrap_or([*std, *std]);
                *span = Some([low.min(*std), high.max(*std)]);
            }
        }
    }

    fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let span = |(axis, span): (&Axis, &Option<[f64; 2]>)| {
            let [low, high] = (*span)?.map(|std| figures(std, 2));
            Some(if low == high { format!("{axis} {high}") } else { format!("{axis} {low} to {high}") })
        };
        let spans: Vec<String> = Axis::ALL.iter().zip(&self.std_nt).filter_map(span).collect();
        if !spans.is_empty() {
            lines.push(format!("standard uncertainty: {} nT", spans.join(", ")));
        }
        for (count, (flag, meaning)) in self.flagged.iter().zip(MEANINGS).filter(|(count, _)| **count > 0) {
            lines.push(format!("flagged {flag}: {} ({meaning})", counted(*count as usize, "row")));
        }
        lines.extend(self.left.iter().cloned());
        lines
    }
}

/// What is told of a corrected document.
pub fn summary(document: &Document, frame: Frame) -> String {
    let names = |recording: &Recording| variometer::frame(document, recording, frame).columns();
    let mut tally = Tally::default();
    let is_done =
        |recording: &&Recording| names(recording).iter().all(|name| recording.columns.contains_key(name));
    let corrected: Vec<&Recording> = document.recordings.iter().filter(is_done).collect();
    for recording in &corrected {
        let names = names(recording);
        let column = |k: usize| recording.column(&names[k]).unwrap_or_default();
        let flags: Vec<u32> = column(6).iter().map(|flags| *flags as u32).collect();
        tally.count(&flags, &[column(3), column(4), column(5)]);
    }
    let head = format!("correct: {}, ", counted(corrected.len(), "recording"));
    let magnitudes = corrected.iter().filter_map(|recording| magnitude(recording, &names(recording)));
    let deltas = corrected.iter().filter_map(|recording| variometer::words(recording));
    let notes = magnitudes.chain(deltas).chain(notes(document, frame, corrected.iter().copied())).collect();
    let frame = corrected.first().map_or(frame, |recording| variometer::frame(document, recording, frame));
    text(&head, &tally, frame, notes)
}

/// The usual length of the corrected field beside the magnitude that is stated.
fn magnitude(recording: &Recording, names: &[String]) -> Option<String> {
    let stated = recording.conditions.quantity("magnitude_nt", "").ok()??;
    let [x, y, z] = [0, 1, 2].map(|k| recording.column(&names[k]).unwrap_or_default());
    let lengths = x.iter().zip(y).zip(z).map(|((x, y), z)| x.hypot(*y).hypot(*z));
    let mut lengths: Vec<f64> = lengths.filter(|length| length.is_finite()).collect();
    let median = (!lengths.is_empty()).then(|| median_of(&mut lengths))?;
    let source = recording.conditions.extra.get("field_model").and_then(serde_json::Value::as_str);
    let (id, source) = (&recording.id, source.unwrap_or("what is stated"));
    let (median, value) = (significant(median, 6), stated.value());
    let stated = stated.std().map_or(significant(value, 6), |std| uncertain(value, std));
    Some(format!("\"{id}\": |B| is {median} nT in the median; {stated} nT by {source}"))
}

/// What is told of a corrected table.
pub fn table_summary(tally: &Tally, calibration: &Document, recording: Option<&str>, frame: Frame) -> String {
    let of = calibration.recordings.iter().filter(|one| Some(one.id.as_str()) == recording);
    let none = Recording::default();
    let frame = variometer::frame(calibration, of.clone().next().unwrap_or(&none), frame);
    text("correct: ", tally, frame, notes(calibration, frame, of))
}

fn text(head: &str, tally: &Tally, frame: Frame, notes: Vec<String>) -> String {
    let frame = if frame == Frame::Sen { "SEN" } else { "GEO" };
    let (rows, have) = (counted(tally.rows as usize, "row"), plural(tally.found as usize, "has", "have"));
    let mut lines = vec![format!("{head}{} of {rows} {have} a field in {frame}", tally.found)];
    lines.extend(tally.lines().into_iter().chain(notes).map(|line| format!("  {line}")));
    lines.join("\n")
}

/// What was not stated, and what was assumed for it.
fn notes<'a>(
    document: &Document,
    frame: Frame,
    corrected: impl Iterator<Item = &'a Recording>,
) -> Vec<String> {
    let mut notes = Vec::new();
    let mut corrected = corrected.filter(|one| !variometer::is_by_baselines(document, one)).peekable();
    if corrected.peek().is_none() && variometer::adopted(document).is_some() {
        return notes;
    }
    let calibration = document.calibration.as_ref();
    let sensors = calibration.and_then(|calibration| calibration.axes.as_ref()?.sensors.as_ref());
    match sensors {
        None => notes
            .push("directions of the sensors are not stated: assumed along SEN, without uncertainty".into()),
        Some(sensors) if sensors.covariance.is_none() && sensors.std_arcsec.is_none() => {
            notes.push("directions of the sensors have no stated uncertainty: none is included".into());
        }
        Some(_) => {}
    }
    for axis in Axis::ALL {
        let sensor = calibration.and_then(|calibration| calibration.sensor(axis));
        let stated = sensor.is_some_and(|sensor| {
            let scale = sensor.sensitivity_nt_per_v.as_ref().or(sensor.sensitivity_nt_per_nt.as_ref());
            scale.and_then(common::Quantity::std).is_some()
        });
        if !stated {
            notes.push(format!(
                "the sensitivity of sensor {axis} has no stated uncertainty: none is included"
            ));
        }
    }
    let oriented = |recording: &Recording| {
        recording.conditions.orientation.is_some()
            || recording.conditions.theodolite.is_some()
            || recording.columns.contains_key("attitude_w")
    };
    if frame == Frame::Geo && !corrected.all(oriented) {
        notes.push("where no orientation is stated, SEN is assumed aligned with GEO".into());
    }
    notes
}
