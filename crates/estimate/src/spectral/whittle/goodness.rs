//! Whether a model describes the ordinates.

use super::likelihood::Model;
use crate::stats::chi_squared_p;

/// Fewest ordinates of a group.
const LEAST_ORDINATES: f64 = 30.0;

/// Neighbouring ordinates of a series against the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// The series.
    pub series: usize,
    /// Mean frequency (Hz).
    pub frequency_hz: f64,
    /// Mean of the ordinates over the modelled density, I/P.
    pub ratio: f64,
    /// Ordinates.
    pub count: f64,
}

impl Group {
    /// The ratio as a standard normal variable: for m ordinates, m I/P has the gamma distribution of shape m,
    /// and 3 √m ((I/P)^(1/3) − 1 + 1/(9 m)) is normal to a part in a thousand.
    ///
    /// Source: E. B. Wilson and M. M. Hilferty, The distribution of chi-square, Proc. Natl. Acad. Sci. 17
    /// (1931) 684–688.
    pub fn deviation(&self) -> f64 {
        3.0 * self.count.sqrt() * (self.ratio.cbrt() - 1.0 + 1.0 / (9.0 * self.count))
    }
}

/// The ordinates of all series in groups.
pub(super) fn groups(model: &Model, theta: &[f64]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (bin, flicker, white) in model.parts(theta) {
        let new = Group {
            series: bin.series,
            frequency_hz: (bin.x + model.data.lowest).exp(),
            ratio: bin.density / (flicker + white),
            count: bin.count,
        };
        match groups.last_mut().filter(|last| last.series == bin.series && last.count < LEAST_ORDINATES) {
            Some(last) => *last = joined(last, &new),
            None => groups.push(new),
        }
    }
    // What is left over at the end of a series goes to the group before.
    let mut whole: Vec<Group> = Vec::with_capacity(groups.len());
    for group in groups {
        match whole.last_mut().filter(|last| last.series == group.series && group.count < LEAST_ORDINATES) {
            Some(last) => *last = joined(last, &group),
            None => whole.push(group),
        }
    }
    whole
}

fn joined(a: &Group, b: &Group) -> Group {
    let count = a.count + b.count;
    let mean = |x: f64, y: f64| (x * a.count + y * b.count) / count;
    Group {
        series: a.series,
        frequency_hz: mean(a.frequency_hz, b.frequency_hz),
        ratio: mean(a.ratio, b.ratio),
        count,
    }
}

/// Probability of a greater Σ of squared deviations, `unknowns` of them fitted; None with no more groups than
/// that.
pub(super) fn p_value(groups: &[Group], unknowns: usize) -> Option<f64> {
    let freedom = groups.len().checked_sub(unknowns).filter(|freedom| *freedom > 0)?;
    Some(chi_squared_p(groups.iter().map(|group| group.deviation().powi(2)).sum(), freedom as f64))
}
