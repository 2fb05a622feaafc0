//! A certificate before it is written: parts with fields, words and tables.

use common::Certificate;
use page::{Cell, Table};

/// A line to be filled in by hand.
pub const BLANK: &str = "________________";

/// A certificate.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// Its unique identification; None: blank.
    pub number: Option<String>,
    /// The laboratory's name and address, a line each; empty: blank.
    pub laboratory: Vec<Field>,
    /// Its parts in their order.
    pub parts: Vec<Part>,
    /// What is to be settled before it is issued, a sentence each.
    pub notes: Vec<String>,
}

/// A part of a certificate.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Its title.
    pub title: String,
    /// The clauses that it answers.
    pub clauses: String,
    /// What stands in it.
    pub items: Vec<Item>,
}

/// One thing in a part.
#[derive(Clone, Debug)]
pub enum Item {
    /// A field with its clause.
    Field(Field),
    /// A heading within the part.
    Heading(String),
    /// A paragraph.
    Words(String),
    /// A table.
    Table(Table),
    /// A line for a signature.
    Signature(String),
}

/// A field with its clause of the standard.
#[derive(Clone, Debug, Default)]
pub struct Field {
    /// What it is.
    pub label: String,
    /// The clause that asks for it.
    pub clause: String,
    /// What stands in it, a line each; none: a blank line with the clause.
    pub lines: Vec<String>,
}

impl Sheet {
    /// Number and laboratory.
    pub fn of(data: &Certificate) -> Self {
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

    /// Begins a part.
    pub fn begin(&mut self, title: &str, clauses: &str) {
        self.parts.push(Part { title: title.into(), clauses: clauses.into(), items: Vec::new() });
    }

    /// Adds to the part that was begun last.
    pub fn add(&mut self, item: Item) {
        if let Some(part) = self.parts.last_mut() {
            part.items.push(item);
        }
    }

    /// Adds a field that must say something.
    pub fn required(&mut self, label: &str, clause: &str, text: Option<&str>) {
        self.add(Item::Field(Field::required(label, clause, text)));
    }

    /// Adds a field of which an empty text says that there is none.
    pub fn stated(&mut self, label: &str, clause: &str, text: Option<&str>) {
        let text = text.map(|text| if text.trim().is_empty() { "None." } else { text });
        self.required(label, clause, text);
    }

    /// Adds a field of several lines of which an empty list says that there is none.
    pub fn listed(&mut self, label: &str, clause: &str, lines: Option<&[String]>) {
        let lines = match lines {
            None => Vec::new(),
            Some([]) => vec!["None.".into()],
            Some(lines) => lines.to_vec(),
        };
        self.add(Item::Field(Field { label: label.into(), clause: clause.into(), lines }));
    }

    /// Adds a paragraph.
    pub fn say(&mut self, words: impl Into<String>) {
        self.add(Item::Words(words.into()));
    }

    /// Adds a heading.
    pub fn heading(&mut self, heading: impl Into<String>) {
        self.add(Item::Heading(heading.into()));
    }

    /// Adds a table, unless it has no rows.
    pub fn table(&mut self, table: Table) {
        if !table.rows.is_empty() {
            self.add(Item::Table(table));
        }
    }

    /// What is blank, with its clause.
    pub fn blank(&self) -> Vec<String> {
        let number = self.number.is_none().then(|| "number (7.8.2.1 d)".to_string());
        let fields = self.parts.iter().flat_map(|part| &part.items).filter_map(|item| match item {
            Item::Field(field) => Some(field),
            _ => None,
        });
        let fields = self.laboratory.iter().chain(fields).filter(|field| field.lines.is_empty());
        let fields = fields.map(|field| format!("{} ({})", field.label.to_lowercase(), field.clause));
        let tables = self.parts.iter().flat_map(|part| &part.items).filter_map(|item| match item {
            Item::Table(table) => Some(table),
            _ => None,
        });
        let cells = tables.filter_map(|table| {
            let count = table.rows.iter().flatten().filter(|cell| is_blank(cell)).count();
            let words = page::number::counted(count, "cell");
            (count > 0).then(|| format!("{words} of the table \"{}\"", table.caption))
        });
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

fn is_blank(cell: &Cell) -> bool {
    matches!(cell, Cell::Text(text) if text.contains(BLANK))
}
