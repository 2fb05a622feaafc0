//! The certificate that a calibration laboratory hands over: what ISO/IEC 17025:2017 asks of one in 7.8.2 and
//! 7.8.4.
//!
//! `certificate.jinja` has its parts. Results come from `calibration`, `model` and the statement of conformity; what a laboratory has to say
//! besides, from the document's `certificate`. What is missing is a blank line with its clause. Nothing is
//! estimated here, and no clock is read.

mod alike;
mod days;
mod directions;
mod expanded;
mod given;
mod html;
mod sheet;

pub use html::render;
pub use sheet::Sheet;

use crate::conformity::{Joint, Spec};
use crate::page::template;
use common::{Certificate, Document, Error};
use estimate::stats;

/// What is asked of a certificate.
#[derive(Clone, Debug, Default)]
pub struct Asked<'a> {
    /// SHA-256 of the document's text, in hexadecimal.
    pub document_sha256: Option<&'a str>,
    /// SHA-256 of the text of administrative data beside the document.
    pub data_sha256: Option<&'a str>,
    /// What the stages found striking, a sentence each, for the remarks.
    pub findings: &'a [String],
    /// The specification of a statement of conformity, with the SHA-256 of its text.
    pub spec: Option<(&'a Spec, Option<&'a str>)>,
}

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
    environment.add_filter("coverage_factor", |freedom: Option<f64>| {
        freedom.map(|freedom| stats::coverage_factor(0.95, freedom))
    });
    environment.add_filter("largest", given::largest);
    environment.add_filter("rms", |all: Vec<f64>| estimate::stats::rms(&all));
    let mut sheet = template::filled(
        environment,
        include_str!("certificate.jinja"),
        context,
        Sheet::of(data),
        (&sheet::FUNCTIONS, Sheet::add),
    )?;
    if let Some((spec, _)) = asked.spec {
        sheet.add_statement(crate::conformity::section(document, spec)?);
    }
    sheet.parts.iter_mut().for_each(|part| part.items.retain(sheet::Item::is_there));
    sheet.notes.extend(days::notes(document, data));
    sheet.notes.extend(alike::notes(document, data));
    Ok(sheet)
}

/// What people are told: the fields that are blank, and the keys that look as if they belonged into one.
pub fn summary(sheet: &Sheet) -> String {
    let mut lines = vec![match sheet.blank() {
        blank if blank.is_empty() => "report: certificate: every field is filled in".to_string(),
        blank => format!(
            "report: certificate: {} blank: {}",
            crate::page::number::counted(blank.len(), "field"),
            blank.join("; ")
        ),
    }];
    lines.extend(sheet.notes.iter().map(|note| format!("  {note}")));
    lines.join("\n")
}
