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

use faer::Mat;

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
/// over the three. Taken off the normal equations, it leaves an estimate without bias at any size of the
/// noise.
///
/// `variance` is S, diagonal, over all columns and F; `moments(f, g)` is Σ z_f z_g/4F² over the rows.
///
/// Source: I. Markovsky, A. Kukush, S. Van Huffel, Consistent least squares fitting of ellipsoids, Numer.
/// Math. 98 (2004) 177–194.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_pairs() {
        let terms = Terms::new(6);
        for (place, [f, g]) in terms.pairs.iter().enumerate() {
            assert_eq!(terms.place(*f, *g), Some(place));
            assert_eq!(terms.place(*g, *f), Some(place));
        }
        assert_eq!((terms.count(), terms.place(0, 6)), (23, None));
        let mut row = vec![0.0; terms.count()];
        let z = [0.3, -0.2, 0.9, 1.0, 7.0, -2.0, 0.5];
        terms.fill(&z, &mut row);
        for ([f, g], value) in terms.pairs.iter().zip(row) {
            assert!((value - z[*f] * z[*g]).abs() < 1e-15);
        }
    }
}
