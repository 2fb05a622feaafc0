//! Circles of a theodolite, by their names: only where a horizontal and a vertical one are there.

use super::names::{is_among, plain};
use crate::mapping::ColumnMapping;

/// The document's column, the ending of its unit, and names in letters of lower case.
const NAMES: [(&str, &str, &str); 3] = [
    ("horizontal_deg", "deg", "horizontal horizontalcircle horizontalangle circlehorizontal hcircle hc hz"),
    (
        "vertical_deg",
        "deg",
        "vertical verticalcircle verticalangle circlevertical vcircle vc zenith zenithangle zenithdistance",
    ),
    ("residual_nt", "nt", "residual residualfield res reading fluxgate fluxgatereading dimagnetometer"),
];

/// What columns are, of their names and the endings of their units: place, and name in the document.
pub fn find(columns: &[(&str, Option<&str>)]) -> Vec<(usize, &'static str)> {
    let found = NAMES.iter().filter_map(|(to, ending, names)| {
        let is = |(base, unit): &(&str, Option<&str>)| {
            is_among(&plain(base), names) && unit.is_none_or(|unit| unit == *ending)
        };
        Some((columns.iter().position(is)?, *to))
    });
    let found: Vec<_> = found.collect();
    let circles = found.iter().filter(|(_, to)| to.ends_with("_deg")).count();
    if circles == 2 { found } else { Vec::new() }
}

/// A circle or the reading of the magnetometer on the telescope; circles that go `beyond` 360 are in gon.
pub fn map(mapping: &mut ColumnMapping, to: &str, beyond: bool) {
    mapping.to = to.into();
    if mapping.unit.is_none() {
        let (unit, why) = match (to.ends_with("_nt"), beyond) {
            (true, _) => ("nT", "nT is usual"),
            (false, true) => ("gon", "circles beyond 360 are in gon"),
            (false, false) => ("deg", "degrees are usual; write \"gon\" if it has 400"),
        };
        (mapping.unit, mapping.note) = (Some(unit.into()), Some(format!("no unit is stated; {why}")));
    }
}
