//! The certificate that a calibration laboratory hands over: what ISO/IEC 17025:2017 asks of one in 7.8.2 and
//! 7.8.4.
//!
//! Results come from `calibration`, `model` and the statement of conformity; what a laboratory has to say
//! besides, from the document's `certificate`. What is missing is a blank line with its clause. Nothing is
//! estimated here, and no clock is read.

mod administration;
mod alike;
mod conditions;
mod expanded;
mod html;
mod method;
mod references;
mod results;
mod sheet;

pub use html::render;
pub use sheet::Sheet;

use common::{Certificate, Document, Error};
use conformity::Spec;

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
    let mut sheet = Sheet::of(data);
    administration::item(&mut sheet, document, data);
    method::part(&mut sheet, document, data, asked);
    conditions::part(&mut sheet, document, data);
    references::part(&mut sheet, document, data);
    results::part(&mut sheet, document, data, asked.findings)?;
    conformity_part(&mut sheet, document, asked)?;
    administration::close(&mut sheet, data);
    sheet.notes.extend(alike::notes(document, data));
    Ok(sheet)
}

/// The statement of conformity, where a specification is given.
fn conformity_part(sheet: &mut Sheet, document: &Document, asked: &Asked<'_>) -> Result<(), Error> {
    sheet.begin("Statement of conformity", "7.8.4.1 e, 7.8.6");
    let Some((spec, _)) = asked.spec else {
        sheet.say("No statement of conformity with a specification is made.");
        return Ok(());
    };
    let section = conformity::section(document, spec)?;
    let failures = section.warnings.iter().map(|finding| &finding.words);
    for words in section.words.iter().take(2).chain(failures) {
        sheet.say(words.as_str());
    }
    section.items.into_iter().for_each(|item| sheet.add(sheet::Item::Page(item)));
    Ok(())
}

/// What people are told: the fields that are blank, and the keys that look as if they belonged into one.
pub fn summary(sheet: &Sheet) -> String {
    let mut lines = vec![match sheet.blank() {
        blank if blank.is_empty() => "report: certificate: every field is filled in".to_string(),
        blank => format!(
            "report: certificate: {} blank: {}",
            page::number::counted(blank.len(), "field"),
            blank.join("; ")
        ),
    }];
    lines.extend(sheet.notes.iter().map(|note| format!("  {note}")));
    lines.join("\n")
}
