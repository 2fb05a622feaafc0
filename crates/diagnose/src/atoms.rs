//! What a set may hold: effects, events and smooth structure, each with its columns and with
//! what is known of their sizes beforehand.

use common::Axis;
use physics::{Acts, EffectInstance, ParameterInfo, Role};
use std::collections::{BTreeMap, BTreeSet};

use crate::candidates::{Candidate, Shape};
use crate::covariates;
use crate::decide::{BEYOND, NAMELESS, SIZE_STEP, STEPS_BEYOND};
use crate::pool::Pool;
use crate::proposal::{Addition, Proposal, What};
use crate::stacked::Stacked;

/// The rms of a column that is nothing, of which sizes are still numbers.
const NOTHING: f64 = 1e-100;

/// One of the things that may explain.
#[derive(Clone, Debug)]
pub struct Atom {
    pub what: What,
    pub name: String,
    /// ln of its probability beforehand, given that there is one thing.
    pub log_prior: f64,
    pub shapes: Vec<Shape>,
    /// How many shapes there were before any was screened out.
    pub tried: usize,
    /// ln of the probability of a size beforehand, and the standard deviation of each coefficient.
    pub sizes: Vec<(f64, Vec<f64>)>,
    /// Whether a column is what the effect does, so that its coefficient must be about one.
    pub finite: bool,
}

impl Atom {
    pub fn is_named(&self) -> bool {
        self.what.is_named()
    }

    /// Whether it is structure that follows the product of two, and each of them.
    pub fn is_product(&self) -> bool {
        matches!(&self.what, What::Smooth { covariate, .. } if covariate.contains(covariates::TIMES))
    }

    /// The sensor that it acts on alone; None for what acts on several.
    pub fn sensor(&self) -> Option<Axis> {
        match &self.what {
            What::Smooth { axis, .. } => Some(*axis),
            What::Physics(effect) => of_one_sensor(effect),
            What::Event(additions) => match additions.first()? {
                Addition::Effect(effect) => of_one_sensor(effect),
                Addition::Single(_) => None,
            },
        }
    }

    /// Whether structure is along what an effect itself follows.
    pub fn follows(&self, structure: &Self) -> bool {
        match (&self.what, &structure.what) {
            (What::Physics(effect), What::Smooth { covariate, .. }) => {
                covariates::of(effect).contains(covariate)
            }
            _ => false,
        }
    }

    /// Whether structure is what it does in its sensor in an open form: along a recorded column that it follows.
    pub fn is_open_form(&self, structure: &Self) -> bool {
        match &structure.what {
            What::Smooth { covariate, axis } => {
                !covariates::is_field(covariate)
                    && self.sensor().is_none_or(|own| own == *axis)
                    && self.follows(structure)
            }
            _ => false,
        }
    }

    /// Whether it is a fuller form of another: that is what it is at a special value of its parameters.
    pub fn is_fuller(&self, other: &Self) -> bool {
        match (&self.what, &other.what) {
            (What::Physics(own), What::Physics(other)) => {
                own.simpler() == Some(other.kind) && own.target() == other.target()
            }
            _ => false,
        }
    }
}

/// The sensor of an effect that acts on one alone.
pub fn of_one_sensor(effect: &EffectInstance) -> Option<Axis> {
    effect.axis.filter(|_| effect.kind.about().acts == Acts::OneSensor)
}

/// Sizes from the least to the largest that are plausible, and a few beyond at a price.
fn sizes(ranges: &[[f64; 2]]) -> Vec<(f64, Vec<f64>)> {
    let decades = ranges.iter().map(|[low, high]| (high / low).ln()).fold(0.0, f64::max);
    let steps = (decades / SIZE_STEP.ln()).ceil().max(1.0) as usize;
    let prior = -((steps + 1) as f64).ln();
    let within = (0..=steps).map(|k| {
        let share = k as f64 / steps as f64;
        (prior, ranges.iter().map(|[low, high]| low.powf(1.0 - share) * high.powf(share)).collect())
    });
    let beyond = (1..=STEPS_BEYOND).map(|k| {
        let factor = SIZE_STEP.powi(k as i32);
        (prior - BEYOND * k as f64, ranges.iter().map(|[_, high]| high * factor).collect())
    });
    within.chain(beyond).collect()
}

#[derive(Clone, Debug)]
pub struct Atoms<'p> {
    pub all: Vec<Atom>,
    pool: &'p Pool,
    /// Columns behind those of the pool.
    more: Vec<Stacked>,
}

/// What sizes are measured by.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// What a reading resolves over what the catalogue's sizes are for; those grow with it.
    pub coarse: f64,
    /// Standard deviation of a reading, nT.
    pub noise_nt: f64,
    /// Rms of the residual of the base model, nT.
    pub residual_nt: f64,
}

impl<'p> Atoms<'p> {
    /// Of all candidates of a pool, whose columns begin the list of all columns.
    pub fn of(pool: &'p Pool, measure: &Sizes) -> Self {
        let mut all: Vec<Atom> =
            pool.candidates.iter().map(|candidate| atom(pool, candidate, measure)).collect();
        // Each family of names is as probable as any other, and so is each of its targets; structure has as
        // much together as names.
        let mut families: BTreeMap<String, usize> = BTreeMap::new();
        for atom in &all {
            *families.entry(family(atom)).or_default() += 1;
        }
        let named = families.keys().filter(|name| !name.is_empty()).count().max(1) as f64;
        for atom in &mut all {
            let members = families[&family(atom)] as f64;
            atom.log_prior = if atom.is_named() { -(named * members).ln() } else { -members.ln() - NAMELESS };
        }
        Self { all, pool, more: Vec::new() }
    }

    pub fn column(&self, number: usize) -> &Stacked {
        match number.checked_sub(self.pool.columns.len()) {
            None => &self.pool.columns[number],
            Some(behind) => &self.more[behind],
        }
    }

    pub fn columns(&self) -> usize {
        self.pool.columns.len() + self.more.len()
    }

    pub fn more(&self) -> &[Stacked] {
        &self.more
    }

    fn add_columns(&mut self, columns: Vec<Stacked>) -> Vec<usize> {
        let from = self.columns();
        let count = columns.len();
        self.more.extend(columns);
        (from..from + count).collect()
    }

    /// Adds the shapes at which a fit has an effect: its columns there, and the derivatives by the shapes.
    pub fn add_fitted(&mut self, effect: &EffectInstance, columns: Vec<Stacked>, by_shape: Vec<Stacked>) {
        let is_it = |atom: &Atom| match &atom.what {
            What::Physics(own) => own.kind == effect.kind && own.target() == effect.target(),
            _ => false,
        };
        let Some(number) = self.all.iter().position(is_it) else { return };
        let columns = self.add_columns(columns);
        let by_shape = self.add_columns(by_shape);
        let shape = Shape { value: None, columns, form: Some(effect.clone()), by_shape };
        self.all[number].shapes.push(shape);
        self.all[number].tried += 1;
    }

    /// Adds things of one kind that happen at moments, each with a search of its own.
    pub fn add_event(
        &mut self,
        events: &[&Proposal],
        columns: Vec<Stacked>,
        ranges: &[[f64; 2]],
        finite: bool,
    ) {
        let families: BTreeSet<String> = self.all.iter().filter(|atom| atom.is_named()).map(family).collect();
        let looks: f64 = events.iter().map(|event| event.looks.max(1.0).ln()).sum();
        let name = match events {
            [first, others @ ..] if others.iter().all(|other| other.name == first.name) => first.name.clone(),
            [first, .., _] => format!("{} and {} more", first.name, events.len() - 1),
            _ => events.iter().map(|event| event.name.clone()).collect(),
        };
        let columns = self.add_columns(columns);
        let sizes = if finite { vec![(0.0, vec![1.0; columns.len()])] } else { sizes(ranges) };
        self.all.push(Atom {
            what: What::Event(events.iter().map(|event| event.addition.clone()).collect()),
            name,
            log_prior: -(families.len().max(1) as f64).ln() - looks,
            shapes: vec![Shape { columns, ..Shape::default() }],
            tried: 1,
            sizes,
            finite,
        });
    }
}

/// The family of an atom: the effect, whatever its target; empty for structure.
fn family(atom: &Atom) -> String {
    match &atom.what {
        What::Physics(effect) => effect.kind.name().into(),
        What::Event(_) => "event".into(),
        What::Smooth { .. } => String::new(),
    }
}

/// Plausible sizes of the amplitudes of an effect.
pub fn ranges(effect: &EffectInstance, coarse: f64) -> Vec<[f64; 2]> {
    let amplitudes = effect.kind.parameters().iter().filter(|info| info.role == Role::Amplitude);
    let range = |info: &ParameterInfo| {
        let high = if info.name.contains("nt") { info.high * coarse } else { info.high };
        [info.low, high]
    };
    amplitudes.map(range).collect()
}

fn atom(pool: &Pool, candidate: &Candidate, measure: &Sizes) -> Atom {
    let first: &[usize] = candidate.shapes.first().map_or(&[], |shape| &shape.columns);
    let rms = |column: &usize| rms(&pool.columns[*column]).max(NOTHING);
    let sizes = match &candidate.what {
        What::Physics(_) if candidate.finite => vec![(0.0, vec![1.0; first.len()])],
        What::Physics(effect) if effect.kind.about().acts == Acts::WithColumn("") => {
            // A column of any unit: by what the sensor that follows it most would do.
            let most = first.iter().map(rms).fold(NOTHING, f64::max);
            let range = [0.01 * measure.noise_nt / most, 10.0 * measure.residual_nt / most];
            sizes(&vec![range; first.len()])
        }
        What::Physics(effect) => sizes(&ranges(effect, measure.coarse)),
        What::Event(_) => Vec::new(),
        What::Smooth { .. } => {
            // Smooth: the size falls with the order.
            let of = |(order, c): (usize, &usize)| {
                let fall = 1.0 / (order + 1) as f64;
                [0.03 * measure.noise_nt * fall / rms(c), 3.0 * measure.residual_nt * fall / rms(c)]
            };
            sizes(&first.iter().enumerate().map(of).collect::<Vec<_>>())
        }
    };
    let Candidate { what, finite, shapes, tried } = candidate.clone();
    Atom { name: what.name(), what, log_prior: 0.0, shapes, tried, sizes, finite }
}

/// Rms of a column where it is something.
fn rms(column: &Stacked) -> f64 {
    let (sum, count) = column.squares();
    (sum / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_go_over_the_plausible_range_and_beyond_it_at_a_price() {
        let all = sizes(&[[0.1, 10.0], [1.0, 2.0]]);
        let within = all.len() - STEPS_BEYOND;
        let total: f64 = all[..within].iter().map(|(log, _)| log.exp()).sum();
        assert!((total - 1.0).abs() < 1e-12);
        let close = |found: &[f64], expected: [f64; 2]| {
            found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-12)
        };
        assert!(close(&all[0].1, [0.1, 1.0]) && close(&all[within - 1].1, [10.0, 2.0]));
        assert!(close(&all[within].1, [40.0, 8.0]) && (all[0].0 - all[within].0 - BEYOND).abs() < 1e-12);
    }
}
