//! The square of the magnitude as a linear function of products of what was read.
//!
//! Along its own axis sensor i reads the field b_i = Σ_f L_if z_f, where z holds the three outputs, one, and
//! columns that effects follow. With G = μᵀμ, the cosines between the axes, |B|² = bᵀ G⁻¹ b = Σ_{f≤g} p_fg
//! z_f z_g. So the residual
//!
//! ```text
//! r = (|B|² − (F − β)²)/2F ≈ |B| − (F − β)
//! ```
//!
//! of a row is linear in products of its columns, with the coefficients p: one triangular factor of these
//! products holds all that any number of rows say of the calibration.

use common::covariance;
use estimate::triangle::Triangle;
use faer::Mat;
use serde::{Deserialize, Serialize};

/// Rows of one factorisation.
pub const BLOCK: usize = 512;
/// Place of the constant one among the columns z.
pub const ONE: usize = 3;

/// The products that are kept: z_f z_g for f ≤ g, z_ONE F, and F².
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// How many columns z there are; F counts as the next.
    pub columns: usize,
    pub pairs: Vec<[usize; 2]>,
}

impl Terms {
    /// Of so many columns z: three outputs, one, and what follows.
    pub fn new(columns: usize) -> Self {
        let all = (0..columns).flat_map(|f| (f..columns).map(move |g| [f, g]));
        let pairs = all.chain([[ONE, columns], [columns, columns]]).collect();
        Self { columns, pairs }
    }

    pub fn count(&self) -> usize {
        self.pairs.len()
    }

    /// Where the product of two columns without F stands.
    pub fn product(&self, f: usize, g: usize) -> usize {
        self.place(f, g).expect("a product without F")
    }

    /// Where the product of two columns stands; None for those with F that are not kept.
    pub fn place(&self, f: usize, g: usize) -> Option<usize> {
        let (low, high) = (f.min(g), f.max(g));
        if high < self.columns {
            // Rows of an upper triangle.
            Some(low * self.columns - low * (low + 1) / 2 + high)
        } else {
            self.pairs.iter().rposition(|pair| *pair == [low, high])
        }
    }

    /// The products of a row over 2F, `z` with F behind its columns.
    pub fn fill(&self, z: &[f64], row: &mut [f64]) {
        let half = 0.5 / z[self.columns];
        let mut place = 0;
        for f in 0..self.columns {
            let first = half * z[f];
            for value in &z[f..self.columns] {
                row[place] = first * value;
                place += 1;
            }
        }
        row[place] = half * z[self.columns];
        row[place + 1] = half * z[self.columns] * z[self.columns];
    }
}

/// The mean of what noise adds to the products of products.
///
/// With z + e in place of z, e of covariance S, E[(z_f+e_f)(z_g+e_g)(z_h+e_h)(z_k+e_k)] is z_f z_g z_h z_k
/// plus this, written with the products that were read: Σ S_fg E[z_h z_k] over the six pairs less Σ S_fg S_hk
/// over the three. Taken off the normal equations, it removes the bias.
///
/// `variance` is S, diagonal, over all columns and F; `moments(f, g)` is Σ z_f z_g/4F² over the rows.
///
/// I. Markovsky et al., Consistent least squares fitting of ellipsoids, Numer. Math. 98 (2004) 177–194.
pub fn added_by_noise(terms: &Terms, variance: &[f64], moments: impl Fn(usize, usize) -> f64) -> Mat<f64> {
    let s = |f: usize, g: usize| if f == g { variance[f] } else { 0.0 };
    let weight = moments(ONE, ONE);
    let product = |f: usize, g: usize, h: usize, k: usize| {
        let with = s(f, g);
        if with == 0.0 { 0.0 } else { with * moments(h, k) }
    };
    let entry = |[f, g]: [usize; 2], [h, k]: [usize; 2]| {
        let six = product(f, g, h, k)
            + product(h, k, f, g)
            + product(f, h, g, k)
            + product(g, k, f, h)
            + product(f, k, g, h)
            + product(g, h, f, k);
        six - weight * (s(f, g) * s(h, k) + s(f, h) * s(g, k) + s(f, k) * s(g, h))
    };
    let pairs = &terms.pairs;
    Mat::from_fn(pairs.len(), pairs.len(), |a, b| entry(pairs[a], pairs[b]))
}

/// All that rows say of the columns' products.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Factor {
    pub rows: u64,
    triangle: Triangle,
    /// Rows that are not yet in the triangle, one after the other.
    #[serde(skip)]
    waiting: Vec<f64>,
}

impl Factor {
    pub fn new(columns: usize) -> Self {
        Self { rows: 0, triangle: Triangle::new(columns), waiting: Vec::new() }
    }

    /// Takes a row. What is asked of the factor waits for [`Self::finish`].
    pub fn row(&mut self, values: impl IntoIterator<Item = f64>) {
        self.waiting.extend(values);
        self.rows += 1;
        if self.waiting.len() == BLOCK * self.triangle.columns() {
            self.settle();
        }
    }

    /// With all rows in the triangle.
    pub fn finish(mut self) -> Self {
        self.settle();
        self.waiting = Vec::new();
        self
    }

    pub fn settle(&mut self) {
        let columns = self.triangle.columns();
        let fill = |j: usize, below: &mut [f64]| {
            below
                .iter_mut()
                .zip(self.waiting[j..].iter().step_by(columns))
                .for_each(|(to, value)| *to = *value);
        };
        self.triangle.take(self.waiting.len() / columns, fill);
        self.waiting.clear();
    }

    /// Of parts, in their order.
    pub fn joined<'a>(columns: usize, parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Self::new(columns);
        parts.into_iter().for_each(|part| all.join(part));
        all
    }

    /// Takes what another factor has taken.
    pub fn join(&mut self, other: &Self) {
        let columns = self.triangle.columns();
        let waiting = other.waiting.chunks_exact(columns);
        let settled = other.rows - waiting.len() as u64;
        if self.rows == (self.waiting.len() / columns) as u64 {
            self.triangle.clone_from(&other.triangle);
        } else if settled > 0 {
            let fill = |j: usize, below: &mut [f64]| {
                (0..=j).for_each(|i| below[i] = other.triangle.at(i, j));
            };
            self.triangle.take(columns, fill);
        }
        self.rows += settled;
        waiting.for_each(|row| self.row(row.iter().copied()));
    }

    /// The same rows with each column times a factor.
    pub fn scaled(&self, by: &[f64]) -> Self {
        Self { rows: self.rows, triangle: self.triangle.scaled(by), waiting: Vec::new() }
    }

    /// Whether it is a factor of so many columns of finite numbers, after reading it from outside.
    pub fn is_whole(&self, columns: usize) -> bool {
        self.rows > 0
            && self.triangle.is_whole(columns)
            && (0..columns).all(|j| (0..=j).all(|i| self.triangle.at(i, j).is_finite()))
    }

    pub fn upper(&self) -> Mat<f64> {
        self.triangle.upper()
    }

    /// UᵀU between two columns.
    pub fn product(&self, a: usize, b: usize) -> f64 {
        self.triangle.product(a, b)
    }
}

/// Rows as they are, or where they are more than their columns as the rows of their factor.
pub fn compressed(rows: Vec<Vec<f64>>, columns: usize) -> Vec<Vec<f64>> {
    if rows.len() <= columns {
        return rows;
    }
    let mut factor = Factor::new(columns);
    rows.into_iter().for_each(|row| factor.row(row));
    covariance::rows(&factor.finish().upper())
}
