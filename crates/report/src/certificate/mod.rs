//! The certificate that a calibration laboratory hands over: what ISO/IEC 17025:2017 asks of one in 7.8.2 and
//! 7.8.4.
//!
//! `certificate.jinja` has its parts: sections whose ids are the clauses that they answer. Results come from
//! `calibration`, `model` and the statement of conformity; what a laboratory has to say besides, from the document's
//! `certificate`. What is missing is a blank line with its clause. Nothing is estimated here, and no clock is read.

mod alike;
mod days;
mod directions;
mod expanded;
mod given;
mod html;
mod sheet;

pub use given::Asked;
pub use html::render;
pub use sheet::Sheet;

use crate::conformity::Joint;
use crate::page::{Field, Item, number, template};
use common::{Certificate, Document, Error, Quantity};
use estimate::stats;
use minijinja::Value;
use serde::Deserialize;
use std::collections::HashMap;

/// The certificate of a document.
///
/// # Errors
///
/// Where the document's covariances or effects are none, as for the statement of conformity.
pub fn run(document: &Document, asked: &Asked<'_>) -> Result<Sheet, Error> {
    let none = Certificate::default();
    let data = document.certificate.as_deref().unwrap_or(&none);
    let joint = Joint::of(document)?;
    let context = given::context(document, data, &joint, asked);
    let mut environment = template::environment();
    environment.add_function("factor", move |path: String| joint.factor(&path));
    environment.add_filter("expanded", |quantity: Value, of_the_fit: Option<f64>| {
        Quantity::deserialize(quantity)
            .map(|quantity| expanded::expanded(&quantity, of_the_fit).map(Value::from_object).to_vec())
    });
    environment.add_filter("coverage_factor", |freedom: Option<f64>| {
        freedom.map(|freedom| stats::coverage_factor(0.95, freedom))
    });
    environment.add_filter("largest", |all: Option<Vec<f64>>| {
        let all = all.filter(|all| !all.is_empty())?;
        Some(all.iter().fold(0.0, |most: f64, one| most.max(one.abs())))
    });
    environment.add_filter("rms", |all: Vec<f64>| stats::rms(&all));
    let mut parts =
        template::sections(environment, include_str!("certificate.jinja"), context, HashMap::new())?;
    if let Some((spec, _)) = asked.spec {
        let statement = crate::conformity::section(document, spec)?;
        let failures = statement.warnings.into_iter().map(|finding| finding.words);
        let words = statement.words.into_iter().take(2).chain(failures).map(Item::Words);
        if let Some(part) = parts.iter_mut().find(|part| part.title == "Statement of conformity") {
            part.items.extend(words.chain(statement.items));
        }
    }
    for part in &mut parts {
        part.complete();
    }
    let of = data.laboratory.clone().unwrap_or_default();
    let line = |label: &str, text: Option<String>| {
        Field::new(label.into(), "7.8.2.1 b".into(), &text.unwrap_or_default())
    };
    let mut laboratory = vec![line("Laboratory", of.name), line("Address", of.address)];
    laboratory.extend(of.contact.map(|contact| line("Contact", Some(contact))));
    let number = data.number.clone().filter(|number| !number.trim().is_empty());
    let notes = [days::notes(document, data), alike::notes(document, data)].concat();
    Ok(Sheet { number, laboratory, parts, notes })
}

/// What people are told: the fields that are blank, and the keys that look as if they belonged into one.
pub fn summary(sheet: &Sheet) -> String {
    let blank = sheet.blank();
    let mut words = match blank.len() {
        0 => "report: certificate: every field is filled in".to_string(),
        count => {
            format!("report: certificate: {} blank: {}", number::counted(count, "field"), blank.join("; "))
        }
    };
    sheet.notes.iter().for_each(|note| words += &format!("\n  {note}"));
    words
}
