//! A table and its cells, before they are written as HTML or text.

use serde::Serialize;
use std::fmt;

use crate::page::Place;
use crate::page::number::{bare, figures, probability, uncertain};

/// A table; every row has as many cells as there are headers.
#[derive(Clone, Debug, Default)]
pub struct Table {
    pub caption: String,
    pub headers: Vec<Header>,
    pub rows: Vec<Vec<Cell>>,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Header {
    pub name: String,
    /// Its unit; empty where it has none.
    pub unit: String,
}

#[derive(Clone, Debug, Default)]
pub enum Cell {
    /// Nothing is known here.
    #[default]
    Empty,
    Text(String),
    /// Words that lead somewhere.
    Placed(String, Place),
    Count(usize),
    /// A number without an uncertainty, to six figures.
    Number(f64),
    /// A number of which so many figures are enough: an rms, a standard uncertainty, a bound.
    Figures(f64, usize),
    /// A value with its standard uncertainty.
    Uncertain {
        value: f64,
        std: f64,
    },
    Probability(f64),
}

impl Table {
    /// A table without rows as yet. Bars stand between its headers, units in brackets: `"axis | rms [nT]"`.
    pub fn new(caption: impl Into<String>, headers: &str) -> Self {
        let headers = headers.split('|').map(|header| Header::from(header.trim())).collect();
        Self { caption: caption.into(), headers, rows: Vec::new() }
    }

    pub fn leave_out_empty_columns(&mut self) {
        let filled = |column: usize| self.rows.iter().any(|row| !matches!(row[column], Cell::Empty));
        let kept: Vec<bool> = (0..self.headers.len()).map(filled).collect();
        retain(&mut self.headers, &kept);
        self.rows.iter_mut().for_each(|row| retain(row, &kept));
    }
}

fn retain<T>(all: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    all.retain(|_| kept.next().copied().unwrap_or(true));
}

impl From<&str> for Header {
    /// A name with its unit in brackets behind it, where it has one.
    fn from(text: &str) -> Self {
        let parts = text.strip_suffix(']').and_then(|text| text.rsplit_once(" ["));
        let (name, unit) = parts.unwrap_or((text, ""));
        Self { name: name.into(), unit: unit.into() }
    }
}

/// As it is written; missing and non-finite numbers are said.
impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&match self {
            Cell::Empty => "–".into(),
            Cell::Text(text) | Cell::Placed(text, _) => text.clone(),
            Cell::Count(count) => count.to_string(),
            Cell::Number(number) => bare(*number),
            Cell::Figures(number, digits) => figures(*number, *digits),
            Cell::Uncertain { value, std } => uncertain(*value, *std),
            Cell::Probability(p) => probability(*p),
        })
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.into())
    }
}
