//! All columns of a problem side by side, of like size, which of them make up an explanation, and their products under
//! each form of noise: from there on nothing depends on the number of rows.

use estimate::{add_gram, mirrored};
use faer::Mat;
use rayon::prelude::*;

use crate::form::Form;
use crate::noises::Filter;
use crate::problem::{Cause, Problem, Term};

/// A candidate that acts, and on which channels it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    pub candidate: usize,
    pub channels: Vec<bool>,
}

/// A cause in one form, and its columns.
#[derive(Clone, Debug)]
pub struct Candidate {
    pub cause: Cause,
    pub form: Form,
    /// The columns' places for each channel.
    pub columns: Vec<Vec<usize>>,
    /// Whether the channels have one amplitude.
    pub tied: bool,
    /// ln of the number of alike ones among which it was found.
    pub looks: f64,
}

pub struct Stack {
    /// Each with a mean square of one.
    pub columns: Vec<Vec<f64>>,
    /// What each was divided by.
    pub scale: Vec<f64>,
    /// Places of the base.
    pub base: Vec<usize>,
    /// Those of them of whose coefficients nothing is known.
    pub plain: Vec<usize>,
    /// What is known of the others adds to the squares of their columns.
    pub known: Vec<(usize, f64)>,
    pub y: Vec<usize>,
    /// Places of white noise of one nT for each noisy reading, the first columns of the base, where it was asked
    /// for.
    pub noise: Vec<usize>,
    pub candidates: Vec<Candidate>,
}

impl Stack {
    /// Of a problem and causes in some forms.
    pub fn of(problem: &Problem, offered: &[(Cause, Form)]) -> Self {
        let mut stack = Self {
            columns: Vec::new(),
            scale: Vec::new(),
            base: Vec::new(),
            plain: Vec::new(),
            known: Vec::new(),
            y: Vec::new(),
            noise: Vec::new(),
            candidates: Vec::new(),
        };
        for (number, column) in problem.base_columns().into_iter().enumerate() {
            let place = stack.push(column);
            stack.base.push(place);
            match problem.known.get(number).filter(|known| **known > 0.0) {
                Some(known) => stack.known.push((place, (known / stack.scale[place]).powi(2))),
                None => stack.plain.push(place),
            }
        }
        for channel in &problem.channels {
            let mean = estimate::stats::mean(channel);
            let place = stack.push(channel.iter().map(|value| value - mean).collect());
            stack.y.push(place);
        }
        for (cause, form) in offered {
            stack.offer(problem, *cause, *form);
        }
        stack
    }

    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// The columns by which some candidates show in a channel.
    pub fn shown(&self, set: &[Named], channel: usize) -> Vec<usize> {
        let shown = set.iter().filter(|one| one.channels[channel]);
        shown.flat_map(|one| self.candidates[one.candidate].columns[channel].clone()).collect()
    }

    fn offer(&mut self, problem: &Problem, cause: Cause, form: Form) {
        let channels = problem.channels.len();
        let (mut columns, mut tied) = (vec![Vec::new(); channels], false);
        for term in problem.terms(cause, &form) {
            match term {
                Term::Alike(column) => {
                    let place = self.push(column);
                    columns.iter_mut().for_each(|of| of.push(place));
                }
                Term::Tied(own) => {
                    tied = true;
                    // One amplitude for all: one scale.
                    let square = |column: &Vec<f64>| column.iter().map(|value| value * value).sum::<f64>();
                    let all: f64 = own.iter().map(square).sum();
                    let scale =
                        (all / own.iter().map(Vec::len).sum::<usize>() as f64).sqrt().max(f64::MIN_POSITIVE);
                    for (of, mut column) in columns.iter_mut().zip(own) {
                        // Where it does nothing it has no column.
                        if square(&column) > 0.0 {
                            column.iter_mut().for_each(|value| *value /= scale);
                            of.push(self.columns.len());
                            self.columns.push(column);
                            self.scale.push(scale);
                        }
                    }
                }
            }
        }
        let looks = match cause {
            Cause::Course(number) => problem.courses[number].looks.max(1.0).ln(),
            _ => 0.0,
        };
        self.candidates.push(Candidate { cause, form, columns, tied, looks });
    }

    /// Adds what noise of so many of the base's readings looks like.
    pub fn shade(&mut self, noisy: usize) {
        for reading in 0..noisy {
            let mut stream = noise::Stream::new(1, &format!("reading {reading}"));
            let column = (0..self.rows()).map(|_| stream.normal()).collect();
            self.noise.push(self.columns.len());
            self.columns.push(column);
            self.scale.push(1.0);
        }
    }

    /// Adds a column; its place.
    pub fn push(&mut self, mut column: Vec<f64>) -> usize {
        let square = column.iter().map(|value| value * value).sum::<f64>() / column.len().max(1) as f64;
        let scale = if square > 0.0 { square.sqrt() } else { 1.0 };
        column.iter_mut().for_each(|value| *value /= scale);
        self.columns.push(column);
        self.scale.push(scale);
        self.columns.len() - 1
    }
}

/// Products of whitened columns, and the determinant of the covariance.
#[derive(Clone, Debug)]
pub struct Product {
    /// Xᵀ C⁻¹ X.
    pub gram: Mat<f64>,
    /// ln |C|, and ln of the prior odds of the noise.
    pub log_determinant: f64,
    pub log_prior: f64,
}

/// Products of a stack's columns under each noise.
pub fn products(stack: &Stack, filters: &[Filter]) -> Vec<Product> {
    let all: Vec<usize> = (0..stack.columns.len()).collect();
    filters.par_iter().map(|filter| product(stack, &all, filter)).collect()
}

/// The same of some of the columns, with zeros for the others.
pub fn product(stack: &Stack, among: &[usize], filter: &Filter) -> Product {
    let columns: Vec<&[f64]> = among.iter().map(|column| stack.columns[*column].as_slice()).collect();
    let mut own = Mat::<f64>::zeros(among.len(), among.len());
    filter.whitening.by_rows(&columns, |some| add_gram(&mut own, some));
    let own = mirrored(own);
    let mut gram = Mat::zeros(stack.columns.len(), stack.columns.len());
    for (i, row) in among.iter().enumerate() {
        among.iter().enumerate().for_each(|(j, column)| gram[(*row, *column)] = own[(i, j)]);
    }
    for (column, known) in &stack.known {
        gram[(*column, *column)] += known;
    }
    let log_prior = filter.form.prior(filter.whitening.rows());
    Product { gram, log_determinant: filter.whitening.log_determinant(), log_prior }
}
