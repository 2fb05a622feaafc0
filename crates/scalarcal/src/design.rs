//! Rows as products, in factors.

use rayon::prelude::*;
use std::ops::Range;

use crate::model::{Model, State};
use crate::read::Series;
use crate::terms::{BLOCK, Factor, ONE, Terms};

/// Rows that one thread takes at a time: whole blocks, so that factors do not depend on the threads.
const CHUNK: usize = 64 * BLOCK;

/// The units in which the columns z are of the order of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Typical magnitude, nT.
    pub magnitude_nt: f64,
    /// Nominal sensitivity of each sensor, nT by the unit of its output.
    pub sensitivity: [f64; 3],
}

pub struct Rows<'a> {
    pub series: &'a [Series],
    pub scales: Scales,
    /// For each recording the weights of its rows; none: all count alike.
    pub weights: Option<Vec<Vec<f64>>>,
    pub pieces: Vec<(usize, Range<usize>)>,
}

impl<'a> Rows<'a> {
    pub fn new(series: &'a [Series], scales: Scales) -> Self {
        let pieces = series.iter().enumerate().map(|(number, one)| (number, 0..one.len())).collect();
        Self { series, scales, weights: None, pieces }
    }

    pub fn part(&self, number: usize, rows: Range<usize>) -> Self {
        Self { pieces: vec![(number, rows)], ..Self::new(self.series, self.scales) }
    }

    /// The columns z of a row, with F behind them.
    fn fill(&self, number: usize, row: usize, z: &mut [f64]) {
        let series = &self.series[number];
        let Scales { magnitude_nt, sensitivity } = self.scales;
        for axis in 0..3 {
            z[axis] = sensitivity[axis] * series.readings[axis][row] / magnitude_nt;
        }
        z[ONE] = 1.0;
        for (place, column) in series.follows.iter().enumerate() {
            z[ONE + 1 + place] = column[row] / magnitude_nt;
        }
        z[ONE + 1 + series.follows.len()] = series.magnitude_nt[row] / magnitude_nt;
    }

    /// The same as a list.
    pub fn z(&self, number: usize, row: usize) -> Vec<f64> {
        let mut z = vec![0.0; ONE + 2 + self.series[number].follows.len()];
        self.fill(number, row, &mut z);
        z
    }

    /// Recording and row of all of them.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> {
        self.pieces.iter().flat_map(|(number, rows)| rows.clone().map(|row| (*number, row)))
    }

    /// Makes something of the columns z and their products, for each of some rows of a recording.
    pub fn map<T>(
        &self,
        terms: &Terms,
        number: usize,
        rows: Range<usize>,
        mut of: impl FnMut(usize, &mut [f64], &mut [f64]) -> T,
    ) -> Vec<T> {
        let (mut z, mut products) = (vec![0.0; terms.columns + 1], vec![0.0; terms.count()]);
        let each = |row: usize| {
            self.fill(number, row, &mut z);
            terms.fill(&z, &mut products);
            of(row, &mut z, &mut products)
        };
        rows.map(each).collect()
    }

    /// Something of every so many rows, recording by recording.
    pub fn each<T: Send>(&self, size: usize, of: impl Fn(usize, Range<usize>) -> T + Sync) -> Vec<Vec<T>> {
        let of_piece = |(number, rows): &(usize, Range<usize>)| {
            let starts: Vec<usize> = rows.clone().step_by(size).collect();
            starts.into_par_iter().map(|from| of(*number, from..(from + size).min(rows.end))).collect()
        };
        self.pieces.par_iter().map(of_piece).collect()
    }

    pub fn factor(&self, terms: &Terms) -> Factor {
        let of = |number: usize, rows: Range<usize>| {
            let mut factor = Factor::new(terms.count());
            self.map(terms, number, rows, |row, _, products| {
                let weight = self.weights.as_ref().map_or(1.0, |weights| weights[number][row].sqrt());
                factor.row(products.iter().map(|value| weight * value));
            });
            factor.finish()
        };
        Factor::joined(terms.count(), self.each(CHUNK, of).iter().flatten())
    }

    /// |B| less the reference in each row of each recording, nT: (|B|² − (F − β)²)/2F.
    pub fn residuals(&self, model: &Model, state: &State) -> Vec<Vec<f64>> {
        let unit_nt = self.scales.magnitude_nt * model.scale(state);
        let coefficients = model.coefficients(state).unwrap_or_else(|| vec![f64::NAN; model.terms.count()]);
        let of = |number: usize| {
            self.map(&model.terms, number, 0..self.series[number].len(), |_, _, products| {
                let residual: f64 = products.iter().zip(&coefficients).map(|(a, b)| a * b).sum();
                residual * unit_nt
            })
        };
        (0..self.series.len()).into_par_iter().map(of).collect()
    }
}
