//! A certificate before it is written.

use crate::page::{Cell, Field, Item, Section, number};

/// A line to be filled in by hand.
pub const BLANK: &str = "________________";

/// A certificate before it is written.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// Its unique identification; None: blank.
    pub(super) number: Option<String>,
    pub(super) laboratory: Vec<Field>,
    pub(super) parts: Vec<Section>,
    /// What is to be settled before it is issued, a sentence each.
    pub notes: Vec<String>,
}

impl Sheet {
    /// What is blank, with its clause.
    pub fn blank(&self) -> Vec<String> {
        let number = self.number.is_none().then(|| "number (7.8.2.1 d)".to_string());
        let (mut fields, mut cells): (Vec<&Field>, _) = (self.laboratory.iter().collect(), Vec::new());
        for item in self.parts.iter().flat_map(|part| &part.items) {
            match item {
                Item::Field(field) => fields.push(field),
                Item::Table(table) => {
                    let is_blank = |cell: &&Cell| matches!(cell, Cell::Text(text) if text.contains(BLANK));
                    let count = table.rows.iter().flatten().filter(is_blank).count();
                    let words = number::counted(count, "cell");
                    cells.extend((count > 0).then(|| format!("{words} of the table \"{}\"", table.caption)));
                }
                _ => {}
            }
        }
        let fields = fields.into_iter().filter(|field| field.lines.is_empty());
        let fields = fields.map(|field| format!("{} ({})", field.label.to_lowercase(), field.clause));
        number.into_iter().chain(fields).chain(cells).collect()
    }
}
