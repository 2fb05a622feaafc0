//! Columns projected out of others, and what a group explains of what is left.

use faer::{Col, Mat, MatRef};
use std::sync::Arc;

use crate::positive::eigen;
use crate::{Error, gram};

/// Directions of scaled columns with less than this share of their squared length are rounding.
const ROUNDING: f64 = 1e-10;
/// A column of which projection has left less than this share of the squared length is gone.
const GONE: f64 = 1e-9;

/// A column is not known by itself when so much of it lies along directions that are gone. Below that it is
/// known with what is gone held where it is: the size of an effect of a hundredth of the field goes with the
/// scale of all readings to 1e-4 of that direction.
const LOST: f64 = 1e-3;
/// Most groups of a stepwise regression.
const MOST: usize = 12;

/// A group of columns fitted to what is left.
#[derive(Clone, Debug)]
pub struct Gain {
    /// By how much Σ of the squared residuals falls: χ² of the group's rank if there is nothing of it.
    pub gain: f64,
    /// Rank of what is left of its columns.
    pub rank: usize,
    /// Its coefficients, zero for columns that are gone.
    pub coefficients: Vec<f64>,
    /// Their covariance, infinite variances for columns that are gone.
    pub covariance: Mat<f64>,
}

/// Columns and residual, with some of the columns projected out of all others.
#[derive(Clone, Debug)]
pub struct Screen {
    /// Products of the columns: row i has those with columns from its first to i.
    left: Arc<Vec<(usize, Vec<f64>)>>,
    /// Columns and residual along each direction that is projected out of these products.
    taken: Vec<Vec<f64>>,
    /// What is left of their products with the residual.
    along: Vec<f64>,
    /// The same of the residual's square.
    squares: f64,
    /// Squared lengths of the columns as they were.
    whole: Vec<f64>,
    rows: usize,
    /// Rank of what was projected out.
    used: usize,
}

/// A column of a screen.
#[derive(Clone, Debug)]
pub struct Column {
    /// The first column with which its product is at hand.
    pub first: usize,
    /// What is left of its products with the columns from there on and with itself.
    pub left: Vec<f64>,
    /// The same with the residual.
    pub along: f64,
    /// Its squared length as it was.
    pub whole: f64,
}

impl Screen {
    /// Of a block of rows: the columns, then the residual as the last one.
    pub fn of_rows(block: MatRef<'_, f64>) -> Self {
        Self::of(gram(block).as_ref(), block.nrows())
    }

    /// Of the products of columns and residual over so many rows, nothing projected out.
    pub fn of(total: MatRef<'_, f64>, rows: usize) -> Self {
        let columns = total.ncols() - 1;
        let mut screen = Self::empty(total[(columns, columns)], rows, 0);
        for i in 0..columns {
            let left = (0..=i).map(|j| total[(i, j)]).collect();
            screen.push(Column { first: 0, left, along: total[(columns, i)], whole: total[(i, i)] });
        }
        screen
    }

    /// No column yet: the residual's square, its rows, and the rank of what was projected out of it already.
    pub fn empty(squares: f64, rows: usize, used: usize) -> Self {
        let (left, taken, along, whole) = (Arc::default(), Vec::new(), Vec::new(), Vec::new());
        Self { left, taken, along, squares, whole, rows, used }
    }

    /// Adds a column behind the others, before any is projected out.
    pub fn push(&mut self, column: Column) {
        debug_assert!(self.taken.is_empty(), "a column that comes late is projected by nobody");
        Arc::make_mut(&mut self.left).push((column.first, column.left));
        self.along.push(column.along);
        self.whole.push(column.whole);
    }

    /// Gives a column more of its products.
    pub fn replace(&mut self, number: usize, column: Column) {
        debug_assert!(self.taken.is_empty(), "a column that comes late is projected by nobody");
        Arc::make_mut(&mut self.left)[number] = (column.first, column.left);
    }

    /// What is left of a product of two columns; the residual is the last one. Not a number where it is not at hand.
    pub fn product(&self, i: usize, j: usize) -> f64 {
        let (high, low) = (i.max(j), i.min(j));
        match (self.left.get(high), self.along.get(low)) {
            (Some((first, row)), _) => {
                let left = low.checked_sub(*first).and_then(|place| row.get(place));
                debug_assert!(left.is_some(), "the product of columns {low} and {high} was not formed");
                left.map_or(f64::NAN, |left| {
                    left - self.taken.iter().map(|along| along[i] * along[j]).sum::<f64>()
                })
            }
            (None, Some(along)) => *along,
            (None, None) => self.squares,
        }
    }

    /// How many columns there are.
    pub fn columns(&self) -> usize {
        self.whole.len()
    }

    /// The same with a group of columns projected out of all others and of the residual (Frisch, Waugh and
    /// Lovell).
    ///
    /// Errors: [`Error::Decomposition`] for products that are not finite.
    pub fn given(&self, group: &[usize]) -> Result<Self, Error> {
        let part = Part::of(self, group)?;
        let last = self.columns();
        let across = Mat::from_fn(last + 1, group.len(), |i, j| self.product(i, group[j])) * &part.directions;
        let mut screen = Self { used: self.used + part.rank(), ..self.clone() };
        for direction in 0..part.rank() {
            let along = across.col_as_slice(direction).to_vec();
            screen.along.iter_mut().zip(&along).for_each(|(left, own)| *left -= own * along[last]);
            screen.squares -= along[last] * along[last];
            screen.taken.push(along);
        }
        Ok(screen)
    }

    /// Σ of the squared residuals.
    pub fn sum_of_squares(&self) -> f64 {
        self.squares.max(0.0)
    }

    /// Rows less the rank of what was projected out.
    pub fn freedom(&self) -> f64 {
        self.rows as f64 - self.used as f64
    }

    /// Share of a column's squared length that is left: what of it the fit of others has not swallowed.
    pub fn visible(&self, column: usize) -> f64 {
        let whole = self.whole[column];
        if whole > 0.0 { (self.product(column, column) / whole).max(0.0) } else { 0.0 }
    }

    /// Fits a group of columns to what is left of the residual.
    ///
    /// Errors: [`Error::Decomposition`] for products that are not finite.
    pub fn gain(&self, group: &[usize]) -> Result<Gain, Error> {
        let part = Part::of(self, group)?;
        let along = part.directions.transpose() * Col::from_fn(group.len(), |i| self.along[group[i]]);
        let mut covariance = &part.directions * part.directions.transpose();
        for (i, gone) in part.gone.iter().enumerate() {
            if *gone {
                covariance[(i, i)] = f64::INFINITY;
            }
        }
        Ok(Gain {
            gain: along.squared_norm_l2(),
            rank: part.rank(),
            coefficients: (&part.directions * along).iter().copied().collect(),
            covariance,
        })
    }

    /// The groups that a stepwise regression chooses: one at a time, the one by which n ln S + k ln n falls most,
    /// S the sum of squares and k the rank, until it no longer falls or there are twelve. `given` has those that are
    /// chosen projected out.
    ///
    /// Errors: [`Error::Decomposition`] for products that are not finite.
    pub fn stepwise(
        &self,
        groups: &[&[usize]],
        mut given: impl FnMut(&[usize]) -> Result<Self, Error>,
    ) -> Result<Vec<usize>, Error> {
        let rows = self.rows as f64;
        let mut chosen = Vec::new();
        let mut rest = self.clone();
        while chosen.len() < MOST && rest.sum_of_squares() > 0.0 {
            let mut best: Option<(f64, usize)> = None;
            for number in (0..groups.len()).filter(|number| !chosen.contains(number)) {
                let Gain { gain, rank, .. } = rest.gain(groups[number])?;
                let left = (1.0 - gain / rest.sum_of_squares()).max(f64::MIN_POSITIVE);
                let change = rows * left.ln() + rank as f64 * rows.ln();
                if change < best.map_or(0.0, |(least, _)| least) {
                    best = Some((change, number));
                }
            }
            let Some((_, number)) = best else { break };
            chosen.push(number);
            rest = given(&chosen)?;
        }
        Ok(chosen)
    }
}

/// For the products of each block of rows the coefficients of `group` fitted to all other blocks. One that the
/// others do not determine is zero.
///
/// Errors: [`Error::Decomposition`] for products that are not finite.
pub fn left_out(blocks: &[Mat<f64>], group: &[usize]) -> Result<Vec<Vec<f64>>, Error> {
    let width = blocks.first().map_or(0, Mat::ncols);
    let total = blocks.iter().fold(Mat::zeros(width, width), |sum, block| sum + block);
    let without = |block| {
        let left: Mat<f64> = &total - block;
        Ok(Screen::of(left.as_ref(), 0).gain(group)?.coefficients)
    };
    blocks.iter().map(without).collect()
}

/// Directions within a group along which something is left: D with Dᵀ (CᵀC) D = 1, one column a direction.
pub(super) struct Part {
    pub directions: Mat<f64>,
    gone: Vec<bool>,
}

impl Part {
    pub fn of(screen: &Screen, group: &[usize]) -> Result<Self, Error> {
        let length = |&column: &usize| {
            if screen.visible(column) > GONE { screen.product(column, column).sqrt() } else { 0.0 }
        };
        let lengths: Vec<f64> = group.iter().map(length).collect();
        let scaled = Mat::from_fn(group.len(), group.len(), |i, j| {
            let product = lengths[i] * lengths[j];
            if product > 0.0 { screen.product(group[i], group[j]) / product } else { 0.0 }
        });
        if !scaled.is_all_finite() {
            let reason = "products that are not finite".into();
            return Err(Error::Decomposition { rows: group.len(), columns: group.len(), reason });
        }
        let (values, vectors) = eigen(scaled.as_ref())?;
        let kept: Vec<usize> = (0..values.len()).filter(|&k| values[k] > ROUNDING).collect();
        let directions = Mat::from_fn(group.len(), kept.len(), |i, k| {
            if lengths[i] > 0.0 { vectors[(i, kept[k])] / (values[kept[k]].sqrt() * lengths[i]) } else { 0.0 }
        });
        // What the rest hold only together with what is gone is not known by itself.
        let lost = |i: usize| -> f64 {
            (0..values.len()).filter(|&k| values[k] <= ROUNDING).map(|k| vectors[(i, k)].powi(2)).sum()
        };
        let gone = lengths.iter().enumerate().map(|(i, length)| *length == 0.0 || lost(i) > LOST).collect();
        Ok(Self { directions, gone })
    }

    pub fn rank(&self) -> usize {
        self.directions.ncols()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = 3 c + 2 a of columns a, b, c, d and 40 rows that are orthogonal, with a small remainder along d.
    #[test]
    fn a_stepwise_regression_takes_what_pays_for_its_unknowns_the_largest_first() {
        let wave =
            |k: usize, row: usize| (std::f64::consts::PI * (k as f64) * (row as f64 + 0.5) / 40.0).cos();
        let sizes = [2.0, 0.0, 3.0, 1e-3];
        let rest = |row: usize| 0.1 * wave(17, row);
        let value = |row: usize, column: usize| match column {
            4 => (0..4).map(|k| sizes[k] * wave(k + 1, row)).sum::<f64>() + rest(row),
            column => wave(column + 1, row),
        };
        let screen = Screen::of_rows(Mat::from_fn(40, 5, value).as_ref());
        let chosen =
            screen.stepwise(&[&[0], &[1], &[2], &[3]], |chosen| screen.given(chosen)).expect("finite");
        assert_eq!(chosen, [2, 0]);
    }
}
