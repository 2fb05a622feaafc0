//! Courses of what relaxes, from 0 at the beginning, on and on more slowly.

/// Logarithmic relaxation of what was made a time ago, with barriers of all heights alike: ln(1 + t/a).
/// Source: Street and Woolley 1949, A study of magnetic viscosity, Proc. Phys. Soc. A 62, 562.
pub fn logarithmic(t: f64, age_s: f64) -> f64 {
    (t / age_s).ln_1p()
}

/// Stretched exponential of what was made a time ago: exp(−(a/τ)^β) − exp(−((a + t)/τ)^β). Source: Kohlrausch
/// 1854; Williams and Watts 1970, Trans. Faraday Soc. 66, 80.
pub fn stretched(t: f64, age_s: f64, tau_s: f64, exponent: f64) -> f64 {
    let left = |age: f64| (-(age / tau_s).powf(exponent)).exp();
    left(age_s) - left(age_s + t)
}

/// Ageing in proportion to the root of the time of service: √(a + t) − √a. Makers of voltage references state
/// their drift so, in ppm for the root of a thousand hours.
pub fn root(t: f64, age_s: f64) -> f64 {
    (age_s + t).sqrt() - age_s.sqrt()
}

/// Two exponentials beside each other of something that was made a time ago: Σ w_k (exp(−a/τ_k) − exp(−(a +
/// t)/τ_k)).
pub fn two(t: f64, age_s: f64, parts: [(f64, f64); 2]) -> f64 {
    parts.iter().map(|(weight, tau)| weight * ((-age_s / tau).exp() - (-(age_s + t) / tau).exp())).sum()
}

/// How many times faster something ages at a temperature than at a reference: exp(E (1/T_0 − 1/T)), E an
/// activation energy over Boltzmann's constant, K. Source: Arrhenius 1889.
pub fn hastened(temperature_c: f64, reference_c: f64, activation_k: f64) -> f64 {
    (activation_k * (1.0 / (reference_c + 273.15) - 1.0 / (temperature_c + 273.15))).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each begins at 0, and at its derivative's rate: 1/a, β (a/τ)^β exp(−(a/τ)^β) / a and 1/(2 √a).
    #[test]
    fn they_begin_at_zero_with_their_rates() {
        let (age, tau, exponent): (f64, f64, f64) = (900.0, 2000.0, 0.6);
        let share = (age / tau).powf(exponent);
        let begins = |course: f64, rate: f64| assert!((course / (0.01 * rate) - 1.0).abs() < 1e-4);
        begins(logarithmic(0.01, age), 1.0 / age);
        begins(stretched(0.01, age, tau, exponent), exponent * share * (-share).exp() / age);
        begins(root(0.01, age), 0.5 / age.sqrt());
        assert_eq!([logarithmic(0.0, age), stretched(0.0, age, tau, exponent), root(0.0, age)], [0.0; 3]);
    }

    /// Equal steps of the logarithm of time take equal steps; four times the time doubles the root; the
    /// stretched one ends.
    #[test]
    fn they_go_on_by_their_laws() {
        assert!((logarithmic(9.0e6, 1.0) - 2.0 * logarithmic(2999.0, 1.0)).abs() < 1e-3);
        assert!((root(400.0, 0.0) - 2.0 * root(100.0, 0.0)).abs() < 1e-12);
        assert!((stretched(1e9, 0.0, 10.0, 0.5) - 1.0).abs() < 1e-12);
        assert!((stretched(30.0, 0.0, 10.0, 1.0) - (1.0 - (-3.0_f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn two_exponentials_are_the_sum_of_theirs() {
        let one = |t: f64, age: f64, tau: f64| stretched(t, age, tau, 1.0);
        let parts = [(0.3, 40.0), (0.7, 300.0)];
        let sum = 0.3 * one(25.0, 60.0, 40.0) + 0.7 * one(25.0, 60.0, 300.0);
        assert!((two(25.0, 60.0, parts) - sum).abs() < 1e-12);
    }

    /// With E = ln 2 · T T_0 / 10 K ten degrees double the rate.
    #[test]
    fn ten_degrees_double_the_rate() {
        let activation = 2.0_f64.ln() * 296.15 * 306.15 / 10.0;
        assert!((hastened(33.0, 23.0, activation) - 2.0).abs() < 1e-9);
        assert_eq!(hastened(23.0, 23.0, activation), 1.0);
    }
}
