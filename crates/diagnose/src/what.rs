//! What a candidate is.

use common::Axis;
use physics::EffectInstance;

/// What a candidate is.
#[derive(Clone, Debug)]
pub enum What {
    /// An effect of the catalogue.
    Physics(EffectInstance),
    /// An axis follows smooth functions of something.
    Smooth {
        /// Of what.
        covariate: String,
        /// The axis.
        axis: Axis,
    },
}

impl What {
    /// Its name with its target.
    pub fn name(&self) -> String {
        match self {
            What::Physics(effect) => match &effect.recording {
                Some(recording) => format!("{} in \"{recording}\"", named(effect)),
                None => named(effect),
            },
            What::Smooth { covariate, axis } => format!("{axis} with {covariate}"),
        }
    }
}

/// An effect with what it acts on.
pub fn named(effect: &EffectInstance) -> String {
    let target = effect.axis.map(|axis| axis.to_string()).or_else(|| effect.column.clone());
    target.map_or_else(|| effect.kind.name().to_string(), |target| format!("{} {target}", effect.kind.name()))
}
