//! A result with its expanded uncertainty.

use common::Quantity;
use page::number::{as_known, bare, figures, uncertain};
use page::{Cell, Table};

use crate::sheet::blank_cell;

/// From standard uncertainty to 95 % interval of a normal distribution.
pub const NORMAL: f64 = 1.959_963_984_540_054;

/// A value with U = k u, the half width of its 95 % interval (JCGM 100, 6.2).
#[derive(Clone, Debug, PartialEq)]
pub struct Expanded {
    value: f64,
    /// u and k; None: no uncertainty is known.
    spread: Option<[f64; 2]>,
    /// The interval, where it is not as far to either side.
    interval: Option<[f64; 2]>,
    /// Whether U is a lower bound.
    at_least: bool,
}

impl Expanded {
    /// A value with its standard uncertainty and k; k where it is None is that of a normal distribution.
    pub fn new(value: f64, std: Option<f64>, factor: Option<f64>) -> Self {
        let factor = factor.filter(|factor| factor.is_finite() && *factor > 0.0).unwrap_or(NORMAL);
        let spread = std.filter(|std| std.is_finite() && *std > 0.0).map(|std| [std, factor]);
        Self { value, spread, interval: None, at_least: false }
    }

    /// A quantity of the document. k is its own `coverage_factor_95`, else that of the fit it comes from,
    /// else the normal one.
    pub fn of(quantity: &Quantity, of_the_fit: Option<f64>) -> Self {
        let factor = quantity.coverage_factor_95().or(of_the_fit);
        let interval = match quantity {
            Quantity::Stated { interval_95, .. } => *interval_95,
            Quantity::Bare(_) => None,
        };
        let at_least = quantity.is_at_least();
        Self { interval, at_least, ..Self::new(quantity.value(), quantity.std(), factor) }
    }

    /// A table of results.
    pub fn table(caption: &str) -> Table {
        Table::new(caption, "result | value ± U | unit | k")
    }

    /// Adds it to such a table.
    pub fn row(&self, table: &mut Table, of: &str, unit: &str) {
        let [value, k] = self.cells();
        table.row((of, value, unit, k));
    }

    /// `6401.196 ± 0.029` and k: U with two digits, the value to the same decimal (JCGM 100, 7.2.6).
    pub fn cells(&self) -> [Cell; 2] {
        if let Some([low, high]) = self.interval {
            let half = 0.5 * (high - low);
            let [value, low, high] = [self.value, low, high].map(|end| as_known(end, half));
            return [format!("{value} ({low} to {high})").into(), "interval".into()];
        }
        let Some([std, factor]) = self.spread else {
            return [bare(self.value).into(), blank_cell("7.8.4.1 a")];
        };
        let bound = if self.at_least { " (at least)" } else { "" };
        [format!("{}{bound}", uncertain(self.value, factor * std)).into(), figures(factor, 3).into()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn u_has_two_digits_and_the_value_its_decimal() {
        let stated = Quantity::new(6401.196031, 0.0146127);
        let lag = Quantity::new(204.2, 73.0).within([120.4, 351.7]);
        for (quantity, of_the_fit, cells) in [
            (stated.clone(), None, ["6401.196 ± 0.029", "1.96"]),
            (stated.clone(), Some(2.26), ["6401.196 ± 0.033", "2.26"]),
            // Its own factor goes before that of the fit.
            (stated.clone().covered_by(3.0), Some(2.26), ["6401.196 ± 0.044", "3.00"]),
            (stated.at_least(), None, ["6401.196 ± 0.029 (at least)", "1.96"]),
            (lag, None, ["200 (120 to 350)", "interval"]),
            (Quantity::Bare(50000.0), None, ["50000", "________________ (7.8.4.1 a)"]),
        ] {
            assert_eq!(Expanded::of(&quantity, of_the_fit).cells().map(|cell| cell.to_string()), cells);
        }
    }
}
