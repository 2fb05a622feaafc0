//! Departures from a line or a model: what was looked for, and what was found.

use common::Departure;
use page::words::key;

use crate::{Cell, Table};

/// A table of departures; rows are added by [`add`].
pub fn table(of: &str) -> Table {
    Table::new(
        "Departures that were tested; p is adjusted for the number of tests (trials factor)",
        [
            (of, ""),
            ("departure", ""),
            ("parameter", ""),
            ("value", ""),
            ("unit", ""),
            ("p", ""),
            ("found", ""),
        ],
    )
}

/// The departures of one coil or sensor.
pub fn add(table: &mut Table, of: &str, departures: &[Departure]) {
    for departure in departures {
        for (name, value) in &departure.parameter {
            let (name, unit) = key(name);
            table.row([
                of.into(),
                departure.departure.replace('_', " ").into(),
                name.into(),
                value.into(),
                unit.into(),
                Cell::Probability(departure.p_adjusted),
                if departure.found { "yes" } else { "no" }.into(),
            ]);
        }
    }
}
