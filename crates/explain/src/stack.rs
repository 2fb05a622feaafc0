//! All columns of a problem side by side, of like size, and which of them make up an explanation.

use crate::form::Form;
use crate::problem::{Cause, Problem, Term};

/// A cause in one form, and its columns.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// What acts.
    pub cause: Cause,
    /// In which form.
    pub form: Form,
    /// The columns' places for each channel.
    pub columns: Vec<Vec<usize>>,
    /// Whether the channels have one amplitude.
    pub tied: bool,
    /// ln of the number of alike ones among which it was found.
    pub looks: f64,
}

/// The columns.
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
    /// Places of the channels' readings.
    pub y: Vec<usize>,
    /// Places of white noise of one nT for each noisy reading, the first columns of the base, where it was asked
    /// for.
    pub noise: Vec<usize>,
    /// What may explain them.
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

    /// Adds what noise of the base's readings looks like.
    pub fn shade(&mut self, problem: &Problem) {
        for reading in 0..problem.noisy {
            let mut stream = noise::Stream::new(1, &format!("reading {reading}"));
            self.noise.push(self.columns.len());
            self.columns.push((0..problem.rows()).map(|_| stream.normal()).collect());
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
