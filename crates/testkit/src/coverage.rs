//! Whether intervals hold as often as is said, and how many cases are looked at.

use std::env;

/// How many campaigns a test of coverage makes: FLUXCAL_CAMPAIGNS, or `usual`.
pub fn campaigns(usual: u64) -> u64 {
    number("FLUXCAL_CAMPAIGNS").unwrap_or(usual)
}

/// Every `step`-th of the cases, or all with FLUXCAL_CASES=all.
pub fn some<T>(cases: Vec<T>, step: usize) -> Vec<T> {
    let step = if env::var("FLUXCAL_CASES").is_ok_and(|which| which == "all") { 1 } else { step };
    cases.into_iter().step_by(step).collect()
}

/// The whole number in a variable of the environment.
pub fn number(variable: &str) -> Option<u64> {
    let text = env::var(variable).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{variable}={text}; expected a whole number")))
}

/// Tests that fail by chance do so in this share of their runs.
const CHANCE: f64 = 0.01;

/// Whether `inside` of `tried` agrees with a share within `band`, where `judged` shares are judged together:
/// no less probable, by the binomial distribution of the nearest end of the band, than 1 % over both ends and
/// all that are judged (Bonferroni).
pub fn agrees(inside: usize, tried: usize, band: [f64; 2], judged: usize) -> bool {
    let share = inside as f64 / tried as f64;
    let enough = CHANCE / (2.0 * judged as f64);
    if share < band[0] {
        at_most(inside, tried, band[0]) >= enough
    } else if share > band[1] {
        at_most(tried - inside, tried, 1.0 - band[1]) >= enough
    } else {
        true
    }
}

/// P(X ≤ k) of n trials with the probability p.
fn at_most(k: usize, n: usize, p: f64) -> f64 {
    let mut ln = n as f64 * (1.0 - p).ln();
    let mut sum = 0.0;
    for i in 0..=k {
        sum += ln.exp();
        ln += ((n - i) as f64 / (i + 1) as f64).ln() + (p / (1.0 - p)).ln();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_a_binomial() {
        // Two coins.
        assert!((at_most(0, 2, 0.5) - 0.25).abs() < 1e-12 && (at_most(1, 2, 0.5) - 0.75).abs() < 1e-12);
        assert!((at_most(10, 10, 0.3) - 1.0).abs() < 1e-12);
        let band = [0.93, 0.97];
        assert!(agrees(36, 40, band, 1) && agrees(40, 40, band, 1));
        // P(X ≤ 31) of 40 at 93 % is 1.5e-3: too few alone, not beside sixty others.
        assert!(!agrees(31, 40, band, 1) && agrees(31, 40, band, 60));
        assert!(!agrees(890, 1000, band, 60) && !agrees(999, 1000, band, 60));
    }
}
