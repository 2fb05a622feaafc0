//! Rows as products, in factors.

use rayon::prelude::*;
use std::ops::Range;

use crate::factor::{BLOCK, Factor, Filling};
use crate::model::{Model, State};
use crate::read::Series;
use crate::terms::{ONE, Terms};

/// Rows that one thread takes at a time; a whole number of blocks, so that the factors do not depend on the
/// threads.
const CHUNK: usize = 64 * BLOCK;

/// The units in which the columns z are of the order of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Typical magnitude, nT.
    pub magnitude_nt: f64,
    /// Nominal sensitivity of each sensor, nT by the unit of its output.
    pub sensitivity: [f64; 3],
}

/// What is made of the columns z of a row, with room for its products.
pub type OfRow<'a> = dyn Fn(&mut [f64], &mut [f64]) -> Vec<f64> + 'a;

/// The rows of all recordings.
pub struct Rows<'a> {
    /// The recordings.
    pub series: &'a [Series],
    /// The units.
    pub scales: Scales,
    /// For each recording the columns that effects follow, nT.
    pub follows: Vec<Vec<Vec<f64>>>,
    /// For each recording the weights of its rows; none: all count alike.
    pub weights: Option<Vec<Vec<f64>>>,
}

impl Rows<'_> {
    /// The columns z of a row, with F behind them.
    pub fn fill(&self, number: usize, row: usize, z: &mut [f64]) {
        let series = &self.series[number];
        let Scales { magnitude_nt, sensitivity } = self.scales;
        for axis in 0..3 {
            z[axis] = sensitivity[axis] * series.readings[axis][row] / magnitude_nt;
        }
        z[ONE] = 1.0;
        let follows = &self.follows[number];
        for (place, column) in follows.iter().enumerate() {
            z[ONE + 1 + place] = column[row] / magnitude_nt;
        }
        z[ONE + 1 + follows.len()] = series.magnitude_nt[row] / magnitude_nt;
    }

    /// The weight of a row, as a factor on its products.
    fn root_weight(&self, number: usize, row: usize) -> f64 {
        self.weights.as_ref().map_or(1.0, |weights| weights[number][row].sqrt())
    }

    /// Chunks of rows: recording, first row, and the row after the last.
    fn chunks(&self) -> Vec<(usize, usize, usize)> {
        let of = |(number, series): (usize, &Series)| {
            let rows = series.len();
            (0..rows)
                .step_by(CHUNK)
                .map(move |from| (number, from, (from + CHUNK).min(rows)))
                .collect::<Vec<_>>()
        };
        self.series.iter().enumerate().flat_map(of).collect()
    }

    /// The factor of all rows.
    pub fn factor(&self, terms: &Terms) -> Factor {
        let of = |(number, from, to): &(usize, usize, usize)| {
            let mut filling = Filling::new(terms.count());
            let (mut z, mut products) = (vec![0.0; terms.columns() + 1], vec![0.0; terms.count()]);
            for row in *from..*to {
                self.fill(*number, row, &mut z);
                terms.fill(&z, &mut products);
                let weight = self.root_weight(*number, row);
                filling.row(products.iter().map(|value| weight * value));
            }
            filling.finish()
        };
        let parts: Vec<Factor> = self.chunks().par_iter().map(of).collect();
        Factor::joined(terms.count(), &parts)
    }

    /// What `row` makes of the columns z of some rows of a recording; of more rows than that has columns
    /// their factor, row by row.
    pub fn compressed(
        &self,
        model: &Model,
        number: usize,
        rows: Range<usize>,
        row: &OfRow<'_>,
    ) -> Vec<Vec<f64>> {
        let mut z = vec![0.0; model.terms.columns() + 1];
        let mut products = vec![0.0; model.terms.count()];
        let mut of = |place: usize| {
            self.fill(number, place, &mut z);
            row(&mut z, &mut products)
        };
        let first = of(rows.start);
        let count = first.len();
        if rows.len() <= count {
            return std::iter::once(first).chain((rows.start + 1..rows.end).map(of)).collect();
        }
        let mut filling = Filling::new(count);
        rows.for_each(|place| filling.row(of(place)));
        let upper = filling.finish().upper();
        (0..count).map(|i| (0..count).map(|j| upper[(i, j)]).collect()).collect()
    }

    /// |B| less the reference in each row of each recording, nT: (|B|² − (F − β)²)/2F.
    pub fn residuals(&self, model: &Model, state: &State) -> Vec<Vec<f64>> {
        let unit_nt = self.scales.magnitude_nt * model.scale(state);
        let coefficients = model.coefficients(state).unwrap_or_else(|| vec![f64::NAN; model.terms.count()]);
        let of = |number: usize| {
            let rows = self.series[number].len();
            let (mut z, mut products) =
                (vec![0.0; model.terms.columns() + 1], vec![0.0; model.terms.count()]);
            let row = |row: usize| {
                self.fill(number, row, &mut z);
                model.terms.fill(&z, &mut products);
                let residual: f64 = products.iter().zip(&coefficients).map(|(a, b)| a * b).sum();
                residual * unit_nt
            };
            (0..rows).map(row).collect()
        };
        (0..self.series.len()).into_par_iter().map(of).collect()
    }
}
