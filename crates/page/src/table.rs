//! A table and its cells, before they are written as HTML or text.

use common::{Axis, Quantity};
use std::fmt;

use crate::number::{bare, figures, probability, uncertain};

/// A table; every row has as many cells as there are headers.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// What it holds.
    pub caption: String,
    /// The columns' names.
    pub headers: Vec<Header>,
    /// The rows.
    pub rows: Vec<Vec<Cell>>,
}

/// Name of a column.
#[derive(Clone, Debug, Default)]
pub struct Header {
    /// What stands in it.
    pub name: String,
    /// Its unit; empty where it has none.
    pub unit: String,
}

/// One cell of a table.
#[derive(Clone, Debug, Default)]
pub enum Cell {
    /// Nothing is known here.
    #[default]
    Empty,
    /// Words.
    Text(String),
    /// A count.
    Count(usize),
    /// A number without an uncertainty, to six figures.
    Number(f64),
    /// A number of which so many figures are enough: an rms, a standard uncertainty, a bound.
    Figures(f64, usize),
    /// A value with its standard uncertainty.
    Uncertain {
        /// The value.
        value: f64,
        /// Its standard uncertainty.
        std: f64,
    },
    /// A probability.
    Probability(f64),
}

impl Table {
    /// A table without rows as yet. Bars stand between its headers, units in brackets: `"axis | rms [nT]"`.
    pub fn new(caption: impl Into<String>, headers: &str) -> Self {
        let headers = headers.split('|').map(|header| Header::from(header.trim())).collect();
        Self { caption: caption.into(), headers, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl Row) {
        let cells = cells.cells();
        debug_assert_eq!(cells.len(), self.headers.len(), "{}", self.caption);
        self.rows.push(cells);
    }
}

impl From<&str> for Header {
    /// A name with its unit in brackets behind it, where it has one.
    fn from(text: &str) -> Self {
        let parts = text.strip_suffix(']').and_then(|text| text.rsplit_once(" ["));
        let (name, unit) = parts.unwrap_or((text, ""));
        Self { name: name.into(), unit: unit.into() }
    }
}

/// The cells of a row, as a tuple of what they hold.
pub trait Row {
    /// The cells in their order.
    fn cells(self) -> Vec<Cell>;
}

/// Tuples of so many cells and fewer, down to two.
macro_rules! rows {
    ($last:ident) => {};
    ($cell:ident $($more:ident)+) => {
        impl<$cell: Into<Cell>, $($more: Into<Cell>),+> Row for ($cell, $($more),+) {
            #[allow(non_snake_case)]
            fn cells(self) -> Vec<Cell> {
                let ($cell, $($more),+) = self;
                vec![$cell.into(), $($more.into()),+]
            }
        }
        rows!($($more)+);
    };
}

rows!(A B C D E F G H I J);

impl Cell {
    /// So many figures of a number, where there is one.
    pub fn figures(number: Option<f64>, figures: usize) -> Self {
        number.map(|number| Cell::Figures(number, figures)).into()
    }

    /// A probability, where there is one.
    pub fn probability(p: Option<f64>) -> Self {
        p.map(Cell::Probability).into()
    }
}

/// As it is written; missing and non-finite numbers are said.
impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&match self {
            Cell::Empty => "–".into(),
            Cell::Text(text) => text.clone(),
            Cell::Count(count) => count.to_string(),
            Cell::Number(number) => bare(*number),
            Cell::Figures(number, digits) => figures(*number, *digits),
            Cell::Uncertain { value, std } => uncertain(*value, *std),
            Cell::Probability(p) => probability(*p),
        })
    }
}

/// What becomes a cell, and which one.
macro_rules! cells {
    ($($name:ident: $from:ty => $cell:expr;)+) => {
        $(impl From<$from> for Cell {
            fn from($name: $from) -> Self {
                $cell
            }
        })+
    };
}

cells! {
    text: &str => Cell::Text(text.into());
    text: String => Cell::Text(text);
    text: &String => Cell::Text(text.clone());
    text: &Option<String> => text.clone().into();
    axis: Axis => axis.letter().into();
    yes: bool => if yes { "yes" } else { "no" }.into();
    count: usize => Cell::Count(count);
    number: f64 => Cell::Number(number);
    quantity: &Option<Quantity> => quantity.as_ref().into();
}

impl From<&Quantity> for Cell {
    fn from(quantity: &Quantity) -> Self {
        match quantity.std() {
            Some(_) if quantity.is_at_least() => Cell::Text(quantity.to_string()),
            Some(std) => Cell::Uncertain { value: quantity.value(), std },
            None => Cell::Number(quantity.value()),
        }
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(cell: Option<T>) -> Self {
        cell.map(Into::into).unwrap_or_default()
    }
}
