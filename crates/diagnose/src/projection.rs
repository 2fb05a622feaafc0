//! What a fit leaves of columns and residual: all that it has unknown is projected out of them.

use estimate::dot;
use estimate::screen::{Column, Screen};
use faer::Mat;
use noise::Stream;
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::algebra::{columns, left, orthonormal};
use crate::fit::Fit;
use crate::products::Products;

/// Residuals that are drawn.
const DRAWS: usize = 399;
/// Rows in which they are drawn, and in stretches of how many.
const DRAWN: usize = 6000;
const STRETCH: usize = 60;

#[derive(Clone, Debug)]
pub struct Projection {
    /// An orthonormal basis of the fit's derivatives, then the residual.
    onto: Arc<Mat<f64>>,
    /// The residual along the basis, then its square.
    residual: Vec<f64>,
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
        let onto = |i: usize, j: usize| if j < rank { basis[(i, j)] } else { fit.white[i] };
        let onto = Mat::from_fn(fit.white.len(), rank + 1, onto);
        let residual = (0..=rank).map(|j| dot(onto.col_as_slice(j), &fit.white)).collect();
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
        let made: Vec<Column> =
            (from..products.len()).into_par_iter().map(|i| self.column(products, i)).collect();
        made.into_iter().for_each(|column| screen.push(column));
    }

    /// Has columns of a screen with their products with all.
    pub fn complete(&self, screen: &mut Screen, products: &mut Products, columns: &[usize]) {
        products.complete(columns);
        let made: Vec<Column> = columns.par_iter().map(|i| self.column(products, *i)).collect();
        columns.iter().zip(made).for_each(|(i, column)| screen.replace(*i, column));
    }

    fn column(&self, products: &Products, i: usize) -> Column {
        let rank = self.onto.ncols() - 1;
        let within = |j: usize| dot(&self.columns[i][..rank], &self.columns[j][..rank]);
        let (first, row) = products.row(i);
        Column {
            first,
            left: (first..).zip(row).map(|(j, whole)| whole - within(j)).collect(),
            along: self.columns[i][rank] - dot(&self.columns[i][..rank], &self.residual[..rank]),
            whole: products.square(i),
        }
    }

    /// Products of all columns with residuals of independent errors of variance one, one row for each of them. Of many
    /// rows, stretches are drawn that stand for all.
    pub fn draws(&self, products: &Products, stream: &mut Stream) -> Mat<f64> {
        let rank = self.onto.ncols() - 1;
        let whole: usize = products.ranges().iter().map(|range| range.len()).sum();
        let every = whole.div_ceil(DRAWN);
        let mut draws = Mat::zeros(DRAWS, products.len());
        let mut drawn = vec![0.0; products.len()];
        let mut taken = Mat::zeros(rank, DRAWS);
        for (channel, range) in products.ranges().iter().enumerate() {
            let stretches = (0..range.len()).step_by(STRETCH).step_by(every);
            let rows: Vec<usize> = stretches.flat_map(|at| at..(at + STRETCH).min(range.len())).collect();
            let errors = Mat::from_fn(rows.len(), DRAWS, |_, _| stream.normal());
            let there: Vec<usize> =
                (0..products.len()).filter(|column| products.part(channel, *column).is_some()).collect();
            let value =
                |i: usize, j: usize| products.part(channel, there[j]).map_or(0.0, |part| part[rows[i]]);
            let columns = Mat::from_fn(rows.len(), there.len(), value);
            let along = errors.transpose() * &columns;
            for (j, column) in there.iter().enumerate() {
                drawn[*column] += columns.col(j).squared_norm_l2();
                let own = draws.col_as_slice_mut(*column).iter_mut();
                own.zip(along.col_as_slice(j)).for_each(|(d, a)| *d += a);
            }
            let basis = Mat::from_fn(rows.len(), rank, |i, k| self.onto[(range.start + rows[i], k)]);
            taken += basis.transpose() * errors;
        }
        // What a fit takes of them; stretches stand for the whole by their share of its square.
        let columns = Mat::from_fn(rank, products.len(), |k, i| self.columns[i][k]);
        draws -= taken.transpose() * columns;
        for (i, drawn) in drawn.iter().enumerate() {
            let factor = if *drawn > 0.0 { (products.square(i) / drawn).sqrt() } else { 0.0 };
            draws.col_as_slice_mut(i).iter_mut().for_each(|draw| *draw *= factor);
        }
        draws
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::products::tests::{product, some};

    /// 399 draws: their mean squares are those of the columns less what the fit takes, to 4 standard errors of 7 %.
    #[test]
    fn draws_are_those_of_independent_errors() {
        for of in [[40, 30], [9000, 6000]] {
            let (products, columns) = some(of);
            let rows = of[0] + of[1];
            let basis = (rows as f64).sqrt().recip();
            let onto = Mat::from_fn(rows, 2, |i, j| if j == 0 { basis } else { (i as f64).cos() });
            let along = products.along(&onto, 0);
            let projection =
                Projection { onto: Arc::new(onto), residual: vec![0.0; 2], columns: along.clone() };
            let draws = projection.draws(&products, &mut Stream::new(1, "draws"));
            for (i, column) in columns.iter().enumerate() {
                let expected = product(column, column) - along[i][0].powi(2);
                let ratio = draws.col(i).squared_norm_l2() / DRAWS as f64 / expected;
                assert!((ratio - 1.0).abs() < 0.28, "{rows} {i}: {ratio}");
            }
        }
    }
}
