//! The days of the calibration.

use common::{Certificate, Document};

/// What is wrong with the days that are stated.
pub fn notes(document: &Document, data: &Certificate) -> Vec<String> {
    let mut notes = Vec::new();
    for (key, text) in [("received", &data.received), ("issued", &data.issued)] {
        if text.as_ref().is_some_and(|text| !is_day(text)) {
            notes.push(format!("certificate.{key} is not a day in the form YYYY-MM-DD."));
        }
    }
    let Some(Days { first, last, .. }) = days(document, data) else { return notes };
    // Days of one form have the order of their texts.
    let day = |text: &Option<String>| text.clone().filter(|text| is_day(text));
    if day(&data.issued).is_some_and(|issued| issued < last) {
        notes.push(format!("The day of issue is before the last day of the calibration, {last}."));
    }
    if day(&data.received).is_some_and(|received| received > first) {
        notes.push(format!("The item was received after the first day of the calibration, {first}."));
    }
    notes
}

pub struct Days {
    first: String,
    last: String,
    pub words: String,
}

/// The days that are stated, else those on which the recordings begin.
pub fn days(document: &Document, data: &Certificate) -> Option<Days> {
    let stated = data.calibrated.as_deref().unwrap_or_default();
    let starts = document.recordings.iter().filter_map(|recording| recording.start.as_deref()?.get(..10));
    let mut all: Vec<&str> =
        if stated.is_empty() { starts.collect() } else { stated.iter().map(String::as_str).collect() };
    all.sort_unstable();
    let (first, last) = (all.first()?.to_string(), all.last()?.to_string());
    let source = if stated.is_empty() { " (from the recordings)" } else { "" };
    let words = if first == last { format!("{first}{source}") } else { format!("{first} to {last}{source}") };
    Some(Days { first, last, words })
}

/// Whether a text is a day as YYYY-MM-DD.
fn is_day(text: &str) -> bool {
    let is_right = |(place, c): (usize, char)| match place {
        4 | 7 => c == '-',
        _ => c.is_ascii_digit(),
    };
    text.len() == 10 && text.char_indices().all(is_right)
}
