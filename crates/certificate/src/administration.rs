//! Whose item was calibrated, when and where; who answers for the certificate.

use common::{CalibratedItem, Certificate, Document};

use crate::sheet::{Item, Sheet};

/// Customer, item and days.
pub fn item(sheet: &mut Sheet, document: &Document, data: &Certificate) {
    sheet.begin("Customer and item", "7.8.2.1 c, e, g to j");
    let customer = data.customer.as_ref();
    sheet.required("Customer", "7.8.2.1 e", customer.and_then(|one| one.name.as_deref()));
    let reached = customer.map(|one| [one.address.as_deref(), one.contact.as_deref()]);
    let reached: Vec<&str> = reached.into_iter().flatten().flatten().collect();
    sheet.required("Contact of the customer", "7.8.2.1 e", Some(&reached.join("\n")));
    let of_item = |text: fn(&CalibratedItem) -> &Option<String>| {
        data.item.as_ref().and_then(|item| text(item).as_deref())
    };
    let named = document.instrument.as_ref().and_then(|instrument| instrument.name.as_deref());
    let described = of_item(|item| &item.description);
    let coils = crate::results::coils_alone(document).then_some("Coil system");
    sheet.required("Item", "7.8.2.1 g", described.or(coils).or(named));
    sheet.required("Manufacturer", "7.8.2.1 g", of_item(|item| &item.manufacturer));
    sheet.required("Type", "7.8.2.1 g", of_item(|item| &item.model));
    sheet.required("Serial number", "7.8.2.1 g", of_item(|item| &item.serial));
    sheet.required("Condition when received", "7.8.2.1 g", of_item(|item| &item.condition));
    sheet.required("Received on", "7.8.2.1 h", data.received.as_deref());
    let days = days(document, data);
    sheet.required("Calibrated on", "7.8.2.1 i", days.as_ref().map(|days| days.words.as_str()));
    sheet.required("Place of the calibration", "7.8.2.1 c", data.location.as_deref());
    sheet.required("Issued on", "7.8.2.1 j", data.issued.as_deref());
    for (key, text) in [("received", &data.received), ("issued", &data.issued)] {
        if text.as_ref().is_some_and(|text| !is_day(text)) {
            sheet.notes.push(format!("certificate.{key} is not a day in the form YYYY-MM-DD."));
        }
    }
    let Some(days) = days else { return };
    // Days of one form have the order of their texts.
    let day = |text: &Option<String>| text.clone().filter(|text| is_day(text));
    if day(&data.issued).is_some_and(|issued| issued < days.last) {
        let note = format!("The day of issue is before the last day of the calibration, {}.", days.last);
        sheet.notes.push(note);
    }
    if day(&data.received).is_some_and(|received| received > days.first) {
        let note = format!("The item was received after the first day of the calibration, {}.", days.first);
        sheet.notes.push(note);
    }
}

struct Days {
    first: String,
    last: String,
    words: String,
}

/// The days that are stated, else those on which the recordings begin.
fn days(document: &Document, data: &Certificate) -> Option<Days> {
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

/// Opinions, statements and signatures.
pub fn close(sheet: &mut Sheet, data: &Certificate) {
    sheet.begin("Opinions and interpretations", "7.8.4.1 f, 7.8.7");
    sheet.stated("Opinions and interpretations", "7.8.4.1 f", data.opinions.as_deref());
    sheet.begin("Statements", "7.8.2.1 l, o, 7.8.2.2, 7.8.4.3");
    sheet.say("The results relate only to the item that was calibrated (7.8.2.1 l).");
    let done = data.adjustment.as_ref().and_then(|one| one.done.as_deref()).unwrap_or_default();
    if data.sampled.as_ref().is_none_or(Vec::is_empty) {
        let adjusted = if done.trim().is_empty() { "" } else { ", and adjusted as stated above" };
        sheet.say(format!("They apply to the item as it was received{adjusted} (7.8.2.2)."));
    }
    if data.customer_data.as_ref().is_some_and(|all| !all.is_empty()) {
        sheet.say("The laboratory is not responsible for data supplied by the customer, which may affect the results (7.8.2.2).");
    }
    sheet.say(
        "This certificate may not be reproduced except in full, unless the laboratory agrees in writing.",
    );
    sheet.say(match data.agreed_interval.as_deref().filter(|words| !words.trim().is_empty()) {
        Some(words) => format!("Calibration interval, as agreed with the customer (7.8.4.3): {words}"),
        None => "No calibration interval is recommended (7.8.4.3).".into(),
    });
    let people = data.authorised_by.as_deref().unwrap_or_default();
    if people.is_empty() {
        sheet.required("Authorised by", "7.8.2.1 o", None);
        sheet.add(Item::Signature);
    }
    for person in people {
        let function = person.function.as_deref().map_or(String::new(), |function| format!(", {function}"));
        let words = person.name.as_deref().map(|name| format!("{name}{function}"));
        sheet.required("Authorised by", "7.8.2.1 o", words.as_deref());
        sheet.add(Item::Signature);
    }
}
