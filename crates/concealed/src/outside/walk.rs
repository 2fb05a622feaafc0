//! A random walk that is drawn back to its mean.

use crate::draw::Draw;

/// A random course of mean 0 and variance 1 after each of the ways given: over a way w the correlation is
/// e^−w (Ornstein-Uhlenbeck).
///
/// Source: Uhlenbeck and Ornstein 1930, On the theory of the Brownian motion, Phys. Rev. 36, 823.
pub fn walk(ways: impl IntoIterator<Item = f64>, draw: &mut Draw) -> Vec<f64> {
    let mut at = draw.normal();
    let next = |way: f64| {
        let kept = (-way).exp();
        at = kept * at + (1.0 - kept * kept).sqrt() * draw.normal();
        at
    };
    ways.into_iter().map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_correlation_falls_exponentially() {
        let course = walk([0.2; 60_000], &mut Draw::new("walk", 1));
        for lag in [0, 1, 5] {
            let products = course.iter().zip(&course[lag..]).map(|(a, b)| a * b);
            let correlation = products.sum::<f64>() / (course.len() - lag) as f64;
            let expected = (-0.2 * lag as f64).exp();
            assert!((correlation - expected).abs() < 0.05, "{lag}: {correlation} for {expected}");
        }
    }

    /// Without a way nothing changes.
    #[test]
    fn standing_still_changes_nothing() {
        let course = walk([0.0; 20], &mut Draw::new("walk", 2));
        assert!(course.iter().all(|value| *value == course[0]));
    }
}
