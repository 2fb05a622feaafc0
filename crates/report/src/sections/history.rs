//! The programs that the document went through.

use common::Document;

use crate::{Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let mut section = Section::new("history", "History");
    section.words.push(
        "No clock is in it: the same input gives the same bytes. The hash is that of the document that the program read.".into(),
    );
    let mut table = Table::new(
        "Programs",
        [("program", ""), ("version", ""), ("arguments", ""), ("SHA-256 of its input", "")],
    );
    for entry in &document.history {
        table.row([
            entry.stage.as_str().into(),
            entry.version.as_str().into(),
            entry.arguments.join(" ").into(),
            entry.input_sha256.clone().into(),
        ]);
    }
    section.table(table);
    (!section.items.is_empty()).then_some(section)
}
