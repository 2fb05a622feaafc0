//! What is said on standard error.

use common::number::{bare, counted, duration, plural, significant};
use rayon::prelude::*;

use crate::clock::{self, Clock};
use crate::jumps::Jump;
use crate::piece::Piece;
use crate::series::{Gaps, Series};

const SAID: usize = 5;

/// What was read, how it was converted, what is doubtful.
pub fn words(
    series: &Series,
    pieces: &[Piece],
    gaps: &Gaps,
    jumps: &[(Jump, String)],
    step_s: Option<f64>,
    start: Option<&str>,
    id: &str,
) -> String {
    let format = pieces.first().map_or("", |piece| piece.format);
    let rows = series.times_ns.len();
    let files = counted(pieces.len(), "file");
    let step = step_s.map(|step_s| format!(" of {} s", bare(step_s))).unwrap_or_default();
    let span = match (start, series.times_ns.last()) {
        (Some(start), Some(last)) => format!(", {start} to {}", clock::text(*last)),
        _ => String::new(),
    };
    let mut lines =
        vec![format!("ingest: \"{id}\" from {files} of {format}: {}{step}{span}", counted(rows, "row"))];
    let columns: Vec<_> = series.columns.iter().collect();
    lines.par_extend(columns.into_par_iter().map(|(name, values)| range(name, values)));
    let converted = pieces.first().and_then(|piece| piece.header.get("converted")?.as_str());
    lines.extend(converted.map(|words| format!("  {words}")));
    if series.clock == Clock::Campaign {
        lines.push("  times count from the origin of the file: no date is stated".into());
    }
    if gaps.count > 0 {
        let longest = gaps.longest.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let longest = longest
            .map(|gap| format!("; the longest is {} after {}", duration(gap.seconds), duration(gap.after_s)));
        let (count, missing) = (counted(gaps.count, "gap"), counted(gaps.missing_rows as usize, "row"));
        lines.push(format!("  {count}, {missing} missing{}", longest.unwrap_or_default()));
    }
    lines.extend(jumps.iter().map(|(_, words)| format!("  {words}")));
    for (count, rows, what) in [
        (series.merged, "duplicate row", "merged"),
        (series.disagreeing, "row", "in which files disagree; one was kept as asked"),
        (series.sorted, "row", "out of order, sorted"),
    ] {
        if count > 0 {
            lines.push(format!("  {} {what}", counted(count, rows)));
        }
    }
    let mut notes: Vec<(&str, Vec<&str>)> = Vec::new();
    for (piece, note) in pieces.iter().flat_map(|piece| piece.notes.iter().map(move |note| (piece, note))) {
        match notes.iter_mut().find(|(known, _)| known == note) {
            Some((_, files)) => files.push(&piece.name),
            None => notes.push((note, vec![&piece.name])),
        }
    }
    lines.extend(notes.iter().take(SAID).map(|(note, files)| match files.as_slice() {
        [file] => format!("  {file}: {note}"),
        [file, more @ ..] => format!("  {file} and {} more: {note}", more.len()),
        [] => format!("  {note}"),
    }));
    if notes.len() > SAID {
        let more = notes.len() - SAID;
        lines.push(format!("  … and {more} more {}", plural(more, "note", "notes")));
    }
    lines.join("\n")
}

fn range(name: &str, values: &[f64]) -> String {
    let (mut count, mut least, mut most) = (0, f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        count += usize::from(!value.is_nan());
        least = if *value < least { *value } else { least };
        most = if *value > most { *value } else { most };
    }
    let missing = values.len() - count;
    let missing = if missing > 0 { format!(", {missing} missing") } else { String::new() };
    let range = if count > 0 {
        format!("{} to {}", significant(least, 8), significant(most, 8))
    } else {
        "no reading".into()
    };
    format!("  {name}: {range}{missing}")
}
