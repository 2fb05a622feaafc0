//! What is said on standard error.

use crate::clock;
use crate::piece::{Clock, Piece};
use crate::series::{Gaps, Series};

/// Words about files that are said one by one.
const SAID: usize = 5;

/// What was read, how it was converted, what is doubtful.
pub fn words(
    series: &Series,
    pieces: &[Piece],
    gaps: &Gaps,
    step_s: Option<f64>,
    start: Option<&str>,
    id: &str,
) -> String {
    let format = pieces.first().map_or("", |piece| piece.format);
    let rows = series.times_ns.len();
    let files = if pieces.len() == 1 { "1 file".into() } else { format!("{} files", pieces.len()) };
    let step = step_s.map(|step_s| format!(" of {step_s} s")).unwrap_or_default();
    let span = match (start, series.times_ns.last()) {
        (Some(start), Some(last)) => format!(", {start} to {}", clock::text(*last)),
        _ => String::new(),
    };
    let mut lines = vec![format!("ingest: \"{id}\" from {files} of {format}: {rows} rows{step}{span}")];
    for (name, values) in &series.columns {
        let there = values.iter().filter(|value| !value.is_nan());
        let (mut count, mut least, mut most) = (0, f64::INFINITY, f64::NEG_INFINITY);
        there.for_each(|value| {
            count += 1;
            least = least.min(*value);
            most = most.max(*value);
        });
        let missing = if count < rows { format!(", {} missing", rows - count) } else { String::new() };
        let range =
            if count > 0 { format!("{} to {}", short(least), short(most)) } else { "no reading".into() };
        lines.push(format!("  {name}: {range}{missing}"));
    }
    let converted = pieces.first().and_then(|piece| piece.header.get("converted")?.as_str());
    lines.extend(converted.map(|words| format!("  {words}")));
    if series.clock == Clock::Campaign {
        lines.push("  times count from the file's own zero: no moment is stated".into());
    }
    if gaps.count > 0 {
        let longest = gaps.longest.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let longest =
            longest.map(|gap| format!("; the longest is {} s after {} s", gap.seconds, gap.after_s));
        let (count, plural) = (gaps.count, if gaps.count == 1 { "gap" } else { "gaps" });
        lines.push(format!(
            "  {count} {plural}, {} rows missing{}",
            gaps.missing_rows,
            longest.unwrap_or_default()
        ));
    }
    for (count, what) in [
        (series.merged, "rows that were there more than once and agree, now once"),
        (series.disagreeing, "rows in which files disagree; one was kept as asked"),
        (series.sorted, "rows out of order, sorted"),
    ] {
        if count > 0 {
            lines.push(format!("  {count} {what}"));
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
        lines.push(format!("  … and {} such words more", notes.len() - SAID));
    }
    lines.join("\n")
}

/// A number with the digits that a person reads.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:.3e}") } else { text.to_string() }
}
