//! Products of whitened columns, gathered once over the rows: all that is decided afterwards depends on the
//! number of columns alone.

use estimate::screen::{Column, Screen};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Col, Mat, Par};
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::algebra::{columns, left, orthonormal};
use crate::fit::Fit;
use crate::observed::Observed;
use crate::stacked::Stacked;
use crate::whitening::NoiseModel;

/// Rows whose products are taken at once.
const BLOCK: usize = 4096;
/// Columns that are projected at once.
const COLUMNS: usize = 128;

/// Whitened columns with their products.
#[derive(Clone, Debug)]
pub struct Products {
    columns: Vec<Stacked>,
    /// For each channel its rows in the stack.
    ranges: Vec<std::ops::Range<usize>>,
    /// Row i has the products with columns 0 to i.
    gram: Vec<Vec<f64>>,
}

impl Products {
    /// None yet.
    pub fn of(observed: &Observed<'_>) -> Self {
        let ranges = observed.channels.iter().map(|channel| channel.range()).collect();
        Self { columns: Vec::new(), ranges, gram: Vec::new() }
    }

    /// Adds columns (nT).
    pub fn push(&mut self, noise: &NoiseModel, raw: &[Stacked]) {
        let from = self.columns.len();
        self.columns.extend(noise.whitened(raw));
        let mut rows: Vec<Vec<f64>> = (from..self.columns.len()).map(|i| vec![0.0; i + 1]).collect();
        let found: Vec<_> =
            (0..self.ranges.len()).into_par_iter().map(|k| self.of_channel(k, from)).collect();
        for (all, new, products) in found {
            for (j, column) in new.iter().enumerate() {
                let row = &mut rows[column - from];
                all.iter().enumerate().filter(|(_, other)| *other <= column).for_each(|(i, other)| {
                    row[*other] += products[(i, j)];
                });
            }
        }
        self.gram.extend(rows);
    }

    /// A whitened series less columns times coefficients.
    pub fn less(&self, white: &[f64], terms: &[(usize, f64)]) -> Vec<f64> {
        let mut left = white.to_vec();
        for (channel, range) in self.ranges.iter().enumerate() {
            for (column, coefficient) in terms {
                if let Some(part) = self.columns[*column].part(channel) {
                    left[range.clone()].iter_mut().zip(part).for_each(|(l, p)| *l -= coefficient * p);
                }
            }
        }
        left
    }

    /// A whitened column.
    pub fn column(&self, number: usize) -> &Stacked {
        &self.columns[number]
    }

    /// How many columns there are.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Columns of a channel, those from `from` on among them, and the products of the first with the second.
    fn of_channel(&self, channel: usize, from: usize) -> (Vec<usize>, Vec<usize>, Mat<f64>) {
        let there = |column: &usize| self.columns[*column].part(channel).is_some();
        let all: Vec<usize> = (0..self.columns.len()).filter(there).collect();
        let new: Vec<usize> = all.iter().copied().filter(|column| *column >= from).collect();
        let mut products = Mat::zeros(all.len(), new.len());
        let old = all.len() - new.len();
        if !new.is_empty() {
            by_blocks(self.ranges[channel].len(), &mut products, |block| {
                let whole = self.block(channel, &all, block);
                let (before, right) = whole.split_at_col(old);
                let mut products = Mat::zeros(all.len(), new.len());
                products.subrows_mut(0, old).copy_from(before.transpose() * right);
                // Of the new with each other those up to the diagonal.
                triangular::matmul(
                    products.subrows_mut(old, new.len()),
                    BlockStructure::TriangularUpper,
                    Accum::Replace,
                    right.transpose(),
                    BlockStructure::Rectangular,
                    right,
                    BlockStructure::Rectangular,
                    1.0,
                    Par::Seq,
                );
                products
            });
        }
        (all, new, products)
    }

    fn block(&self, channel: usize, columns: &[usize], rows: std::ops::Range<usize>) -> Mat<f64> {
        let mut block = Mat::zeros(rows.len(), columns.len());
        for (j, column) in columns.iter().enumerate() {
            if let Some(part) = self.columns[*column].part(channel) {
                block.col_as_slice_mut(j).copy_from_slice(&part[rows.clone()]);
            }
        }
        block
    }

    /// The products of columns from `from` on with the orthonormal columns of `onto`, one row of the answer a
    /// column.
    fn along(&self, onto: &Mat<f64>, from: usize) -> Vec<Vec<f64>> {
        let mut along = vec![vec![0.0; onto.ncols()]; self.columns.len() - from];
        let found: Vec<(Vec<usize>, Mat<f64>)> = (0..self.ranges.len())
            .into_par_iter()
            .map(|channel| {
                let there = |column: &usize| self.columns[*column].part(channel).is_some();
                let all: Vec<usize> = (from..self.columns.len()).filter(there).collect();
                let range = &self.ranges[channel];
                let mut sums = Mat::zeros(all.len(), onto.ncols());
                by_blocks(range.len(), &mut sums, |rows| {
                    let right = onto.subrows(range.start + rows.start, rows.len());
                    self.block(channel, &all, rows).transpose() * right
                });
                (all, sums)
            })
            .collect();
        for (all, sums) in found {
            for (i, column) in all.iter().enumerate() {
                along[column - from].iter_mut().enumerate().for_each(|(j, sum)| *sum += sums[(i, j)]);
            }
        }
        along
    }
}

/// Adds what each block of rows gives: some at a time on all threads, always in the same order.
fn by_blocks(rows: usize, sum: &mut Mat<f64>, of: impl Fn(std::ops::Range<usize>) -> Mat<f64> + Sync) {
    let blocks: Vec<_> = (0..rows).step_by(BLOCK).map(|at| at..(at + BLOCK).min(rows)).collect();
    for some in blocks.chunks(rayon::current_num_threads()) {
        let found: Vec<Mat<f64>> = some.par_iter().map(|block| of(block.clone())).collect();
        found.iter().for_each(|product| *sum += product);
    }
}

/// What a fit leaves of columns and residual: all that it has unknown is projected out of them.
#[derive(Clone, Debug)]
pub struct Projection {
    /// An orthonormal basis of the fit's derivatives, then the residual.
    onto: Arc<Mat<f64>>,
    /// The residual along the basis, then its square.
    residual: Vec<f64>,
    /// The same for each column.
    columns: Vec<Vec<f64>>,
}

impl Projection {
    /// Of a fit.
    ///
    /// # Errors
    ///
    /// Derivatives that are not finite.
    pub fn of(fit: &Fit) -> Result<Self, Error> {
        let basis = orthonormal(&fit.jacobian)?;
        let rank = basis.ncols();
        let onto =
            Mat::from_fn(
                fit.white.len(),
                rank + 1,
                |i, j| if j < rank { basis[(i, j)] } else { fit.white[i] },
            );
        let product = |j: usize| onto.col_as_slice(j).iter().zip(&fit.white).map(|(b, w)| b * w).sum();
        let residual = (0..=rank).map(product).collect();
        Ok(Self { onto: Arc::new(onto), residual, columns: Vec::new() })
    }

    /// What the fit leaves of a whitened series.
    pub fn left(&self, series: &[f64]) -> Vec<f64> {
        left(columns(&self.onto).take(self.onto.ncols() - 1), series)
    }

    /// The screen of no column yet.
    pub fn screen(&self) -> Screen {
        let rank = self.onto.ncols() - 1;
        let taken: f64 = self.residual[..rank].iter().map(|a| a * a).sum();
        Screen::empty(self.residual[rank] - taken, self.onto.nrows(), rank)
    }

    /// Adds the columns that a screen does not have yet.
    pub fn extend(&mut self, screen: &mut Screen, products: &Products) {
        let from = screen.columns();
        self.columns.extend(products.along(&self.onto, from));
        let rank = self.onto.ncols() - 1;
        let all = Mat::from_fn(rank, products.len(), |j, i| self.columns[i][j]);
        let residual = Col::from_fn(rank, |j| self.residual[j]);
        let made: Vec<Vec<Column>> = (from..products.len())
            .into_par_iter()
            .step_by(COLUMNS)
            .map(|at| {
                let count = COLUMNS.min(products.len() - at);
                let own = all.subcols(at, count);
                let within = all.subcols(0, at + count).transpose() * own;
                let along = own.transpose() * &residual;
                let column = |k: usize| {
                    let gram = &products.gram[at + k];
                    Column {
                        left: gram.iter().zip(within.col_as_slice(k)).map(|(whole, of)| whole - of).collect(),
                        along: self.columns[at + k][rank] - along[k],
                        whole: gram[at + k],
                    }
                };
                (0..count).map(column).collect()
            })
            .collect();
        made.into_iter().flatten().for_each(|column| screen.push(column));
    }
}
