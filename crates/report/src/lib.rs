//! Any document as one page: what each stage found, in words, tables and plots.
//!
//! A [`Page`] is made of the document by [`run`] and knows nothing of how it is shown; [`html`] and [`text`] write it. Each part of
//! a document has its file below `sections`. What the document does not hold is not computed here.
//!
//! A table holds `Cell`s: a value keeps its uncertainty until it is written. Plots are SVG of our own (`plot`: scale, ticks, thinning, shapes),
//! some 600 lines, where a library would bring fonts and colours: ours are classes, so that the page's style sets the theme. The HTML is
//! well-formed XML, which a parser checks. `conformity` gives one more section of the same form. `certificate` makes a document of its own, a
//! `Sheet` of fields with their clauses; a field without text is blank everywhere.

pub mod certificate;
pub mod conformity;
mod error;
mod escape;
pub mod html;
mod number;
mod page;
pub mod plot;
mod sections;
mod table;
pub mod text;

pub use error::Error;
pub use page::{Effect, Finding, Item, Page, Section};
pub use table::{Cell, Header, Table};

use common::Document;
use common::number::counted;

/// What is asked of the report.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// SHA-256 of the document's text, in hexadecimal, to be stated on the page.
    pub document_sha256: Option<String>,
    /// Hold the document against this specification.
    pub spec: Option<conformity::Spec>,
}

/// The page of a document.
///
/// # Errors
///
/// Where the statement of conformity cannot be made; a document without content gives a page that says so.
pub fn run(document: &Document, options: &Options) -> Result<Page, Error> {
    let conformity = options.spec.as_ref().map(|spec| conformity::section(document, spec)).transpose()?;
    Ok(sections::page(document, conformity, options.document_sha256.as_deref()))
}

/// What people are told.
pub fn summary(page: &Page) -> String {
    let plots = page.sections.iter().flat_map(|section| &section.items);
    let plots = plots.filter(|item| matches!(item, Item::Plot(_))).count();
    let findings: usize = page.sections.iter().map(|section| section.warnings.len()).sum();
    let conformity = page.sections.iter().find(|section| section.id == conformity::ID);
    let verdicts = conformity.and_then(|section| section.words.first());
    let verdicts = verdicts.map_or(String::new(), |words| format!("\n  conformity: {words}"));
    format!(
        "report: {}, {}, {}{verdicts}",
        counted(page.sections.len(), "section"),
        counted(plots, "plot"),
        counted(findings, "finding")
    )
}
