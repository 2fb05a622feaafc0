//! What others do with a residual: stepwise regression and sequentially thresholded least squares on simple regressors. Proofs hold
//! their own answers against these on the same cases.

mod library;
mod regression;

use std::collections::{BTreeMap, BTreeSet};

pub use regression::Regression;

/// Series of one recording by the names of their columns; readings end in `_x_nt`, `_y_nt`, `_z_nt`.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// What was recorded.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// What the model without the effect has for the readings x, y, z, nT.
    pub predicted: [Vec<f64>; 3],
}

/// A way to choose regressors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Forward and backward steps by the Bayesian information criterion.
    Stepwise,
    /// Sequentially thresholded ridge regression (SINDy), the threshold by the same criterion.
    Thresholded,
}

/// The effects whose simple regressors a method chooses, as `name target`. A regressor of several names goes by the one that acts on
/// all sensors where it is chosen in more than one.
pub fn chosen(recordings: &[Series], method: Method) -> BTreeSet<String> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut named = BTreeSet::new();
    for axis in 0..3 {
        let (regression, terms) = library::of_sensor(recordings, axis);
        let columns = match method {
            Method::Stepwise => regression.stepwise(),
            Method::Thresholded => regression.thresholded_by_criterion(),
        };
        let here: BTreeSet<&library::Term> = columns.iter().map(|column| &terms[*column]).collect();
        for term in here {
            *counts.entry(term.of_all.clone()).or_default() += 1;
            named.insert(term.clone());
        }
    }
    named
        .into_iter()
        .map(|term| match term.of_one {
            Some(one) if counts[&term.of_all] < 2 => one,
            _ => term.of_all,
        })
        .collect()
}
