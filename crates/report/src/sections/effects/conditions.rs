//! Findings of sensorcal on temperatures and on fields across.

use common::{CrossFieldFit, TemperatureFit};

use super::{NOT_SHOWN, NOT_SIGNIFICANT, Rule, departure, largest};
use crate::Effect;

/// What findings on temperatures do.
pub const TEMPERATURE: [Rule<TemperatureFit>; 2] = [
    ("besides the polynomials, the readings show ", |fit, words| departure(&fit.departures, words)),
    ("varied together", |_, _| NOT_SHOWN),
];

/// What findings on fields across do.
pub const CROSS_FIELD: [Rule<CrossFieldFit>; 5] = [
    ("cannot be determined", |_, _| NOT_SHOWN),
    ("do not affect sensor ", |_, _| NOT_SIGNIFICANT),
    ("transverse fields affect sensor ", |fit, _| Effect::nt(coefficient(fit))),
    ("k also depends on the square of the transverse field", |fit, _| {
        let found = fit.departures.iter().filter(|one| one.found).flat_map(|one| one.parameter.values());
        Effect::std(largest(found.filter_map(|value| Some(value.value() / value.std()?))))
    }),
    ("no temperatures were recorded in", |_, _| NOT_SHOWN),
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
