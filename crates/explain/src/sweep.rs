//! One channel regressed on a set of columns under each form of noise, and what further columns would explain.

use crate::stack::{Product, Stack};

/// What others leave of a column is at least this share of it, or it follows from them.
const INDEPENDENT: f64 = 1e-9;

/// A channel under one form of noise beside the columns of a set.
struct Under<'a> {
    product: &'a Product,
    /// L⁻¹ Xᵀ C⁻¹ (all columns), a row for each independent column of the set.
    rows: Vec<Vec<f64>>,
    /// Sum of squares that the base leaves, and that the set leaves.
    base: f64,
    left: f64,
    /// ln of the prior odds, − ½ ln |C| − ½ ln |Xᵀ C⁻¹ X| of the base.
    constant: f64,
}

/// A channel beside the columns of a set, under each form of noise.
pub struct Sweep<'a> {
    under: Vec<Under<'a>>,
    y: usize,
    /// Readings less the unknowns of the base.
    freedom: f64,
    rows: f64,
}

impl<'a> Sweep<'a> {
    /// Of a channel on the columns of the base and then of the set.
    pub fn of(products: &'a [Product], stack: &Stack, channel: usize, base: &[usize], set: &[usize]) -> Self {
        let (y, rows) = (stack.y[channel], stack.rows() as f64);
        let under = products.iter().map(|product| Under::of(product, y, base, set)).collect();
        Self { under, y, freedom: rows - base.len() as f64, rows }
    }

    /// ln of the evidence: over forms of noise with their odds, scale integrated out, coefficients of the base
    /// with a flat prior, those of the set with that of one reading's information (Zellner's g = n, Kass and
    /// Wasserman 1995), without the factor of the latter's width.
    pub fn evidence(&self) -> f64 {
        sum(self.under.iter().map(|under| self.of_one(under, under.left)))
    }

    fn of_one(&self, under: &Under<'_>, left: f64) -> f64 {
        let shrunk = left + (under.base - left).max(0.0) / (1.0 + self.rows);
        under.constant - 0.5 * self.freedom * shrunk.max(f64::MIN_POSITIVE).ln()
    }

    /// The evidence with further columns, and how many of them are independent of the set.
    pub fn with(&self, columns: &[usize]) -> (f64, usize) {
        let mut rank = 0;
        let all = self.under.iter().map(|under| {
            let (gain, own) = under.gain(columns, self.y);
            rank = rank.max(own);
            self.of_one(under, under.left - gain)
        });
        (sum(all), rank)
    }

    pub fn weights(&self) -> Vec<f64> {
        let all: Vec<f64> = self.under.iter().map(|under| self.of_one(under, under.left)).collect();
        let total = sum(all.iter().copied());
        all.iter().map(|one| (one - total).exp()).collect()
    }

    pub fn best(&self) -> usize {
        let weights = self.weights();
        (0..weights.len()).fold(0, |a, b| if weights[b] > weights[a] { b } else { a })
    }

    /// What the width of the prior of a coefficient costs, ½ ln (1 + n).
    pub fn width(&self) -> f64 {
        0.5 * self.rows.ln_1p()
    }
}

impl<'a> Under<'a> {
    fn of(product: &'a Product, y: usize, base: &[usize], set: &[usize]) -> Self {
        let gram = &product.gram;
        let mut under = Self {
            product,
            rows: Vec::new(),
            base: 0.0,
            left: gram[(y, y)],
            constant: product.log_prior - 0.5 * product.log_determinant,
        };
        for column in base {
            if let Some(pivot) = under.add(*column, y) {
                under.constant -= 0.5 * pivot.ln();
            }
        }
        under.base = under.left;
        for column in set {
            under.add(*column, y);
        }
        under
    }

    /// Adds a column; what the others leave of its square, where it is independent of them.
    fn add(&mut self, column: usize, y: usize) -> Option<f64> {
        let gram = &self.product.gram;
        let own: Vec<f64> = self.rows.iter().map(|row| row[column]).collect();
        let pivot = gram[(column, column)] - own.iter().map(|value| value * value).sum::<f64>();
        if pivot <= INDEPENDENT * gram[(column, column)] || pivot.is_nan() {
            return None;
        }
        let root = pivot.sqrt();
        let mut row: Vec<f64> = (0..gram.ncols()).map(|other| gram[(other, column)]).collect();
        for (known, value) in self.rows.iter().zip(&own) {
            row.iter_mut().zip(known).for_each(|(sum, known)| *sum -= value * known);
        }
        row.iter_mut().for_each(|value| *value /= root);
        self.left -= row[y] * row[y];
        self.rows.push(row);
        Some(pivot)
    }

    /// By how much columns lower the sum of squares beside the set, and how many of them are independent.
    fn gain(&self, columns: &[usize], y: usize) -> (f64, usize) {
        let gram = &self.product.gram;
        let beside =
            |i: usize, j: usize| gram[(i, j)] - self.rows.iter().map(|row| row[i] * row[j]).sum::<f64>();
        let (mut gain, mut rank) = (0.0, 0);
        // Rows of the further columns' own triangle: for each column before, and for y.
        let mut triangle: Vec<(Vec<f64>, f64)> = Vec::new();
        for (at, column) in columns.iter().enumerate() {
            let own: Vec<f64> = triangle.iter().map(|(row, _)| row[at]).collect();
            let pivot = beside(*column, *column) - own.iter().map(|value| value * value).sum::<f64>();
            if pivot <= INDEPENDENT * gram[(*column, *column)] || pivot.is_nan() {
                continue;
            }
            let root = pivot.sqrt();
            let along = |other: usize, place: Option<usize>| {
                let known: f64 = triangle
                    .iter()
                    .zip(&own)
                    .map(|((row, of_y), value)| value * place.map_or(*of_y, |place| row[place]))
                    .sum();
                (beside(*column, other) - known) / root
            };
            let row = columns.iter().enumerate().map(|(place, other)| along(*other, Some(place))).collect();
            let of_y = along(y, None);
            gain += of_y * of_y;
            rank += 1;
            triangle.push((row, of_y));
        }
        (gain.min(self.left), rank)
    }
}

/// ln Σ e^x.
pub fn sum(of: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = of.collect();
    let largest = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    largest + all.iter().map(|one| (one - largest).exp()).sum::<f64>().ln()
}
