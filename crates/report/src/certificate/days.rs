//! The days of the calibration.

use common::{Certificate, Document};

pub fn notes(document: &Document, data: &Certificate) -> Vec<String> {
    let stated = [("received", &data.received), ("issued", &data.issued)];
    let wrong = stated.into_iter().filter(|(_, text)| text.as_ref().is_some_and(|text| !is_day(text)));
    let wrong = wrong.map(|(key, _)| format!("certificate.{key} is not a day in the form YYYY-MM-DD."));
    let mut notes: Vec<String> = wrong.collect();
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
    let starts =
        document.recordings.iter().filter_map(|one| Some(one.start.as_deref()?.get(..10)?.to_string()));
    let stated = data.calibrated.clone().filter(|stated| !stated.is_empty());
    let source = if stated.is_none() { " (from the recordings)" } else { "" };
    let all = stated.unwrap_or_else(|| starts.collect());
    let (first, last) = (all.iter().min()?.clone(), all.iter().max()?.clone());
    let words = if first == last { format!("{first}{source}") } else { format!("{first} to {last}{source}") };
    Some(Days { first, last, words })
}

/// Whether a text is a day as YYYY-MM-DD.
fn is_day(text: &str) -> bool {
    let is_right =
        |(place, c): (usize, char)| if [4, 7].contains(&place) { c == '-' } else { c.is_ascii_digit() };
    text.len() == 10 && text.char_indices().all(is_right)
}
