//! How far noise of the reference can pull at most.

use crate::regression::AxisFit;
use joined::Pair;

/// The largest pull of each element, [reference][test], whichever part of the difference is the reference's.
///
/// With M of the weighted fit the pull of column j is M⁻¹ N η_j, N_kk = Σ P_e,k/P_d,j over the ordinates, and
/// the reference's axis k cannot have more noise than what it would leave in any difference, P_e,k ≤
/// P_d,l/η_kl². Each N_kk takes its largest value where it pulls one way and zero where it pulls the other.
pub fn largest_pull(pair: &Pair, fits: &[AxisFit; 3]) -> [[f64; 3]; 3] {
    let rows = pair.whole.len();
    let eta = |k: usize, l: usize| fits[l].fit.weighted[k];
    let mut most = [[0.0; 3]; 3];
    for order in 1..=rows / 2 {
        let frequency = order as f64 / (rows as f64 * pair.step_s);
        let twice = if 2 * order == rows { 1.0 } else { 2.0 };
        let level = fits.each_ref().map(|of| of.noise.level(frequency));
        let weighing = fits.each_ref().map(|of| of.noise.density(frequency));
        for (k, most) in most.iter_mut().enumerate() {
            let allowed = (0..3).map(|l| level[l] / eta(k, l).powi(2)).fold(f64::INFINITY, f64::min);
            most.iter_mut().zip(weighing).for_each(|(most, weighing)| *most += twice * allowed / weighing);
        }
    }
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let part = |k: usize| fits[j].fit.weighted_covariance[(i, k)] * most[k][j] * eta(k, j);
            let up: f64 = (0..3).map(|k| part(k).max(0.0)).sum();
            let down: f64 = (0..3).map(|k| (-part(k)).max(0.0)).sum();
            up.max(down)
        })
    })
}
