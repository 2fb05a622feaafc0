//! What may come into the model, before it is fitted.

use physics::EffectInstance;

use crate::model::Column;

/// What comes into the model.
#[derive(Clone, Debug)]
pub enum Addition {
    /// An effect.
    Effect(EffectInstance),
    /// A column.
    Column(Column),
}

/// Something that may explain what is left, before it is refined.
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
    /// As how many independent looks its search counts; zero for a candidate, whose shapes are counted by themselves.
    pub looks: f64,
    /// Whether it touches few rows, so that rows left out say nothing.
    pub local: bool,
}

impl Proposal {
    /// Whether it was found among moments, frequencies or codes rather than among the candidates.
    pub fn is_event(&self) -> bool {
        self.looks > 0.0
    }
}
