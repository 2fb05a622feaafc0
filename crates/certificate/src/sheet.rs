//! A certificate before it is written: parts with fields, words and tables.

use common::Certificate;
use page::{Cell, Table};

/// A line to be filled in by hand.
pub const BLANK: &str = "________________";

/// A certificate.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// Its unique identification; None: blank.
    pub(crate) number: Option<String>,
    /// The laboratory's name and address, a line each; empty: blank.
    pub(crate) laboratory: Vec<Field>,
    pub(crate) parts: Vec<Part>,
    /// What is to be settled before it is issued, a sentence each.
    pub notes: Vec<String>,
}

/// A part of a certificate, with the clauses that it answers.
#[derive(Clone, Debug)]
pub struct Part {
    pub title: String,
    pub clauses: String,
    pub items: Vec<Item>,
}

/// One thing in a part.
#[derive(Clone, Debug)]
pub enum Item {
    Field(Field),
    /// A heading, words or a table.
    Page(page::Item),
    /// A line for a signature.
    Signature,
}

/// A field with the clause of the standard that asks for it.
#[derive(Clone, Debug)]
pub struct Field {
    pub label: String,
    pub clause: String,
    /// What stands in it, a line each; none: a blank line with the clause.
    pub lines: Vec<String>,
}

impl Sheet {
    /// Number and laboratory.
    pub(crate) fn of(data: &Certificate) -> Self {
        let laboratory = data.laboratory.as_ref();
        let mut fields = vec![
            Field::required("Laboratory", "7.8.2.1 b", laboratory.and_then(|one| one.name.as_deref())),
            Field::required("Address", "7.8.2.1 b", laboratory.and_then(|one| one.address.as_deref())),
        ];
        let contact = laboratory.and_then(|one| one.contact.as_deref());
        fields.extend(contact.map(|contact| Field::required("Contact", "7.8.2.1 b", Some(contact))));
        let number = data.number.clone().filter(|number| !number.trim().is_empty());
        Self { number, laboratory: fields, ..Self::default() }
    }

    pub(crate) fn begin(&mut self, title: &str, clauses: &str) {
        self.parts.push(Part { title: title.into(), clauses: clauses.into(), items: Vec::new() });
    }

    /// Adds to the part that was begun last.
    pub(crate) fn add(&mut self, item: Item) {
        if let Some(part) = self.parts.last_mut() {
            part.items.push(item);
        }
    }

    /// Adds a field that must say something.
    pub(crate) fn required(&mut self, label: &str, clause: &str, text: Option<&str>) {
        self.add(Item::Field(Field::required(label, clause, text)));
    }

    /// Adds a field of which an empty text says that there is none.
    pub(crate) fn stated(&mut self, label: &str, clause: &str, text: Option<&str>) {
        let text = text.map(|text| if text.trim().is_empty() { "None." } else { text });
        self.required(label, clause, text);
    }

    /// Adds a field of several lines of which an empty list says that there is none.
    pub(crate) fn listed(&mut self, label: &str, clause: &str, lines: Option<&[String]>) {
        let lines = match lines {
            None => Vec::new(),
            Some([]) => vec!["None.".into()],
            Some(lines) => lines.to_vec(),
        };
        self.add(Item::Field(Field { label: label.into(), clause: clause.into(), lines }));
    }

    pub(crate) fn say(&mut self, words: impl Into<String>) {
        self.add(Item::Page(page::Item::Words(words.into())));
    }

    /// Adds a table, unless it has no rows.
    pub(crate) fn table(&mut self, table: Table) {
        if !table.rows.is_empty() {
            self.add(Item::Page(page::Item::Table(table)));
        }
    }

    /// What is blank, with its clause.
    pub fn blank(&self) -> Vec<String> {
        let number = self.number.is_none().then(|| "number (7.8.2.1 d)".to_string());
        let (mut fields, mut cells): (Vec<&Field>, _) = (self.laboratory.iter().collect(), Vec::new());
        for item in self.parts.iter().flat_map(|part| &part.items) {
            match item {
                Item::Field(field) => fields.push(field),
                Item::Page(page::Item::Table(table)) => {
                    let is_blank = |cell: &&Cell| matches!(cell, Cell::Text(text) if text.contains(BLANK));
                    let count = table.rows.iter().flatten().filter(is_blank).count();
                    let words = page::number::counted(count, "cell");
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

impl Field {
    /// A field that must say something; line breaks part its lines.
    pub fn required(label: &str, clause: &str, text: Option<&str>) -> Self {
        let lines = text.unwrap_or_default().lines().map(str::trim).filter(|line| !line.is_empty());
        Self { label: label.into(), clause: clause.into(), lines: lines.map(String::from).collect() }
    }
}

/// A cell of a table to be filled in by hand.
pub fn blank_cell(clause: &str) -> Cell {
    Cell::Text(format!("{BLANK} ({clause})"))
}
