//! Products of columns in pieces of time, of which samples of the rows are put together without going through
//! the rows again.

use diagnose::{Dictionary, Error};
use faer::{Mat, MatRef, Side};
use rayon::prelude::*;

use crate::Combination;

/// Directions of scaled columns with less than this share of their squared length are rounding.
const ROUNDING: f64 = 1e-10;

/// Products of the calibration's derivatives, some columns and the residual, in this order, in each piece.
#[derive(Clone, Debug)]
pub struct Blocks {
    base: usize,
    pieces: Vec<Mat<f64>>,
    rows: Vec<f64>,
    /// Of the rows of prior knowledge, which belong to every sample.
    known: Mat<f64>,
}

/// Products in a sample of the rows, the calibration projected out.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Of the columns.
    pub gram: Mat<f64>,
    /// Of each column with the residual.
    pub along: Vec<f64>,
    /// Of the residual with itself.
    pub squares: f64,
    /// Its rows.
    pub rows: f64,
}

impl Blocks {
    /// Of sums of a dictionary's columns in pieces of equally many moments, one after the other; the sensors
    /// of a moment stay together.
    pub fn of(dictionary: &Dictionary, columns: &[Combination], pieces: usize) -> Self {
        let base = dictionary.base.ncols();
        let width = base + columns.len() + 1;
        let readings = dictionary.channels.iter().map(|channel| channel.rows.end).max().unwrap_or(0);
        let moments = dictionary.channels.iter().flat_map(|channel| channel.moments.last());
        let moments = moments.max().map_or(1, |last| last + 1);
        let found: Vec<Vec<Part>> = (0..dictionary.channels.len())
            .into_par_iter()
            .map(|number| of_channel(dictionary, columns, number, |moment| moment * pieces / moments))
            .collect();
        let mut blocks = Self {
            base,
            pieces: vec![Mat::zeros(width, width); pieces],
            rows: vec![0.0; pieces],
            known: Mat::zeros(width, width),
        };
        for (piece, rows, there, products) in found.into_iter().flatten() {
            blocks.rows[piece] += rows;
            for (j, column) in there.iter().enumerate() {
                for (i, row) in there.iter().enumerate() {
                    blocks.pieces[piece][(*row, *column)] += products[(i, j)];
                }
            }
        }
        let known = Mat::from_fn(dictionary.residual.len() - readings, width, |i, j| match j {
            j if j < base => dictionary.base[(readings + i, j)],
            j if j + 1 == width => dictionary.residual[readings + i],
            _ => 0.0,
        });
        blocks.known = known.transpose() * &known;
        blocks
    }

    /// Of rows of columns and, as the last one, a response: each row a piece.
    #[cfg(test)]
    pub fn of_rows(rows: &[Vec<f64>]) -> Self {
        let width = rows[0].len();
        let piece = |row: &Vec<f64>| Mat::from_fn(width, width, |i, j| row[i] * row[j]);
        let pieces = rows.iter().map(piece).collect();
        Self { base: 0, pieces, rows: vec![1.0; rows.len()], known: Mat::zeros(width, width) }
    }

    /// How many pieces there are.
    pub fn pieces(&self) -> usize {
        self.pieces.len()
    }

    fn total(&self, weights: &[f64]) -> Mat<f64> {
        let mut total = self.known.clone();
        for (piece, weight) in self.pieces.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            faer::zip!(&mut total, piece).for_each(|faer::unzip!(sum, value)| *sum += weight * value);
        }
        total
    }

    /// Each piece as often as its weight says.
    ///
    /// # Errors
    ///
    /// Products that are not finite.
    pub fn sample(&self, weights: &[f64]) -> Result<Sample, Error> {
        let total = self.total(weights);
        let rest = total.ncols() - self.base;
        let directions = directions(total.submatrix(0, 0, self.base, self.base))?;
        let across = directions.transpose() * total.submatrix(0, self.base, self.base, rest);
        let left = total.submatrix(self.base, self.base, rest, rest) - across.transpose() * &across;
        let last = rest - 1;
        Ok(Sample {
            gram: left.submatrix(0, 0, last, last).to_owned(),
            along: (0..last).map(|j| left[(j, last)]).collect(),
            squares: left[(last, last)].max(0.0),
            rows: self.rows.iter().zip(weights).map(|(rows, weight)| rows * weight).sum(),
        })
    }

    /// Sum of squares of the readings when calibration and columns are fitted to all, and of those of each
    /// part predicted from the others; piece after piece is dealt out to the parts.
    ///
    /// # Errors
    ///
    /// Products that are not finite.
    pub fn left(&self, parts: usize) -> Result<(f64, f64), Error> {
        let everything = vec![1.0; self.pieces()];
        let all = self.total(&everything);
        let readings = &all - &self.known;
        let mut out = 0.0;
        for part in 0..parts {
            let is_out = |piece: usize| f64::from(u8::from(piece % parts == part));
            let own: Vec<f64> = (0..self.pieces()).map(is_out).collect();
            let own = self.total(&own) - &self.known;
            out += left(&own, &coefficients((&all - &own).as_ref())?);
        }
        Ok((left(&readings, &coefficients(all.as_ref())?), out))
    }
}

/// Of a channel in a piece: the piece, its rows, the columns that are something there, and their products.
type Part = (usize, f64, Vec<usize>, Mat<f64>);

/// All pieces of a channel.
fn of_channel(
    dictionary: &Dictionary,
    columns: &[Combination],
    number: usize,
    piece_of: impl Fn(usize) -> usize,
) -> Vec<Part> {
    let channel = &dictionary.channels[number];
    let (base, length) = (dictionary.base.ncols(), channel.rows.len());
    let mut there: Vec<usize> = (0..base).collect();
    let mut values: Vec<Vec<f64>> =
        (0..base).map(|j| dictionary.base.col_as_slice(j)[channel.rows.clone()].to_vec()).collect();
    for (k, combination) in columns.iter().enumerate() {
        let mut sum: Option<Vec<f64>> = None;
        for (column, weight) in combination {
            let Some(part) = dictionary.part(*column, number) else { continue };
            let sum = sum.get_or_insert_with(|| vec![0.0; length]);
            sum.iter_mut().zip(part).for_each(|(sum, value)| *sum += weight * value);
        }
        if let Some(sum) = sum {
            there.push(base + k);
            values.push(sum);
        }
    }
    there.push(base + columns.len());
    values.push(dictionary.residual[channel.rows.clone()].to_vec());
    let mut found = Vec::new();
    let mut from = 0;
    while from < length {
        let piece = piece_of(channel.moments[from]);
        let to = from + channel.moments[from..].partition_point(|moment| piece_of(*moment) == piece);
        let block = Mat::from_fn(to - from, values.len(), |i, j| values[j][from + i]);
        found.push((piece, (to - from) as f64, there.clone(), block.transpose() * &block));
        from = to;
    }
    found
}

/// D with Dᵀ P D = 1 over the directions that are more than rounding.
fn directions(products: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let size = products.ncols();
    if size == 0 {
        return Ok(Mat::zeros(0, 0));
    }
    let scale = |i: usize| if products[(i, i)] > 0.0 { 1.0 / products[(i, i)].sqrt() } else { 0.0 };
    let scaled = Mat::from_fn(size, size, |i, j| products[(i, j)] * scale(i) * scale(j));
    let eigen = scaled.self_adjoint_eigen(Side::Lower).map_err(|error| {
        let reason = format!("{error:?}");
        estimate::Error::Decomposition { rows: size, columns: size, reason }
    })?;
    let values = eigen.S().column_vector();
    let kept: Vec<usize> = (0..size).filter(|k| values[*k] > ROUNDING).collect();
    Ok(Mat::from_fn(size, kept.len(), |i, k| scale(i) * eigen.U()[(i, kept[k])] / values[kept[k]].sqrt()))
}

/// Least squares of the last column on the others.
fn coefficients(products: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let last = products.ncols() - 1;
    let directions = directions(products.submatrix(0, 0, last, last))?;
    let along = directions.transpose() * products.submatrix(0, last, last, 1);
    Ok(directions * along)
}

/// Sum of squares that coefficients leave.
fn left(products: &Mat<f64>, coefficients: &Mat<f64>) -> f64 {
    let last = products.ncols() - 1;
    let linear = coefficients.transpose() * products.submatrix(0, last, last, 1);
    let square = coefficients.transpose() * products.submatrix(0, 0, last, last) * coefficients;
    (products[(last, last)] - 2.0 * linear[(0, 0)] + square[(0, 0)]).max(0.0)
}
