//! A mapping as far as it is guessed, and what stays open.

use common::number::counted;
use common::to_text;
use serde_json::json;
use std::path::Path;

use crate::mapping::Mapping;

/// A guess.
pub struct Guess {
    /// To save, look at and edit.
    pub mapping: Mapping,
    /// What the file does not say, in words: an empty list where it says all.
    pub doubts: Vec<String>,
    /// What was taken as usual.
    pub notes: Vec<String>,
}

impl Guess {
    /// The mapping as text.
    pub fn to_text(&self) -> String {
        to_text(&json!(self.mapping))
    }

    /// Words for people.
    pub fn words(&self, file: &Path) -> String {
        let (all, known) = (self.mapping.columns.len(), self.doubts.is_empty());
        let mut lines =
            vec![format!("ingest guess: {}: {} of readings", file.display(), counted(all, "column"))];
        lines.extend(self.notes.iter().map(|note| format!("  {note}")));
        lines.extend(self.doubts.iter().map(|doubt| format!("  to be settled: {doubt}")));
        let is_absolute = self.mapping.columns.iter().any(|column| column.to == "vertical_deg");
        let procedure = if is_absolute { "--procedure absolute " } else { "" };
        let first = if known { "nothing is open: check it" } else { "edit the mapping" };
        lines.push(format!("  {first}, then ingest {procedure}--map MAP FILE"));
        lines.join("\n")
    }
}
