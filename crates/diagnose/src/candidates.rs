//! Something that could have been left out, with its shapes; and which of them a search on some of the rows has kept.

use physics::EffectInstance;
use std::collections::{BTreeMap, BTreeSet};

use crate::proposal::What;

/// Columns at a shape.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Time constant, level, period, lag.
    pub value: Option<f64>,
    /// Numbers of the columns.
    pub columns: Vec<usize>,
    /// The effect with further shapes: in a fuller form, or as a fit has found it.
    pub form: Option<EffectInstance>,
    /// Derivatives by the logarithm of its shapes there, for the coefficients of that fit.
    pub by_shape: Vec<usize>,
}

impl Shape {
    pub fn is_fitted(&self) -> bool {
        self.value.is_none() && self.form.is_some()
    }
}

#[derive(Clone, Debug)]
pub struct Candidate {
    pub what: What,
    /// Whether its columns are what the effect does at a shape, rather than derivatives by its amplitudes.
    pub finite: bool,
    pub shapes: Vec<Shape>,
    /// How many there were before.
    pub tried: usize,
}

impl Candidate {
    /// What tells it from all others of a pool.
    pub fn key(&self) -> (String, bool) {
        (self.what.name(), self.shapes.first().is_some_and(|shape| shape.value.is_some()))
    }
}

/// Candidates of which a search on some of the rows has found some worth weighing.
#[derive(Clone, Debug)]
pub struct Kept {
    pub candidates: Vec<Candidate>,
    /// The numbers of those that are kept, each with those of its shapes.
    pub shapes: BTreeMap<usize, BTreeSet<usize>>,
}

impl Kept {
    pub fn names(&self) -> BTreeSet<String> {
        self.shapes.keys().map(|number| self.candidates[*number].what.name()).collect()
    }

    /// The kept shapes of an effect, each with its fuller form.
    pub fn shapes_of(&self, what: &What) -> Vec<(Option<f64>, Option<EffectInstance>)> {
        let name = what.name();
        let own = self.shapes.iter().find(|(number, _)| self.candidates[**number].what.name() == name);
        let of = |(number, shapes): (&usize, &BTreeSet<usize>)| {
            let shapes = shapes.iter().map(|shape| &self.candidates[*number].shapes[*shape]);
            shapes.map(|shape| (shape.value, shape.form.clone())).collect()
        };
        own.map(of).unwrap_or_default()
    }

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
            let shapes = there.remove(&candidate.key()).map(|own| own.shapes).unwrap_or_default();
            Candidate { shapes, ..candidate.clone() }
        };
        self.candidates.iter().map(of).collect()
    }
}
