//! Any document as one page: what each stage found, in words, tables and plots.
//!
//! A [`Page`] is made of the document by [`run`]; [`html`] and [`text`] write it. `sections.jinja` has the words and
//! tables of each section, the modules below `sections` its plots and findings. What the document does not hold
//! is not computed here.
//!
//! [`conformity`] gives one more section of the same form; [`certificate`] makes a document of its own.

pub mod certificate;
pub mod conformity;
mod page;
mod sections;

pub use page::{Effect, Item, Page, html, text};
pub use sections::findings;

use common::Document;
use common::number::counted;
use page::{Finding, Section, Table, number, plot};

/// What is asked of the report.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// SHA-256 of the document's text, in hexadecimal, to be stated on the page.
    pub document_sha256: Option<String>,
    /// What the document is called, where it states neither a title nor an instrument.
    pub name: Option<String>,
    /// Hold the document against this specification.
    pub spec: Option<conformity::Spec>,
}

/// The page of a document.
///
/// # Errors
///
/// Where the statement of conformity cannot be made; a document without content gives a page that says so.
pub fn run(document: &Document, options: &Options) -> Result<Page, common::Error> {
    let conformity = options.spec.as_ref().map(|spec| conformity::section(document, spec)).transpose()?;
    sections::page(document, conformity, options)
}

/// What people are told.
pub fn summary(page: &Page) -> String {
    let plots = page.sections.iter().flat_map(|section| &section.items);
    let plots = plots.filter(|item| matches!(item, Item::Plot(_))).count();
    let findings: usize = page.sections.iter().map(|section| section.warnings.len()).sum();
    let conformity = page.sections.iter().find(|section| section.id == conformity::ID);
    let verdicts = conformity.and_then(|section| section.words.first());
    let verdicts = verdicts.map_or(String::new(), |words| format!("\n  conformity: {words}"));
    let [sections, plots, findings] =
        [(page.sections.len(), "section"), (plots, "plot"), (findings, "finding")]
            .map(|(n, of)| counted(n, of));
    format!("report: {sections}, {plots}, {findings}{verdicts}")
}
