//! Numbers in the cells of tables.

pub use common::number::*;

use crate::table::Cell;

/// What stands in a cell; missing and non-finite numbers are said.
pub fn cell(cell: &Cell) -> String {
    match cell {
        Cell::Empty => "–".into(),
        Cell::Text(text) => text.clone(),
        Cell::Count(count) => count.to_string(),
        Cell::Number(number) => bare(*number),
        Cell::Figures(number, digits) => figures(*number, *digits),
        Cell::Uncertain { value, std } => uncertain(*value, *std),
        Cell::Probability(p) => probability(*p),
    }
}

/// Smallest and largest of the values that are finite.
pub fn ends(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite()).map(|value| [value, value]);
    finite.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}
