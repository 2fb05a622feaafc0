//! A certificate before it is written: parts with fields, words and tables, as its template adds them.

use crate::page::{Cell, Section, Table, template};
use common::{Certificate, Quantity};
use minijinja::value::{Value, from_args};
use minijinja::{Error, ErrorKind};
use serde::{Deserialize, Serialize};

use crate::certificate::expanded::expanded;

/// A line to be filled in by hand.
pub const BLANK: &str = "________________";

const RESULTS: &str = "result | value ± U | unit | k";

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
    Page(crate::page::Item),
    /// A line for a signature.
    Signature,
}

/// A field with the clause of the standard that asks for it.
#[derive(Clone, Debug, Serialize)]
pub struct Field {
    pub label: String,
    pub clause: String,
    /// What stands in it, a line each; none: a blank line with the clause.
    pub lines: Vec<String>,
}

/// What the template calls to add to the certificate.
pub const FUNCTIONS: [&str; 11] = [
    "part",
    "required",
    "stated",
    "listed",
    "say",
    "table",
    "row",
    "results",
    "result",
    "blank_without_results",
    "signature",
];

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

    /// One of [`FUNCTIONS`].
    pub(crate) fn add(&mut self, function: &str, arguments: &[Value]) -> Result<(), Error> {
        if function == "part" {
            let (title, clauses) = from_args(arguments)?;
            self.parts.push(Part { title, clauses, items: Vec::new() });
            return Ok(());
        }
        let items = self.parts.last_mut().map(|part| &mut part.items);
        let items = items.ok_or_else(|| Error::new(ErrorKind::InvalidOperation, "nothing before a part"))?;
        match (function, arguments) {
            ("required", _) => {
                let (label, clause, text): (String, String, Option<String>) = from_args(arguments)?;
                items.push(Item::Field(Field::required(&label, &clause, text.as_deref())));
            }
            ("stated", _) => {
                let (label, clause, text): (String, String, Option<String>) = from_args(arguments)?;
                let text = text.map(|text| if text.trim().is_empty() { "None.".into() } else { text });
                items.push(Item::Field(Field::required(&label, &clause, text.as_deref())));
            }
            ("listed", _) => {
                let (label, clause, lines): (String, String, Option<Vec<String>>) = from_args(arguments)?;
                let none = lines.as_ref().is_some_and(Vec::is_empty).then(|| "None.".to_string());
                let lines = lines.into_iter().flatten().chain(none).collect();
                items.push(Item::Field(Field { label, clause, lines }));
            }
            ("say", [words]) => items.push(Item::Page(crate::page::Item::Words(words.to_string()))),
            ("table" | "results", [caption]) => {
                let headers = if function == "results" { RESULTS } else { "" };
                items.push(Item::Page(crate::page::Item::Table(Table::new(caption.to_string(), headers))));
            }
            ("row" | "result", _) => {
                let Some(Item::Page(crate::page::Item::Table(table))) = items.last_mut() else {
                    return Err(Error::new(ErrorKind::InvalidOperation, "a row before any table"));
                };
                match (function, arguments) {
                    ("result", [of, quantity, unit, factor @ ..]) => {
                        if let Some(quantity) = Option::<Quantity>::deserialize(quantity.clone())? {
                            let factor = factor.first().and_then(|factor| f64::try_from(factor.clone()).ok());
                            let [value, k] = expanded(&quantity, factor);
                            table.rows.push(vec![Cell::from(of), value, Cell::from(unit), k]);
                        }
                    }
                    _ => template::add_row(table, arguments)?,
                }
            }
            ("blank_without_results", []) => {
                items.retain(Item::is_there);
                if items.len() == 1 {
                    items.push(Item::Field(Field::required("Results", "7.8.2.1 m", None)));
                }
            }
            ("signature", []) => items.push(Item::Signature),
            _ => return Err(Error::from(ErrorKind::MissingArgument)),
        }
        Ok(())
    }

    /// Adds what counts in a statement of conformity to the part of that name.
    pub(crate) fn add_statement(&mut self, statement: Section) {
        let failures = statement.warnings.into_iter().map(|finding| finding.words);
        let words = statement.words.into_iter().take(2).chain(failures).map(crate::page::Item::Words);
        let items = words.chain(statement.items).map(Item::Page);
        if let Some(part) = self.parts.iter_mut().find(|part| part.title == "Statement of conformity") {
            part.items.extend(items);
        }
    }

    /// What is blank, with its clause.
    pub fn blank(&self) -> Vec<String> {
        let number = self.number.is_none().then(|| "number (7.8.2.1 d)".to_string());
        let (mut fields, mut cells): (Vec<&Field>, _) = (self.laboratory.iter().collect(), Vec::new());
        for item in self.parts.iter().flat_map(|part| &part.items) {
            match item {
                Item::Field(field) => fields.push(field),
                Item::Page(crate::page::Item::Table(table)) => {
                    let is_blank = |cell: &&Cell| matches!(cell, Cell::Text(text) if text.contains(BLANK));
                    let count = table.rows.iter().flatten().filter(is_blank).count();
                    let words = crate::page::number::counted(count, "cell");
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

impl Item {
    /// Whether it is no table without rows.
    pub fn is_there(&self) -> bool {
        !matches!(self, Item::Page(crate::page::Item::Table(table)) if table.rows.is_empty())
    }
}

impl Field {
    /// A field that must say something; line breaks part its lines.
    pub fn required(label: &str, clause: &str, text: Option<&str>) -> Self {
        let lines = text.unwrap_or_default().lines().map(str::trim).filter(|line| !line.is_empty());
        Self { label: label.into(), clause: clause.into(), lines: lines.map(String::from).collect() }
    }
}
