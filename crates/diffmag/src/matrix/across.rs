//! Covariance of η between the test instrument's axes, whose differences may have noise in common.

use estimate::dot;

/// Coefficients of the lowest band; each further band has as many as all below it.
const BAND: usize = 32;

/// The fit of one axis, whitened: coefficients of the cosine transform over their standard deviations.
pub struct Whitened {
    /// Weights of η of the reference's x, y, z: their sums of products are its covariance.
    pub weights: [Vec<f64>; 3],
    /// What is left.
    pub left: Vec<f64>,
}

impl Whitened {
    /// How many times as wide as under the fitted noise the uncertainties of η are by what is left itself,
    /// the most of the three: √(Σ w² l²/Σ w²), l what is left. It holds for a noise of any spectrum, roughly:
    /// few coefficients weigh much.
    ///
    /// Source: H. White, A heteroskedasticity-consistent covariance matrix estimator, Econometrica 48 (1980)
    /// 817–838.
    pub fn wider(&self) -> f64 {
        let of = |weights: &Vec<f64>| {
            let squares = weights.iter().zip(&self.left).map(|(w, l)| (w * l).powi(2)).sum::<f64>();
            (squares / dot(weights, weights)).sqrt()
        };
        self.weights.iter().map(of).fold(0.0, f64::max)
    }
}

/// Cov(η_ia, η_kb) = Σ_B ρ_B Σ_(k in B) w_ia w_kb over bands B, ρ_B how far what is left of the two axes goes
/// together there.
///
/// Where an axis rests on a lower band than the other, its weights and what is left of it count as zero
/// above; so the nine have a covariance that is positive semidefinite.
pub fn covariance(a: &Whitened, b: &Whitened) -> [[f64; 3]; 3] {
    let mut sum = [[0.0; 3]; 3];
    let mut from = 0;
    while from < a.left.len().min(b.left.len()) {
        let to = from + from.max(BAND);
        let (left_a, left_b) = (band(&a.left, from, to), band(&b.left, from, to));
        let squares = dot(left_a, left_a) * dot(left_b, left_b);
        let together = if squares > 0.0 { dot(left_a, left_b) / squares.sqrt() } else { 0.0 };
        for (row, of_a) in sum.iter_mut().zip(&a.weights) {
            for (value, of_b) in row.iter_mut().zip(&b.weights) {
                *value += together * dot(band(of_a, from, to), band(of_b, from, to));
            }
        }
        from = to;
    }
    sum
}

fn band(values: &[f64], from: usize, to: usize) -> &[f64] {
    &values[from..to.min(values.len())]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the noise where η rests makes its uncertainty twice as wide, elsewhere it does not count.
    #[test]
    fn as_wide_as_what_is_left() {
        let count = 4000;
        let weights = |k: usize| if k < count / 2 { 1.0 / (1.0 + k as f64 / 500.0) } else { 0.0 };
        let mut state = 3_u64;
        let mut left = |size: f64| {
            state = (1_664_525 * state + 1_013_904_223) % (1 << 32);
            size * 12_f64.sqrt() * (state as f64 / 2_f64.powi(32) - 0.5)
        };
        for (low, high, wider) in [(1.0, 1.0, 1.0), (2.0, 1.0, 2.0), (1.0, 3.0, 1.0)] {
            let left = (0..count).map(|k| left(if k < count / 2 { low } else { high })).collect();
            let found =
                Whitened { weights: std::array::from_fn(|_| (0..count).map(weights).collect()), left };
            assert!((found.wider() / wider - 1.0).abs() < 0.1, "{}", found.wider());
        }
    }
}
