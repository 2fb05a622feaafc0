//! The mains' field, whose frequency is that of a grid under changing load.

use crate::draw::Draw;

/// Phase of the mains at given times, rad. The frequency is 50 Hz with a fixed departure and an
/// Ornstein-Uhlenbeck process on top:
///
/// ```text
/// dφ/dt = 2π (50 + δ + x),   dx = −x dt/θ + s √(2/θ) dW
/// ```
///
/// Source: Schäfer et al. 2018, Non-Gaussian power grid frequency fluctuations, Nature Energy 3, 119 (θ of
/// minutes, s of 20 mHz).
pub fn phase(times: &[f64], departure_hz: f64, wander_hz: f64, wander_s: f64, draw: &mut Draw) -> Vec<f64> {
    let mut phase = draw.between(0.0, std::f64::consts::TAU);
    let mut wander = wander_hz * draw.normal();
    let mut at = times.first().copied().unwrap_or(0.0);
    times
        .iter()
        .map(|&time| {
            let step = time - at;
            phase += std::f64::consts::TAU * (50.0 + departure_hz + wander) * step;
            let kept = (-step / wander_s).exp();
            wander = kept * wander + wander_hz * (1.0 - kept * kept).sqrt() * draw.normal();
            at = time;
            phase
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_wander_it_is_a_pure_line() {
        let times: Vec<f64> = (0..500).map(|k| 0.004 * f64::from(k)).collect();
        let phase = phase(&times, 0.02, 0.0, 60.0, &mut Draw::new("line", 1));
        for (t, p) in times.iter().zip(&phase) {
            assert!((p - phase[0] - std::f64::consts::TAU * 50.02 * t).abs() < 1e-9);
        }
    }

    #[test]
    fn it_wanders_by_what_is_stated() {
        let times: Vec<f64> = (0..20_000).map(f64::from).collect();
        let phase = phase(&times, 0.0, 0.02, 10.0, &mut Draw::new("wander", 1));
        let rates: Vec<f64> =
            phase.windows(2).map(|p| (p[1] - p[0]) / std::f64::consts::TAU - 50.0).collect();
        let rms = (rates.iter().map(|r| r * r).sum::<f64>() / rates.len() as f64).sqrt();
        // 1000 independent stretches: 3 %.
        assert!((rms / 0.02 - 1.0).abs() < 0.1, "{rms}");
    }
}
