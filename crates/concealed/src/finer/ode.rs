//! A system of ordinary differential equations, marched along.

/// The states of dx/dt = f(t, x) at given times, from `state` at `from`, by the classical Runge-Kutta method
/// of fourth order with steps of at most `largest_s`. Times must not run backwards. Source: Hairer, Nørsett
/// and Wanner 1993, Solving Ordinary Differential Equations I.
pub fn march<const N: usize>(
    from: f64,
    mut state: [f64; N],
    times: &[f64],
    largest_s: f64,
    slope: impl Fn(f64, &[f64; N]) -> [f64; N],
) -> Vec<[f64; N]> {
    let moved =
        |x: &[f64; N], by: &[f64; N], step: f64| -> [f64; N] { std::array::from_fn(|k| x[k] + step * by[k]) };
    let mut at = from;
    let mut states = Vec::with_capacity(times.len());
    for &time in times {
        let count = ((time - at) / largest_s).ceil().max(0.0) as usize;
        let (begin, step) = (at, (time - at) / count.max(1) as f64);
        for k in 0..count {
            let t = begin + step * k as f64;
            let a = slope(t, &state);
            let b = slope(t + 0.5 * step, &moved(&state, &a, 0.5 * step));
            let c = slope(t + 0.5 * step, &moved(&state, &b, 0.5 * step));
            let d = slope(t + step, &moved(&state, &c, step));
            state = std::array::from_fn(|n| state[n] + step / 6.0 * (a[n] + 2.0 * b[n] + 2.0 * c[n] + d[n]));
        }
        at = time;
        states.push(state);
    }
    states
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A driven lag: τ y' = sin(ω t) − y has a closed form.
    #[test]
    fn a_driven_lag_is_its_closed_form() {
        let (tau, omega) = (7.0_f64, 0.3_f64);
        let times: Vec<f64> = (1..60).map(|k| 1.7 * f64::from(k)).collect();
        let states = march(0.0, [0.0], &times, 0.1, |t, y| [((omega * t).sin() - y[0]) / tau]);
        let scale = 1.0 / (1.0 + (omega * tau).powi(2));
        for (t, y) in times.iter().zip(states) {
            let steady = scale * ((omega * t).sin() - omega * tau * (omega * t).cos());
            let exact = steady + scale * omega * tau * (-t / tau).exp();
            assert!((y[0] - exact).abs() < 1e-9, "{t}: {} for {exact}", y[0]);
        }
    }

    /// An oscillator keeps its energy to the fourth order.
    #[test]
    fn halving_the_step_takes_a_sixteenth() {
        let error = |step: f64| {
            let end = march(0.0, [1.0, 0.0], &[20.0], step, |_, x| [x[1], -x[0]]);
            (end[0][0] - 20.0_f64.cos()).abs()
        };
        let ratio = error(0.1) / error(0.05);
        assert!((14.0..18.0).contains(&ratio), "{ratio}");
    }
}
