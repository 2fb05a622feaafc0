//! The evidence for a set of columns with normal priors: a determinant and a quadratic form.
//!
//! With S the products of the columns and g those with the residual, all that the base model can take up
//! projected out, and V the prior variances, the marginal likelihood over that of no column is, at noise of
//! variance one,
//!
//! ```text
//! ln B = −½ ln |I + V^½ S V^½| + ½ gᵀ (S + V⁻¹)⁻¹ g
//! ```
//!
//! Where the size of the noise is known with ν degrees of freedom only, Student's form takes the place of the
//! exponential: −½ (ν + n) ln((ν + Q)/(ν + R)), Q = R − gᵀ (S + V⁻¹)⁻¹ g. Source: O'Hagan and Forster 2004,
//! Kendall's Advanced Theory of Statistics 2B, chapter 11.

use estimate::screen::Screen;

use crate::level::Rest;

/// A column with the variance of its coefficient beforehand.
pub type Term = (usize, f64);

/// Columns and residual given a set of terms.
#[derive(Clone, Debug)]
pub struct Given<'s> {
    screen: &'s Screen,
    terms: Vec<Term>,
    /// Lower triangle of I + V^½ S V^½ = L Lᵀ, row by row.
    factor: Vec<Vec<f64>>,
    /// L⁻¹ V^½ g.
    residual: Vec<f64>,
    log_determinant: f64,
}

#[derive(Clone, Copy, Debug)]
pub struct Further {
    /// ln |…| of the group.
    pub log_determinant: f64,
    /// By how much Q falls.
    pub gain: f64,
}

/// Lower triangle of the Cholesky factor; None unless the matrix is positive definite.
fn cholesky(size: usize, value: impl Fn(usize, usize) -> f64) -> Option<Vec<Vec<f64>>> {
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(size);
    for i in 0..size {
        let mut row: Vec<f64> = Vec::with_capacity(i + 1);
        for (j, earlier) in factor.iter().enumerate() {
            let done: f64 = row.iter().zip(earlier).map(|(a, b)| a * b).sum();
            row.push((value(i, j) - done) / earlier[j]);
        }
        let rest = value(i, i) - row.iter().map(|a| a * a).sum::<f64>();
        if !(rest > 0.0 && rest.is_finite()) {
            return None;
        }
        row.push(rest.sqrt());
        factor.push(row);
    }
    Some(factor)
}

/// L⁻¹ b.
fn forward(factor: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut solved: Vec<f64> = Vec::with_capacity(right.len());
    for (row, value) in factor.iter().zip(right) {
        let done: f64 = row.iter().zip(&solved).map(|(a, b)| a * b).sum();
        solved.push((value - done) / row[row.len() - 1]);
    }
    solved
}

/// L⁻ᵀ b.
fn backward(factor: &[Vec<f64>], right: &[f64]) -> Vec<f64> {
    let mut solved = right.to_vec();
    for i in (0..right.len()).rev() {
        let done: f64 = (i + 1..right.len()).map(|k| factor[k][i] * solved[k]).sum();
        solved[i] = (right[i] - done) / factor[i][i];
    }
    solved
}

fn log_determinant(factor: &[Vec<f64>]) -> f64 {
    factor.iter().map(|row| 2.0 * row[row.len() - 1].ln()).sum()
}

impl<'s> Given<'s> {
    /// Columns given a set of terms; None where their products are none.
    pub fn of(screen: &'s Screen, terms: Vec<Term>) -> Option<Self> {
        let root: Vec<f64> = terms.iter().map(|(_, variance)| variance.sqrt()).collect();
        let factor = cholesky(terms.len(), |i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            unit + root[i] * root[j] * screen.product(terms[i].0, terms[j].0)
        })?;
        let log_determinant = log_determinant(&factor);
        let mut given = Self { screen, terms, factor, residual: Vec::new(), log_determinant };
        given.residual = given.within(screen.columns());
        Some(given)
    }

    /// L⁻¹ V^½ S of a column; the residual is the last one.
    fn within(&self, column: usize) -> Vec<f64> {
        let of = |(term, variance): &Term| variance.sqrt() * self.screen.product(*term, column);
        let right: Vec<f64> = self.terms.iter().map(of).collect();
        forward(&self.factor, &right)
    }

    /// Q = R − gᵀ (S + V⁻¹)⁻¹ g.
    pub fn left(&self) -> f64 {
        let taken: f64 = self.residual.iter().map(|a| a * a).sum();
        (self.screen.sum_of_squares() - taken).max(0.0)
    }

    /// ln B of the terms, and of further ones.
    pub fn log_evidence(&self, rest: &Rest, further: Option<Further>) -> f64 {
        let whole = self.screen.sum_of_squares();
        let further = further.unwrap_or(Further { log_determinant: 0.0, gain: 0.0 });
        let left = (self.left() - further.gain).max(1e-12 * whole);
        -0.5 * (self.log_determinant + further.log_determinant) + rest.log_likelihood(whole, left)
    }

    /// Products of further columns, and those with the residual.
    pub fn block(&self, columns: &[usize]) -> Block {
        let last = self.screen.columns();
        let within: Vec<Vec<f64>> = columns.iter().map(|column| self.within(*column)).collect();
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let left =
            |i: usize, j: usize| self.screen.product(columns[i], columns[j]) - dot(&within[i], &within[j]);
        let row = |i: usize| (0..=i).map(|j| left(i, j)).collect();
        let along = |i: usize| self.screen.product(columns[i], last) - dot(&within[i], &self.residual);
        Block {
            products: (0..columns.len()).map(row).collect(),
            along: (0..columns.len()).map(along).collect(),
        }
    }

    /// The coefficients of the terms, at their most probable.
    pub fn coefficients(&self) -> Vec<f64> {
        let scaled = backward(&self.factor, &self.residual);
        scaled.iter().zip(&self.terms).map(|(value, (_, variance))| value * variance.sqrt()).collect()
    }
}

/// Further columns, given what is given.
#[derive(Clone, Debug)]
pub struct Block {
    /// Row i has the products with columns 0 to i.
    products: Vec<Vec<f64>>,
    along: Vec<f64>,
}

impl Block {
    /// I + V^½ S V^½ = L Lᵀ and L⁻¹ V^½ g; None where the products are none.
    fn solved(&self, deviations: &[f64]) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
        let factor = cholesky(deviations.len(), |i, j| {
            let unit = if i == j { 1.0 } else { 0.0 };
            unit + deviations[i] * deviations[j] * self.products[i][j]
        })?;
        let right: Vec<f64> = self.along.iter().zip(deviations).map(|(along, std)| along * std).collect();
        let solved = forward(&factor, &right);
        Some((factor, solved))
    }

    /// What they do with these standard deviations of their coefficients beforehand.
    pub fn further(&self, deviations: &[f64]) -> Option<Further> {
        let (factor, solved) = self.solved(deviations)?;
        let gain = solved.iter().map(|a| a * a).sum();
        Some(Further { log_determinant: log_determinant(&factor), gain })
    }

    pub fn coefficients(&self, deviations: &[f64]) -> Option<Vec<f64>> {
        let (factor, solved) = self.solved(deviations)?;
        let scaled = backward(&factor, &solved);
        Some(scaled.iter().zip(deviations).map(|(value, std)| value * std).collect())
    }
}

/// cᵀ S c of columns with coefficients.
pub fn energy(screen: &Screen, columns: &[usize], coefficients: &[f64]) -> f64 {
    let pairs = columns.iter().zip(coefficients);
    pairs.clone().map(|(i, a)| pairs.clone().map(|(j, b)| a * b * screen.product(*i, *j)).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// Columns and a residual of a few rows, errors of variance one, nothing projected out.
    fn screen() -> (Vec<[f64; 4]>, Screen) {
        let row = |k: usize| {
            let t = k as f64;
            [(0.7 * t).sin(), 0.2 * t - 1.0, (1.3 * t).cos(), 0.9 * (0.7 * t).sin() + (2.1 * t).sin()]
        };
        let rows: Vec<[f64; 4]> = (0..12).map(row).collect();
        let screen = Screen::of_rows(Mat::from_fn(12, 4, |i, j| rows[i][j]).as_ref());
        (rows, screen)
    }

    fn rest(screen: &Screen, known: f64) -> Rest {
        Rest { sum_of_squares: screen.sum_of_squares(), freedom: 12.0, known }
    }

    /// ∫∫ exp(−½ |y − X c|²) N(c; 0, V) dc over exp(−½ |y|²), by the trapezoidal rule, exact to rounding here.
    #[test]
    fn the_marginal_likelihood_is_the_integral() {
        let (rows, screen) = screen();
        let deviations = [0.8, 1.7];
        let (steps, reach) = (800, 9.0);
        let mut sum = 0.0;
        for i in 0..=2 * steps {
            for j in 0..=2 * steps {
                let z = [i, j].map(|k| (k as f64 / steps as f64 - 1.0) * reach);
                let c = [z[0] * deviations[0], z[1] * deviations[1]];
                let fell = |row: &[f64; 4]| {
                    let left = row[3] - c[0] * row[0] - c[1] * row[1];
                    row[3] * row[3] - left * left
                };
                let gain: f64 = rows.iter().map(fell).sum();
                sum += (0.5 * gain - 0.5 * (z[0] * z[0] + z[1] * z[1])).exp();
            }
        }
        let step = reach / steps as f64;
        let expected = (sum * step * step / std::f64::consts::TAU).ln();
        let terms = vec![(0, deviations[0].powi(2)), (1, deviations[1].powi(2))];
        let given = Given::of(&screen, terms).expect("positive");
        let found = given.log_evidence(&rest(&screen, f64::INFINITY), None);
        assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
    }

    /// Terms that come in later say what they say together; and Student's form tends to the normal one.
    #[test]
    fn further_terms_are_those_of_the_whole() {
        let (_, screen) = screen();
        let whole = Given::of(&screen, vec![(0, 0.5), (1, 2.0), (2, 1.0)]).expect("positive");
        let first = Given::of(&screen, vec![(0, 0.5)]).expect("positive");
        let deviations = [2.0_f64.sqrt(), 1.0];
        let block = first.block(&[1, 2]);
        let further = block.further(&deviations);
        for known in [f64::INFINITY, 20.0, 0.0] {
            let rest = rest(&screen, known);
            let (a, b) = (whole.log_evidence(&rest, None), first.log_evidence(&rest, further));
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
        let later = block.coefficients(&deviations).expect("positive");
        assert!(whole.coefficients()[1..].iter().zip(&later).all(|(a, b)| (a - b).abs() < 1e-12));
        let (student, normal) = (rest(&screen, 1e9), rest(&screen, f64::INFINITY));
        let apart = whole.log_evidence(&student, None) - whole.log_evidence(&normal, None);
        assert!(apart.abs() < 1e-6, "{apart}");
    }
}
