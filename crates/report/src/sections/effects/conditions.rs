//! Findings of sensorcal on temperatures and on fields across.

use common::{CrossFieldFit, TemperatureFit};

use super::{NOT_SHOWN, NOT_SIGNIFICANT, Rule, departure, largest};
use crate::Effect;

/// What findings on temperatures do.
pub const TEMPERATURE: [Rule<TemperatureFit>; 2] = [
    ("beside the polynomials the readings show: ", |fit, words| departure(&fit.departures, words)),
    ("moved together", |_, _| NOT_SHOWN),
];

/// What findings on fields across do.
pub const CROSS_FIELD: [Rule<CrossFieldFit>; 5] = [
    ("cannot be told", |_, _| NOT_SHOWN),
    ("do not change sensor ", |_, _| NOT_SIGNIFICANT),
    ("fields across change sensor ", |fit, _| Effect::nt(coefficient(fit))),
    ("k also depends on the square of the field across", |fit, _| {
        let found = fit.departures.iter().filter(|one| one.found).flat_map(|one| one.parameter.values());
        Effect::std(largest(found.filter_map(|value| Some(value.value() / value.std()?))))
    }),
    ("temperatures are not recorded in", |_, _| NOT_SHOWN),
];

/// The largest coefficient, at 50 000 nT across.
fn coefficient(fit: &CrossFieldFit) -> Option<f64> {
    largest(fit.offset.values().chain(fit.sensitivity.values()).map(common::Quantity::value))
}

#[cfg(test)]
mod tests {
    use super::super::tests::said_by;
    use super::*;

    #[test]
    fn phrases() {
        said_by("sensorcal", &TEMPERATURE);
        said_by("sensorcal", &CROSS_FIELD);
    }
}
