//! Columns recorded beside a pair that the test instrument follows: which of them, and in which form, the engine
//! `explain` says. What they explain is taken off before clocks and events are looked for, and the columns stay in
//! the design, so that each coefficient is what was taken off and what is left of it.

use common::{Document, Followed, Quantity};
use explain::{Cause, Covariate, Form};
use joined::Pair;

use crate::Error;

/// Half the change of ln τ over which the derivative with respect to it is taken.
const APART: f64 = 0.02;

/// A column that the test instrument follows.
#[derive(Clone)]
pub struct Follows {
    /// Its name.
    pub name: String,
    form: Form,
    /// Probability of such a gain by chance.
    p: f64,
    /// The column in its form less its mean, with its square where it is bent; where there is a lag, its
    /// derivative with respect to ln τ besides.
    pub columns: Vec<Vec<f64>>,
    /// The mean of the column in its form.
    pub at: f64,
    /// What was taken off of each column but the derivative, for each axis, nT per unit.
    taken: [Vec<f64>; 3],
}

/// What was recorded beside a pair, and what of it the test instrument follows.
pub struct Recorded {
    /// Name and values in the pair's rows of each column.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Those that are followed.
    pub follows: Vec<Follows>,
}

impl Recorded {
    /// Of the recordings of a document that make the pair.
    pub fn of(document: &Document, pair: &Pair) -> Result<Self, Error> {
        let covariates: Vec<Covariate> = joined::beside(document, &pair.recordings)
            .into_iter()
            .map(|one| Covariate { name: one.name, time_s: one.time_s, values: one.values })
            .collect();
        if covariates.is_empty() || pair.samples() < explain::pair::LEAST {
            return Ok(Self { columns: Vec::new(), follows: Vec::new() });
        }
        let read = explain::pair::Pair {
            first_s: pair.first_s,
            step_s: pair.step_s,
            reference: pair.reference.each_ref().map(|column| column.to_vec()),
            test: pair.test.iter().map(|column| column.to_vec()).collect(),
            whole: pair.whole.clone(),
            covariates,
        };
        let explained = explain::pair::pair(&read, &|_| ())?.explained;
        let time_s: Vec<f64> = (0..pair.whole.len()).map(|row| pair.time_s(row)).collect();
        let named = explained.causes.iter().zip(&explained.gains).filter_map(|(one, gain)| match one.cause {
            Cause::Covariate(number) => Some(Follows::of(&read.covariates[number], &time_s, one, *gain)),
            _ => None,
        });
        let at = |one: &Covariate| explain::sampled(&one.time_s, &one.values, &time_s, one.holds());
        let columns = read.covariates.iter().map(|one| (one.name.clone(), at(one))).collect();
        Ok(Self { follows: named.collect(), columns })
    }

    /// The pair less what all columns that are followed explain.
    pub fn less(&self, pair: &Pair) -> Pair {
        self.follows.iter().fold(pair.clone(), |pair, follows| follows.added(&pair, -1.0))
    }
}

impl Follows {
    fn of(covariate: &Covariate, time_s: &[f64], one: &explain::Amplitude, gain: f64) -> Self {
        let late_s = one.late_s.as_ref().map_or(0.0, Quantity::value);
        let form = Form { late_s, ..one.form };
        let (mut columns, at) = form.about(covariate, time_s);
        if late_s > 0.0 {
            let moved = |by: f64| form.late(late_s * by.exp()).of(covariate, time_s).swap_remove(0);
            let pair = moved(APART).into_iter().zip(moved(-APART));
            columns.push(pair.map(|(later, earlier)| (later - earlier) / (2.0 * APART)).collect());
        }
        let taken = std::array::from_fn(|axis| one.channels[axis].iter().map(Quantity::value).collect());
        Self { name: covariate.name.clone(), form, p: (-gain).exp().min(1.0), columns, at, taken }
    }

    /// A pair with so many times what was taken off for this column.
    pub fn added(&self, pair: &Pair, times: f64) -> Pair {
        let mut pair = pair.clone();
        for (test, taken) in pair.test.iter_mut().zip(&self.taken) {
            for (column, size) in self.columns.iter().zip(taken) {
                test.iter_mut().zip(column).for_each(|(test, value)| *test += times * size * value);
            }
        }
        pair
    }

    /// The coefficient of the column itself in an axis, of what is left of it.
    pub fn size(&self, axis: usize, left: &Quantity) -> Quantity {
        Quantity::new(self.taken[axis][0] + left.value(), left.std().unwrap_or(0.0))
    }

    /// As a document has it, by what is left of the coefficients of its columns.
    pub fn document(&self, axis: usize, left: &[Quantity]) -> Followed {
        let nt_per_unit = self.size(axis, &left[0]);
        let square = self
            .form
            .bent
            .then(|| Quantity::new(self.taken[axis][1] + left[1].value(), left[1].std().unwrap_or(0.0)));
        let lag_s = left.get(1 + usize::from(self.form.bent)).map(|slope| {
            let relative = slope.std().unwrap_or(0.0) / nt_per_unit.value().abs();
            Quantity::new(self.form.late_s, self.form.late_s * relative)
        });
        Followed {
            column: self.name.clone(),
            lag_s,
            late_rows: self.form.rows,
            nt_per_unit2: square,
            nt_per_unit,
            at: self.at,
            p: self.p,
            ..Followed::default()
        }
    }
}
