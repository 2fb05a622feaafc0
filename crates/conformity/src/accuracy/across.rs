use common::{Axis, CrossFieldFit, Quantity};

use crate::joint::{ACROSS, effect};

/// What fields across do to a sensor.
pub struct Across {
    /// The paths of the parameters.
    pub paths: Vec<String>,
    /// Their values where they are not corrected, nT.
    left: [f64; 5],
}

impl Across {
    /// As sensorcal found it; `corrected` where the model has it.
    pub fn of(fit: &CrossFieldFit, axis: Axis, corrected: bool) -> Self {
        let left = ACROSS.map(|(group, _, parameter)| {
            let of = if group == "offset" { &fit.offset } else { &fit.sensitivity };
            of.get(parameter).filter(|_| !corrected).map_or(0.0, Quantity::value)
        });
        Self { paths: ACROSS.map(|(_, name, parameter)| effect(name, axis, parameter)).into(), left }
    }

    /// Change of the reading for each nT of the parameters; b along and u, v across in units of 50 000 nT.
    pub fn weights(b: f64, u: f64, v: f64) -> [f64; 5] {
        [u * u, v * v, u * v, b * u, b * v]
    }

    /// What is not corrected changes a reading by, nT.
    pub fn left(&self, weights: &[f64; 5]) -> f64 {
        weights.iter().zip(&self.left).map(|(by, left)| by * left).sum()
    }
}
