//! Something that could have been left out, with its shapes; and which of them a search on some of the rows has kept.

use physics::EffectInstance;
use std::collections::{BTreeMap, BTreeSet};

use crate::what::What;

/// One shape of a candidate.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Time constant, level or period.
    pub shape: Option<f64>,
    /// The effect in a fuller form, where that is what is tried.
    pub fuller: Option<EffectInstance>,
    /// Its columns in the pool.
    pub columns: Vec<usize>,
}

/// A candidate with all its shapes.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What it is.
    pub what: What,
    /// Whether its columns are what the effect does at a shape, rather than derivatives by its amplitudes.
    pub finite: bool,
    /// The shapes; none of what was screened out.
    pub trials: Vec<Trial>,
    /// How many there were before.
    pub tried: usize,
}

impl Candidate {
    /// What tells it from all others of a pool.
    pub fn key(&self) -> (String, bool) {
        (self.what.name(), self.trials.first().is_some_and(|trial| trial.shape.is_some()))
    }
}

/// Candidates of which a search on some of the rows has found some worth weighing.
#[derive(Clone, Debug)]
pub struct Kept {
    /// All of them.
    pub candidates: Vec<Candidate>,
    /// The numbers of those that are kept, each with those of its shapes.
    pub shapes: BTreeMap<usize, BTreeSet<usize>>,
}

impl Kept {
    /// The names of what is kept.
    pub fn names(&self) -> BTreeSet<String> {
        self.shapes.keys().map(|number| self.candidates[*number].what.name()).collect()
    }

    /// The kept shapes of an effect, each with its fuller form.
    pub fn shapes_of(&self, what: &What) -> Vec<(Option<f64>, Option<EffectInstance>)> {
        let name = what.name();
        let own = self.shapes.iter().find(|(number, _)| self.candidates[**number].what.name() == name);
        let of = |(number, shapes): (&usize, &BTreeSet<usize>)| {
            let trials = shapes.iter().map(|shape| &self.candidates[*number].trials[*shape]);
            trials.map(|trial| (trial.shape, trial.fuller.clone())).collect()
        };
        own.map(of).unwrap_or_default()
    }

    /// Whether a shape of a candidate is kept.
    pub fn keeps(&self, key: &(String, bool), shape: usize) -> bool {
        self.shapes
            .iter()
            .any(|(number, shapes)| self.candidates[*number].key() == *key && shapes.contains(&shape))
    }

    /// Candidates under the numbers that they had; what was screened out has no shapes.
    pub fn numbered(&self, candidates: Vec<Candidate>) -> Vec<Candidate> {
        let mut there: BTreeMap<(String, bool), Candidate> =
            candidates.into_iter().map(|candidate| (candidate.key(), candidate)).collect();
        let of = |candidate: &Candidate| {
            let trials = there.remove(&candidate.key()).map(|own| own.trials).unwrap_or_default();
            Candidate { trials, ..candidate.clone() }
        };
        self.candidates.iter().map(of).collect()
    }
}
