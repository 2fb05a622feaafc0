use serde::{Deserialize, Serialize};
use std::fmt;

use crate::{Axis, Extra, PerAxis};

/// A change of an rms by less than this share is none to speak of.
const SMALL: f64 = 0.01;

/// What one thing adds to the difference of two magnetometers: its rms with it and without, everything else
/// being the same.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Contribution {
    /// What it is.
    pub cause: ContributionCause,
    /// The column that the difference follows, where it follows one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// The same with its size, in words.
    pub what: String,
    /// Whether the matrix and the difference that are stated are without it.
    pub taken_off: bool,
    /// Rms of the difference about its mean with it, nT.
    pub rms_with_nt: PerAxis<f64>,
    /// The same without it, nT.
    pub rms_without_nt: PerAxis<f64>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// What may add to a difference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ContributionCause {
    /// The clocks differ.
    #[default]
    Clock,
    /// Changes of level.
    Steps,
    /// Spikes and disturbed intervals.
    Disturbances,
    /// A straight drift, an exponential one, or both.
    Drift,
    /// The short periods, at which the instruments do not answer alike.
    ShortPeriods,
    /// A housekeeping column.
    Column,
}

impl fmt::Display for ContributionCause {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(to)
    }
}

impl Contribution {
    /// Its column, else its cause.
    pub fn name(&self) -> String {
        self.column.clone().unwrap_or_else(|| self.cause.to_string())
    }

    /// By how much the sum of the three mean squares is lower without it, nT².
    pub fn reduction_nt2(&self) -> f64 {
        let squares = |rms: &PerAxis<f64>| rms.iter().map(|(_, rms)| rms * rms).sum::<f64>();
        squares(&self.rms_with_nt) - squares(&self.rms_without_nt)
    }

    /// Axes whose rms it changes by one in a hundred at least, with the rms with it and without, nT.
    pub fn changes(&self) -> impl Iterator<Item = (Axis, f64, f64)> {
        let both = |(axis, with): (Axis, &f64)| Some((axis, *with, self.rms_without_nt.get(axis).copied()?));
        let large = |(_, with, without): &(Axis, f64, f64)| (with - without).abs() >= SMALL * with;
        self.rms_with_nt.iter().filter_map(both).filter(large)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_and_by_how_much() {
        let rms = |values: [f64; 3]| Axis::ALL.into_iter().zip(values).collect();
        let one = Contribution {
            rms_with_nt: rms([3.0, 1.0, 2.0]),
            rms_without_nt: rms([1.0, 0.999, 2.1]),
            ..Contribution::default()
        };
        assert!((one.reduction_nt2() - (8.0 + 1.0 - 0.998001 - 0.41)).abs() < 1e-9);
        let changes: Vec<_> = one.changes().collect();
        assert_eq!(changes, [(Axis::X, 3.0, 1.0), (Axis::Z, 2.0, 2.1)]);
    }
}
