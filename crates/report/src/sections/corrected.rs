//! The field that `correct` made of the readings.

use common::{Axis, Document, Recording};
use page::words::{counted, slug};

use super::clock::Clock;
use super::effects;
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Finding, Section, Table, number};

/// Most recordings that are drawn; the longest.
const DRAWN: usize = 4;

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let mut section = Section::new("corrected", "Corrected field");
    let mut table = Table::new(
        "Recordings with a field",
        [
            ("recording", ""),
            ("frame", ""),
            ("component", ""),
            ("rows with a field", ""),
            ("rows", ""),
            ("lowest", "nT"),
            ("highest", "nT"),
            ("smallest standard uncertainty", "nT"),
            ("largest", "nT"),
        ],
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
            let ends = |column: &[f64]| number::ends(column.iter().copied());
            let Some(field) = recording.axis_column(quantity, axis, "nt") else { continue };
            let std = recording.axis_column(&format!("{quantity}_std"), axis, "nt").unwrap_or_default();
            let [low, high] = ends(field).map_or([Cell::Empty, Cell::Empty], |ends| ends.map(Cell::Number));
            let figures = |std| Cell::Figures(std, 2);
            let [small, large] = ends(std).map_or([Cell::Empty, Cell::Empty], |ends| ends.map(figures));
            table.row([
                recording.id.as_str().into(),
                (*frame).into(),
                axis.letter().into(),
                field.iter().filter(|value| value.is_finite()).count().into(),
                recording.rows().into(),
                low,
                high,
                small,
                large,
            ]);
        }
        if let Some(flags) = recording.column("field_flags") {
            let bits = (0..32).map(|bit| 1u32 << bit);
            let count = |bit: u32| flags.iter().filter(|flags| (**flags as u32) & bit != 0).count();
            let counts = bits.map(|bit| (bit, count(bit))).filter(|(_, count)| *count > 0);
            let counts: Vec<String> =
                counts.map(|(bit, count)| format!("{bit} in {}", counted(count, "row"))).collect();
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
    for (recording, quantity, frame) in corrected.iter().take(DRAWN) {
        for axis in Axis::ALL {
            if let Some(plot) = plot(recording, quantity, frame, axis) {
                section.plot(plot);
            }
        }
    }
    if corrected.len() > DRAWN {
        section.say(format!("Drawn are the {DRAWN} longest of {}.", corrected.len()));
    }
    (!section.items.is_empty()).then_some(section)
}

fn plot(recording: &Recording, quantity: &str, frame: &str, axis: Axis) -> Option<Plot> {
    let field = recording.axis_column(quantity, axis, "nt")?;
    let std = recording.axis_column(&format!("{quantity}_std"), axis, "nt").unwrap_or_default();
    let (along, x) = Clock::axis(recording);
    let mut plot = Plot::new(
        format!("corrected-{}-{}-{axis}", slug(&recording.id), slug(quantity)),
        format!("Field along {axis} in {frame}, {}", recording.id),
        along,
        Dimension::linear("field", "nT"),
    );
    plot.push(Series::new("field", Mark::Line, axis.index(), &x, field).with_std(std));
    Some(plot.note("Band: one standard uncertainty; it may be narrower than the line."))
}
