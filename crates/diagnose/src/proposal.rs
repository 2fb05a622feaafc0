//! What may come into the model, before it is fitted.

use physics::EffectInstance;

use crate::model::Single;
use crate::what::named;

/// What comes into the model.
#[derive(Clone, Debug)]
pub enum Addition {
    /// An effect.
    Effect(EffectInstance),
    /// A single reading.
    Single(Single),
}

/// Something found at a moment, at a frequency or in codes, before it is weighed.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// Its name with its target.
    pub name: String,
    /// What comes in.
    pub addition: Addition,
    /// Probability by chance within its family, the search included.
    pub p: f64,
    /// By how much it lowers the sum of squares.
    pub gain: f64,
    /// As how many independent looks its search counts.
    pub looks: f64,
    /// Whether it touches few rows, so that rows left out say nothing.
    pub local: bool,
    /// What it is told as one with, such as a sensor's single readings.
    pub group: Option<String>,
}

impl Proposal {
    /// An effect that touches few rows of one recording.
    pub fn event(effect: EffectInstance, recording: &str, p: f64, gain: f64, looks: f64) -> Self {
        let name = format!("{} in \"{recording}\"", named(&effect));
        Self { name, addition: Addition::Effect(effect), p, gain, looks, local: true, group: None }
    }
}
