//! Whether residuals look like independent numbers of a normal law about zero.

use crate::stats;

/// Fewer values than these say nothing about the form of their distribution.
const LEAST_VALUES: usize = 8;

/// Fewer values of either sign than these, and the distribution of the runs is summed term by term.
const EXACT_BELOW: usize = 20;

/// The largest A*² for which the approximation of its probability is made; that one's probability is 5e−31.
const LARGEST: f64 = 13.0;

/// The Anderson-Darling test of normality, mean and variance estimated: A*² and the probability p of one as
/// large.
///
/// A² = −n − (1/n) Σ (2i − 1)(ln Φ(z_i) + ln Φ(−z_(n+1−i))), i = 1 … n,
///
/// z_i = (x_i − x̄)/s in ascending order, s with n − 1 in its denominator. For small samples A*² = A²(1 +
/// 0.75/n + 2.25/n²), and p is
///
/// - 1 − exp(−13.436 + 101.14 A*² − 223.73 A*⁴) for A*² < 0.2,
/// - 1 − exp(−8.318 + 42.796 A*² − 59.938 A*⁴) for A*² < 0.34,
/// - exp(0.9177 − 4.279 A*² − 1.38 A*⁴) for A*² < 0.6,
/// - exp(1.2937 − 5.709 A*² + 0.0186 A*⁴) above; beyond 13 it stays at the value of 13.
///
/// None for fewer than 8 values, for values without scatter, or where a value is not finite.
///
/// Source: M. A. Stephens, Tests based on EDF statistics, in R. B. D'Agostino, M. A. Stephens (eds.),
/// Goodness-of-Fit Techniques, Marcel Dekker 1986, Table 4.9.
pub fn anderson_darling(values: &[f64]) -> Option<(f64, f64)> {
    if values.len() < LEAST_VALUES {
        return None;
    }
    // The location does not matter; a large one would take digits.
    let values: Vec<f64> = values.iter().map(|x| x - values[0]).collect();
    let n = values.len() as f64;
    let mean = stats::mean(&values);
    let std = (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    if std == 0.0 || !std.is_finite() {
        return None;
    }
    let mut z: Vec<f64> = values.iter().map(|x| (x - mean) / std).collect();
    z.sort_by(f64::total_cmp);
    let terms = z.iter().zip(z.iter().rev()).enumerate();
    let sum: f64 =
        terms.map(|(i, (low, high))| (2 * i + 1) as f64 * (ln_normal(*low) + ln_normal(-high))).sum();
    let corrected = (-n - sum / n) * (1.0 + 0.75 / n + 2.25 / (n * n));
    Some((corrected, anderson_darling_p(corrected)))
}

/// The probability of an A*² as large as `a`.
fn anderson_darling_p(a: f64) -> f64 {
    match a {
        ..0.2 => -(-13.436 + 101.14 * a - 223.73 * a * a).exp_m1(),
        ..0.34 => -(-8.318 + 42.796 * a - 59.938 * a * a).exp_m1(),
        ..0.6 => (0.9177 - 4.279 * a - 1.38 * a * a).exp(),
        _ => {
            let a = a.min(LARGEST);
            (1.2937 - 5.709 * a + 0.0186 * a * a).exp()
        }
    }
}

/// ln Φ(z) of the normal law, also where Φ is too small for a number.
///
/// Φ(−x) for x > 0 is half the probability that χ² with one degree of freedom exceeds x². Below −20 it is
/// Laplace's continued fraction Φ(−x) = φ(x)/(x + 1/(x + 2/(x + 3/(x + …)))), φ the normal density.
fn ln_normal(z: f64) -> f64 {
    let beyond = |z: f64| 0.5 * stats::chi_squared_p(z * z, 1.0);
    if z > 0.0 {
        (-beyond(z)).ln_1p()
    } else if z > -20.0 {
        beyond(z).ln()
    } else {
        let fraction = (1..=8).rev().fold(-z, |rest, k| -z + f64::from(k) / rest);
        -0.5 * z * z - 0.5 * std::f64::consts::TAU.ln() - fraction.ln()
    }
}

/// The runs test of Wald and Wolfowitz: whether the signs of the values follow one another without order.
///
/// Gives z and the two-sided probability p. Of n = n₁ + n₂ values above and below zero, in their order, the R
/// runs of like sign have the mean μ = 2n₁n₂/n + 1 and the variance (μ − 1)(μ − 2)/(n − 1); z = (R − μ)/σ
/// with R half a run closer to μ, and 0 if that would go past it. Negative: fewer runs than chance would
/// make, so neighbours are alike.
///
/// p is that of z for a normal law; with fewer than 20 values of either sign it is twice the smaller tail of
/// the distribution of R itself, R included, at most 1:
///
/// P(R = 2k) = 2C(n₁−1, k−1)C(n₂−1, k−1)/C(n, n₁),
/// P(R = 2k+1) = (C(n₁−1, k)C(n₂−1, k−1) + C(n₁−1, k−1)C(n₂−1, k))/C(n, n₁).
///
/// Values that are zero are left out. None if there are none above or none below zero, or one is not a
/// number.
///
/// Source: A. Wald, J. Wolfowitz, On a test whether two samples are from the same population, Ann. Math.
/// Statist. 11 (1940) 147–162.
pub fn runs(values: &[f64]) -> Option<(f64, f64)> {
    if values.iter().any(|x| x.is_nan()) {
        return None;
    }
    let above: Vec<bool> = values.iter().filter(|x| **x != 0.0).map(|x| *x > 0.0).collect();
    let first = above.iter().filter(|above| **above).count();
    let second = above.len() - first;
    if first == 0 || second == 0 {
        return None;
    }
    let found = 1 + above.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let n = above.len() as f64;
    let changes = 2.0 * first as f64 * second as f64 / n;
    let variance = changes * (changes - 1.0) / (n - 1.0);
    let off = found as f64 - (changes + 1.0);
    // One value of either sign: two runs, whatever their order.
    let z = if variance == 0.0 { 0.0 } else { (off - off.clamp(-0.5, 0.5)) / variance.sqrt() };
    let p = if first.min(second) < EXACT_BELOW {
        runs_p(first, second, found)
    } else {
        stats::two_sided_p(z, f64::INFINITY)
    };
    Some((z, p))
}

/// Twice the smaller tail of the distribution of the runs, at most 1.
fn runs_p(first: usize, second: usize, found: usize) -> f64 {
    let most = (2 * first.min(second) + 1).min(first + second);
    let tail = |runs: std::ops::RangeInclusive<usize>| -> f64 {
        runs.map(|runs| runs_probability(first, second, runs)).sum()
    };
    (2.0 * tail(2..=found).min(tail(found..=most))).min(1.0)
}

/// P(R = `runs`) for `first` values of one sign and `second` of the other in any order, all as likely.
fn runs_probability(first: usize, second: usize, runs: usize) -> f64 {
    let (short, long) = (runs / 2, runs - runs / 2);
    let ways = |one: usize, other: usize| choose(first - 1, one - 1) * choose(second - 1, other - 1);
    (ways(short, long) + ways(long, short)) / choose(first + second, first)
}

/// The binomial coefficient C(n, k).
fn choose(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    (1..=k.min(n - k)).map(|i| (n + 1 - i) as f64 / i as f64).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_of_the_normal_law() {
        // With mpmath, 40 digits.
        for (z, expected) in [
            (6.0, -9.865_876_455_243_757e-10),
            (1.0, -0.172_753_779_023_449_89),
            (0.0, -std::f64::consts::LN_2),
            (-1.0, -1.841_021_645_009_263_5),
            (-19.99, -203.716_707_717_208_44),
            (-20.01, -204.117_702_778_659_9),
            (-40.0, -804.608_442_013_753_8),
            (-1000.0, -500_007.826_694_812_2),
        ] {
            let found = ln_normal(z);
            assert!((found / expected - 1.0).abs() < 1e-14, "{z}: {found}, {expected}");
        }
    }

    #[test]
    fn branches_of_the_probability_meet() {
        for (border, gap) in [(0.2, 1.1e-4), (0.34, 3.3e-3), (0.6, 2.6e-3)] {
            let step = anderson_darling_p(border) - anderson_darling_p(border - 1e-12);
            assert!(step.abs() < gap, "{border}: {step}");
        }
        assert_eq!(anderson_darling_p(LARGEST), anderson_darling_p(1e4));
        assert!((4.9e-31..5.0e-31).contains(&anderson_darling_p(LARGEST)));
    }
}
