//! Haar differences of power-law noise: the mean of 2^L samples less the mean of the 2^L before them.

use statrs::function::gamma::gamma;
use std::f64::consts::{LN_2, PI, TAU};
use std::sync::LazyLock;

/// Levels integrated over the spectrum; above, the law of unlimited noise and a term for what lies beyond the Nyquist
/// frequency.
const EXACT: usize = 7;
/// Panels of the integral: halves towards 0, then as many as the highest level has periods.
const HALVES: usize = 40;
const PANELS: usize = 1 << EXACT;
/// Nodes and weights of Gauss and Legendre on −1 … 1, the positive half.
const NODES: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// A frequency, its weight and the response of each level there.
struct Node {
    log: f64,
    weight: f64,
    response: [f64; EXACT],
}

/// Nodes over 0 < x ≤ 1/2, x = f Δt.
static GRID: LazyLock<Vec<Node>> = LazyLock::new(|| {
    let first = 0.5 / PANELS as f64;
    let halves = (0..HALVES).map(|i| (first * 0.5_f64.powi(i as i32 + 1), first * 0.5_f64.powi(i as i32)));
    let rest = (1..PANELS).map(|i| (first * i as f64, first * (i + 1) as f64));
    let mut nodes = Vec::new();
    for (from, to) in halves.chain(rest) {
        for (place, weight) in NODES.into_iter().flat_map(|(x, w)| [(-x, w), (x, w)]) {
            let x = 0.5 * (from + to) + 0.5 * (to - from) * place;
            let base = (PI * x).sin().powi(2);
            let response = std::array::from_fn(|level| {
                let length = (1_u64 << level) as f64;
                4.0 * (PI * length * x).sin().powi(4) / (length * length * base)
            });
            nodes.push(Node { log: x.ln(), weight: 0.5 * (to - from) * weight, response });
        }
    }
    nodes
});

/// Variance of the Haar differences at levels 0 … `levels` − 1 of noise with the one-sided density P(f) = Δt
/// f'^-α, f' = f Δt up to the Nyquist frequency 1/2, and nothing above it:
///
/// V_L(α) = ∫ x^-α 4 sin⁴(π m x)/(m² sin²(π x)) dx over 0 < x ≤ 1/2, m = 2^L, 0 ≤ α < 3.
///
/// Multiply by A Δt^(α−1) for the density A f^-α. White noise of variance σ² has 2σ²/m. Six digits or more.
pub fn power_law_variances(exponent: f64, levels: usize) -> Vec<f64> {
    let mut exact = [0.0; EXACT];
    for node in GRID.iter() {
        let density = node.weight * (-exponent * node.log).exp();
        exact.iter_mut().zip(&node.response).for_each(|(sum, response)| *sum += density * response);
    }
    let slope = 8.0 * doubling(exponent) * -scale(exponent);
    let length = |level: usize| 2.0_f64.powi(level as i32);
    // Beyond the power law: c₀ and c₁ m^(α−1), each over m², from the last two exact levels.
    let rest =
        |level: usize| (exact[level] - slope * length(level).powf(exponent - 1.0)) * length(level).powi(2);
    let power = |level: usize| ratio(exponent - 1.0, length(level).ln());
    let (before, last) = (EXACT - 2, EXACT - 1);
    let rise = (rest(last) - rest(before)) / (power(last) - power(before));
    let beyond = |level: usize| rest(last) + rise * (power(level) - power(last));
    (0..levels)
        .map(|level| match exact.get(level) {
            Some(variance) => *variance,
            None => slope * length(level).powf(exponent - 1.0) + beyond(level) / length(level).powi(2),
        })
        .collect()
}

/// Generalised covariance of the running sum of such noise over h samples, α < 3, up to multiples of 1 and
/// h²:
///
/// g(h) = −(2π)^(α−1) sin(πα/2) Γ(2 − α)/(α(α + 1)) h² (h^(α−1) − 1)/(α − 1).
///
/// Contrasts of the sums that no constant and no slope moves have the covariance −Σ a_i b_j g(|t_i − s_j|).
/// It is that of unlimited noise, which the band's end changes by m^-2 for averages over m samples.
pub fn sum_covariance(exponent: f64) -> impl Fn(f64) -> f64 {
    let scale = scale(exponent);
    move |h| if h == 0.0 { 0.0 } else { scale * h * h * ratio(exponent - 1.0, h.abs().ln()) }
}

/// (e^(p q) − 1)/p, also at p = 0.
fn ratio(p: f64, q: f64) -> f64 {
    if p.abs() < 1e-12 { q } else { (p * q).exp_m1() / p }
}

/// (2^(α−1) − 1)/(α − 1).
fn doubling(exponent: f64) -> f64 {
    ratio(exponent - 1.0, LN_2)
}

fn scale(exponent: f64) -> f64 {
    // sin(πα/2) Γ(2 − α) = sin(π(2 − α)/2)/(2 − α) Γ(3 − α), and sin(πα/2)/α is π/2 at 0.
    let two = 2.0 - exponent;
    if exponent < 1.0 {
        let sine = if exponent.abs() < 1e-9 { 0.5 * PI } else { (0.5 * PI * exponent).sin() / exponent };
        return -TAU.powf(exponent - 1.0) * sine * gamma(two) / (exponent + 1.0);
    }
    let sine = if two.abs() < 1e-9 { 0.5 * PI } else { (0.5 * PI * two).sin() / two };
    -TAU.powf(exponent - 1.0) * sine * gamma(3.0 - exponent) / (exponent * (exponent + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_forms() {
        // White noise of density 1 has the variance 1/2; its differences 1/m.
        for (level, variance) in power_law_variances(0.0, 20).into_iter().enumerate() {
            assert!((variance * 2.0_f64.powi(level as i32) - 1.0).abs() < 1e-9, "{level} {variance}");
        }
        // Flicker noise: twice the Allan variance 2 ln 2.
        let flicker = power_law_variances(1.0, 30);
        assert!((flicker[29] - 4.0 * LN_2).abs() < 1e-9, "{}", flicker[29]);
        // One sample: 2 ∫ (1 − cos 2πx)/x dx = 2 Cin(π).
        assert!((flicker[0] - 2.0 * 1.648_277_637).abs() < 1e-8, "{}", flicker[0]);
        // Random walk of variance q a step, P = 2 q Δt/(2π f)²: (2/3 m) q for long averages.
        let walk = power_law_variances(2.0, 30)[29] * 2.0 / (TAU * TAU);
        assert!((walk / (2.0 / 3.0 * 2.0_f64.powi(29)) - 1.0).abs() < 1e-9, "{walk}");
    }

    #[test]
    fn the_levels_join_and_the_exponent_passes_one_and_two() {
        for exponent in [0.3, 0.8, 1.0, 1.4, 2.0, 2.4] {
            let slope = -8.0 * scale(exponent) * doubling(exponent);
            let of = power_law_variances(exponent, 12);
            // The first three exact levels from which the form c₀ + c₁ m^(α−1) can be told.
            let rest: Vec<f64> = (4..7)
                .map(|l| (of[l] - slope * 2.0_f64.powf(l as f64 * (exponent - 1.0))) * 4.0_f64.powi(l as i32))
                .collect();
            let grown = (rest[2] - rest[1]) / (rest[1] - rest[0]);
            assert!((grown / 2.0_f64.powf(exponent - 1.0) - 1.0).abs() < 0.02, "{exponent} {rest:?} {grown}");
            let near = power_law_variances(exponent + 1e-7, 12);
            assert!((near[11] / of[11] - 1.0).abs() < 2e-6);
            let g = sum_covariance(exponent)(3.7);
            assert!((sum_covariance(exponent + 1e-7)(3.7) / g - 1.0).abs() < 1e-5);
            // The difference of two averages from the generalised covariance.
            let of_g = 8.0 * sum_covariance(exponent)(1.0) - 2.0 * sum_covariance(exponent)(2.0);
            assert!((of_g / slope - 1.0).abs() < 1e-12);
        }
    }
}
