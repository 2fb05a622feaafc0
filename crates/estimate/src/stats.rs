//! Probabilities that a fit is judged by.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// From here on Student's t is the normal to five digits, and its series do not converge.
pub(crate) const NORMAL_FROM: f64 = 1e6;

/// P(|t| ≥ `t`) for Student's t with `freedom` degrees of freedom; infinite freedom is the normal.
pub fn two_sided_p(t: f64, freedom: f64) -> f64 {
    let t = t.abs();
    if freedom > NORMAL_FROM {
        return 2.0 * Normal::standard().sf(t);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |law| 2.0 * law.sf(t))
}

/// The factor c with P(|t| ≤ c) = `probability`.
pub fn coverage_factor(probability: f64, freedom: f64) -> f64 {
    let tail = 0.5 + probability / 2.0;
    if freedom > NORMAL_FROM {
        return Normal::standard().inverse_cdf(tail);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |law| law.inverse_cdf(tail))
}

/// P(χ² ≥ `chi_squared`) with `freedom` degrees of freedom.
pub fn chi_squared_p(chi_squared: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(f64::NAN, |law| law.sf(chi_squared))
}

/// The χ² that is exceeded with the probability 1 − p, `freedom` degrees of freedom.
pub fn chi_squared_quantile(p: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom).map_or(f64::NAN, |law| law.inverse_cdf(p))
}

/// The factors by which an estimate of a variance with `freedom` degrees of freedom is to be multiplied for
/// the band that holds the true one with `probability`, half of the rest on either side: ν/χ²((1 + p)/2; ν)
/// and ν/χ²((1 − p)/2; ν), χ²(q; ν) the quantile of χ².
///
/// NaN if `probability` is not in 0 … 1.
pub fn variance_interval(freedom: f64, probability: f64) -> (f64, f64) {
    if !(0.0..=1.0).contains(&probability) {
        return (f64::NAN, f64::NAN);
    }
    let factor = |tail: f64| freedom / chi_squared_quantile(tail, freedom);
    (factor(0.5 + probability / 2.0), factor(0.5 - probability / 2.0))
}

/// P(F ≥ `f`) with `above` and `below` degrees of freedom; with infinitely many below, `above` F is χ².
pub fn f_p(f: f64, above: f64, below: f64) -> f64 {
    if below > NORMAL_FROM {
        return chi_squared_p(above * f, above);
    }
    FisherSnedecor::new(above, below).map_or(f64::NAN, |law| law.sf(f))
}

/// Root of the mean of the squares; zero of nothing.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// The mean, summed a second time about itself so that a large constant leaves no error of rounding.
pub fn mean(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let first = sum_from(values, 0.0) / n;
    first + sum_from(values, first) / n
}

/// Σ (x_i − x₀), in eight sums, which need not wait for one another.
pub(crate) fn sum_from(values: &[f64], from: f64) -> f64 {
    const SUMS: usize = 8;
    let mut sums = [0.0; SUMS];
    let blocks = values.chunks_exact(SUMS);
    let rest: f64 = blocks.remainder().iter().map(|x| x - from).sum();
    blocks.for_each(|block| sums.iter_mut().zip(block).for_each(|(sum, x)| *sum += x - from));
    sums.iter().sum::<f64>() + rest
}

/// Median of finite numbers; 0 of none.
pub fn median(values: &[f64]) -> f64 {
    median_of(&mut values.to_vec())
}

/// The same of numbers whose order does not matter any more.
pub fn median_of(values: &mut [f64]) -> f64 {
    let n = values.len();
    if n == 0 {
        return 0.0;
    }
    let (below, middle, _) = values.select_nth_unstable_by(n / 2, f64::total_cmp);
    match below.iter().copied().max_by(f64::total_cmp) {
        Some(before) if n.is_multiple_of(2) => 0.5 * (before + *middle),
        _ => *middle,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_tables() {
        // Student t: 2.228 for 10 degrees of freedom, 12.706 for 1; normal 1.95996; χ²(5) 11.0705 at 5 %.
        assert!((coverage_factor(0.95, 10.0) - 2.228_138_85).abs() < 1e-6);
        assert!((coverage_factor(0.95, 1.0) - 12.706_204_7).abs() < 1e-4);
        assert!((coverage_factor(0.95, f64::INFINITY) - 1.959_963_98).abs() < 1e-7);
        assert!((coverage_factor(0.95, 1e40) - 1.959_963_98).abs() < 1e-7);
        assert!((coverage_factor(0.95, 9e5) - 1.959_963_98).abs() < 1e-5);
        assert!((two_sided_p(2.228_138_85, 10.0) - 0.05).abs() < 1e-8);
        // F(2, 10) 4.1028 at 5 %.
        assert!((f_p(4.102_821, 2.0, 10.0) - 0.05).abs() < 1e-6);
        assert!((chi_squared_p(11.070_497_69, 5.0) - 0.05).abs() < 1e-8);
    }

    #[test]
    fn far_tails_keep_their_digits() {
        let p = two_sided_p(40.0, 50.0);
        assert!(p > 0.0 && p < 1e-35, "{p}");
    }
}
