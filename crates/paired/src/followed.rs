//! A column recorded beside a pair that the test instrument follows. What it explains is taken off before clocks and
//! events are looked for, and its columns stay in the design of a fit, so that each coefficient is what was taken
//! off and what is left of it.

use common::{Followed, Quantity};
use explain::{Amplitude, Covariate, Form};
use joined::Pair;

/// Half the change of ln τ over which the derivative with respect to it is taken.
const APART: f64 = 0.02;

/// A column that the test instrument follows.
#[derive(Clone, Debug)]
pub struct Follows {
    /// Its name.
    pub name: String,
    form: Form,
    /// Probability of such a gain by chance.
    p: f64,
    /// The column in its form less its mean, with its square where it is bent or its fast part; where there is a lag, its
    /// derivative with respect to ln τ besides.
    pub columns: Vec<Vec<f64>>,
    /// The mean of the column in its form.
    pub at: f64,
    /// What was taken off of each column but the derivative, for each axis, nT per unit.
    taken: Vec<Vec<f64>>,
}

impl Follows {
    /// What the engine says of a covariate, with ln of the odds for it.
    pub fn of(covariate: &Covariate, time_s: &[f64], one: &Amplitude, gain: f64) -> Self {
        let late_s = one.late_s.as_ref().map_or(0.0, Quantity::value);
        let form = Form { late_s, ..one.form };
        let (mut columns, at) = form.about(covariate, time_s);
        if late_s > 0.0 {
            let moved = |by: f64| form.late(late_s * by.exp()).of(covariate, time_s).swap_remove(0);
            let pair = moved(APART).into_iter().zip(moved(-APART));
            columns.push(pair.map(|(later, earlier)| (later - earlier) / (2.0 * APART)).collect());
        }
        let taken = one.channels.iter().map(|of| of.iter().map(Quantity::value).collect()).collect();
        Self { name: covariate.name.clone(), form, p: (-gain).exp().min(1.0), columns, at, taken }
    }

    /// A pair with so many times what was taken off for this column.
    pub fn added(&self, pair: &Pair, times: f64) -> Pair {
        let mut pair = pair.clone();
        for (test, taken) in pair.test.iter_mut().zip(&self.taken) {
            add(test, self.columns.iter().zip(taken.iter().map(|size| times * size)));
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
        let second = |has: bool| {
            has.then(|| Quantity::new(self.taken[axis][1] + left[1].value(), left[1].std().unwrap_or(0.0)))
        };
        let lag_s = left.get(self.taken[axis].len()).map(|slope| {
            let relative = slope.std().unwrap_or(0.0) / nt_per_unit.value().abs();
            Quantity::new(self.form.late_s, self.form.late_s * relative)
        });
        Followed {
            column: self.name.clone(),
            lag_s,
            late_rows: self.form.rows,
            nt_per_unit2: second(self.form.bent),
            fast_nt_per_unit: second(self.form.fast),
            exponent: self.form.power,
            nt_per_unit,
            at: self.at,
            p: self.p,
            ..Followed::default()
        }
    }
}

/// Adds columns times their sizes to readings.
pub(crate) fn add<'a>(readings: &mut [f64], columns: impl Iterator<Item = (&'a Vec<f64>, f64)>) {
    for (column, size) in columns {
        readings.iter_mut().zip(column).for_each(|(reading, value)| *reading += size * value);
    }
}
