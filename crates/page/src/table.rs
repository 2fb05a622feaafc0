//! A table and its cells, before they are written as HTML or text.

use common::Quantity;

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
    /// A table without rows as yet; each header is a name with its unit.
    pub fn new<const N: usize>(caption: impl Into<String>, headers: [(&str, &str); N]) -> Self {
        let header = |(name, unit): (&str, &str)| Header { name: name.into(), unit: unit.into() };
        Self { caption: caption.into(), headers: headers.map(header).into(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row<const N: usize>(&mut self, cells: [Cell; N]) {
        debug_assert_eq!(N, self.headers.len(), "{}", self.caption);
        self.rows.push(cells.into());
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Cell::Count(count)
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Cell::Number(number)
    }
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
