//! State equations of effects with memory, over the recording's own times, whatever the steps.
//!
//! Between its samples a signal is the cubic through them whose slopes are the central differences (those of
//! `numpy.gradient`). A step more than four times as long as a neighbour is a gap: there the line is straight.

use crate::Real;

/// A step longer than this many times a neighbouring one is a gap.
const GAP: f64 = 4.0;
/// Steps that differ by less than this share are one.
const SAME_STEP: f64 = 1e-9;

/// A signal between its samples.
pub struct Signal<'a, T> {
    time_s: &'a [f64],
    x: Vec<T>,
}

/// One step of a signal: x(s) = a + b s + c s² + d s³ for s = 0..1 over `step_s` seconds.
struct Cubic<T> {
    step_s: f64,
    powers: [T; 4],
}

impl<'a, T: Real> Signal<'a, T> {
    /// The signal with the samples x at times that do not run backwards. A missing sample (NaN) is bridged by the
    /// straight line between its neighbours.
    pub fn new(time_s: &'a [f64], x: Vec<T>) -> Self {
        Self { time_s, x: bridged(time_s, x) }
    }

    fn step_s(&self, row: usize) -> f64 {
        self.time_s[row + 1] - self.time_s[row]
    }

    /// Central difference at a row, one-sided at the ends and beside a step of no length.
    fn slope(&self, row: usize) -> T {
        let over = |from: usize| (self.x[from + 1] - self.x[from]) / self.step_s(from);
        let before = if row > 0 { self.step_s(row - 1) } else { 0.0 };
        let after = if row + 1 < self.x.len() { self.step_s(row) } else { 0.0 };
        match (before > 0.0, after > 0.0) {
            (true, true) => (over(row - 1) * after + over(row) * before) / (before + after),
            (true, false) => over(row - 1),
            (false, true) => over(row),
            (false, false) => T::from(0.0),
        }
    }

    /// The step that begins at a row.
    fn cubic(&self, row: usize) -> Cubic<T> {
        let step_s = self.step_s(row);
        let (from, rise) = (self.x[row], self.x[row + 1] - self.x[row]);
        if self.is_gap(row) {
            return Cubic { step_s, powers: [from, rise, T::from(0.0), T::from(0.0)] };
        }
        let (start, end) = (self.slope(row) * step_s, self.slope(row + 1) * step_s);
        Cubic { step_s, powers: [from, start, rise * 3.0 - start * 2.0 - end, start + end - rise * 2.0] }
    }

    fn is_gap(&self, row: usize) -> bool {
        let longer = |other: usize| self.step_s(row) > GAP * self.step_s(other) && self.step_s(other) > 0.0;
        (row > 0 && longer(row - 1)) || (row + 2 < self.time_s.len() && longer(row + 1))
    }

    /// First-order lag τ y' = x − y, exact for the signal. `initial` is y at the first row; None: in equilibrium with x.
    ///
    /// Over a step h with u = h/τ: y₊ = y e^(−u) + Σ p_k w_k(u), w_k = u ∫₀¹ e^(−u(1−s)) s^k ds.
    pub fn lagged(&self, tau_s: T, initial: Option<T>) -> Vec<T> {
        let Some(first) = self.x.first() else { return Vec::new() };
        let mut y = initial.unwrap_or(*first);
        let mut lagged = Vec::with_capacity(self.x.len());
        lagged.push(y);
        let (mut known, mut decay, mut weights) = (f64::NAN, T::from(0.0), [T::from(0.0); 4]);
        for row in 0..self.x.len() - 1 {
            let cubic = self.cubic(row);
            if cubic.step_s > 0.0 {
                // Times are rounded: a step that differs by less than that is the same.
                if (cubic.step_s - known).abs() > SAME_STEP * known || known.is_nan() {
                    known = cubic.step_s;
                    let steps = tau_s.recip() * known;
                    decay = (-steps).exp();
                    weights = moments(steps);
                }
                y *= decay;
                for (power, weight) in cubic.powers.iter().zip(&weights) {
                    y += *power * *weight;
                }
            }
            lagged.push(y);
        }
        lagged
    }

    /// The signal at times t − delay(row); constant before the first row and after the last.
    pub fn delayed(&self, delay_s: impl Fn(usize) -> T) -> Vec<T> {
        let last = self.time_s.len() - 1;
        let mut row = 0;
        (0..self.x.len())
            .map(|at| {
                let when = -delay_s(at) + self.time_s[at];
                let t = when.re();
                if t <= self.time_s[0] {
                    return self.x[0];
                }
                if t >= self.time_s[last] {
                    return self.x[last];
                }
                while row > 0 && self.time_s[row] > t {
                    row -= 1;
                }
                while row + 1 < last && self.time_s[row + 1] <= t {
                    row += 1;
                }
                let Cubic { step_s, powers: [a, b, c, d] } = self.cubic(row);
                let s = (when - self.time_s[row]) / step_s;
                a + s * (b + s * (c + s * d))
            })
            .collect()
    }
}

impl<T: Real> Signal<'_, T> {
    /// The mean over `width_s` about each row: what a logger stores that averages. Constant beyond the ends.
    pub fn averaged(&self, width_s: f64) -> Vec<T> {
        let last = self.x.len() - 1;
        let mut first = 0;
        (0..=last)
            .map(|row| {
                let (from, to) = (self.time_s[row] - width_s / 2.0, self.time_s[row] + width_s / 2.0);
                while first < last && self.time_s[first + 1] <= from {
                    first += 1;
                }
                // About the row's own value, so that long sums do not lose it.
                let own = self.x[row];
                let before = (self.time_s[0] - from).clamp(0.0, width_s);
                let after = (to - self.time_s[last]).clamp(0.0, width_s);
                let mut sum = (self.x[0] - own) * before + (self.x[last] - own) * after;
                for step in (first..last).take_while(|step| self.time_s[*step] < to) {
                    let cubic = self.cubic(step);
                    if cubic.step_s > 0.0 {
                        let share = |t: f64| ((t - self.time_s[step]) / cubic.step_s).clamp(0.0, 1.0);
                        sum += cubic.integral(share(from), share(to), own);
                    }
                }
                own + sum / width_s
            })
            .collect()
    }
}

impl<T: Real> Cubic<T> {
    /// ∫ (x − level) dt over a share of the step.
    fn integral(&self, from: f64, to: f64, level: T) -> T {
        let [a, b, c, d] = self.powers;
        let up_to = |s: f64| ((a - level) + (b / 2.0 + (c / 3.0 + d / 4.0 * s) * s) * s) * s;
        (up_to(to) - up_to(from)) * self.step_s
    }
}

impl Signal<'_, f64> {
    /// ∫ x dt from the first row to each, exact for the signal.
    pub fn integral(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let steps = (1..self.x.len()).map(|row| {
            sum += self.cubic(row - 1).integral(0.0, 1.0, 0.0);
            sum
        });
        std::iter::once(0.0).take(self.x.len()).chain(steps).collect()
    }
}

/// w_k(u) = u ∫₀¹ e^(−u(1−s)) s^k ds for k = 0..3; w_k = 1 − k w_(k−1)/u, backwards from a series where u is small.
fn moments<T: Real>(u: T) -> [T; 4] {
    let one = T::from(1.0);
    if u.re() > 1.0 {
        let w0 = one - (-u).exp();
        let w1 = one - w0 / u;
        let w2 = one - w1 * 2.0 / u;
        return [w0, w1, w2, one - w2 * 3.0 / u];
    }
    // w_3 = Σ 3! u (−u)^n / (n+4)!; 1/20! is below rounding.
    let (mut term, mut w3) = (u / 4.0, u / 4.0);
    for n in 1..=16 {
        term *= -u / f64::from(n + 4);
        w3 += term;
    }
    let w2 = (one - w3) * u / 3.0;
    let w1 = (one - w2) * u / 2.0;
    [(one - w1) * u, w1, w2, w3]
}

/// x with missing samples replaced: straight lines between neighbours, constant at the ends; zero if all are missing.
fn bridged<T: Real>(time_s: &[f64], mut x: Vec<T>) -> Vec<T> {
    if x.iter().all(|x| x.re().is_finite()) {
        return x;
    }
    let known: Vec<usize> = (0..x.len()).filter(|&row| x[row].re().is_finite()).collect();
    for row in 0..x.len() {
        if x[row].re().is_finite() {
            continue;
        }
        let after = known.partition_point(|&k| k < row);
        x[row] = match (after.checked_sub(1).map(|i| known[i]), known.get(after)) {
            (Some(a), Some(&b)) if time_s[b] > time_s[a] => {
                x[a] + (x[b] - x[a]) * ((time_s[row] - time_s[a]) / (time_s[b] - time_s[a]))
            }
            (Some(a), _) => x[a],
            (None, Some(&b)) => x[b],
            (None, None) => T::from(0.0),
        };
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::Dual64;

    #[test]
    fn step_and_ramp_by_hand() {
        // Response to a ramp of 2 units/s from equilibrium: 2 (t − τ (1 − e^(−t/τ))), whatever the steps.
        let time = [0.0, 0.1, 0.15, 1.0, 1.0, 7.5, 30.0];
        let ramp: Vec<f64> = time.iter().map(|t| 2.0 * t).collect();
        let tau = 3.0;
        for (t, y) in time.iter().zip(Signal::new(&time, ramp).lagged(tau, None)) {
            assert!((y - 2.0 * (t - tau * (1.0 - (-t / tau).exp()))).abs() < 1e-12);
        }
        // A constant 5 from 0: 5 (1 − e^(−t/τ)); the missing sample changes nothing.
        let level = [5.0, 5.0, f64::NAN, 5.0, 5.0, 5.0, 5.0];
        for (t, y) in time.iter().zip(Signal::new(&time, level.to_vec()).lagged(tau, Some(0.0))) {
            assert!((y - 5.0 * (1.0 - (-t / tau).exp())).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sine_lags_by_its_phase_also_where_the_lag_is_short() {
        // In the long run A/√(1+ω²τ²) sin(ωt − atan ωτ); the cubic is good to a few (ωh)³.
        let time: Vec<f64> = (0..4000).map(|row| f64::from(row) * 0.05).collect();
        let x: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        for tau in [0.001, 0.01, 0.2, 3.0] {
            let gain = 1.0 / f64::sqrt(1.0 + tau * tau);
            let signal = Signal::new(&time, x.clone());
            let lagged = signal.lagged(tau, None);
            let worst = (3000..3999)
                .map(|row| (lagged[row] - gain * (time[row] - tau.atan()).sin()).abs())
                .fold(0.0, f64::max);
            assert!(worst < 5e-4 * tau.min(1.0), "{tau}: {worst}");
            let delayed = signal.delayed(|_| tau);
            let worst =
                (100..3999).map(|row| (delayed[row] - (time[row] - tau).sin()).abs()).fold(0.0, f64::max);
            assert!(worst < 5e-4 * tau.min(0.05), "{tau}: {worst}");
        }
    }

    #[test]
    fn the_mean_of_a_sine_over_a_window() {
        // sin t · sin(w/2)/(w/2); a constant and a ramp keep their value.
        let time: Vec<f64> = (0..2000).map(|row| f64::from(row) * 0.05).collect();
        let x: Vec<f64> = time.iter().map(|t| 5e4 + t.sin()).collect();
        let signal = Signal::new(&time, x);
        for width in [0.01f64, 0.05, 0.77] {
            let gain = (width / 2.0).sin() / (width / 2.0);
            for (row, mean) in signal.averaged(width).iter().enumerate().take(1900).skip(100) {
                assert!((mean - 5e4 - gain * time[row].sin()).abs() < 1e-6, "{width}: {row}");
            }
        }
        let ramp = Signal::new(&time[..3], vec![1.0f64, 2.0, 3.0]);
        assert!((ramp.averaged(0.05)[1] - 2.0).abs() < 1e-12);
        // Half of the window lies before the first row, where the value is the first.
        assert!((ramp.averaged(0.1)[0] - 1.25).abs() < 1e-12);
    }

    #[test]
    fn a_gap_is_straight() {
        let time = [0.0, 1.0, 2.0, 100.0, 101.0];
        let x = [0.0, 1.0, 2.0, 2.0, 3.0];
        let signal = Signal::new(&time, x.to_vec());
        assert_eq!(signal.delayed(|row| if row == 3 { 49.0 } else { 0.0 })[3], 2.0);
    }

    #[test]
    fn moments_of_both_branches_agree_and_carry_their_derivative() {
        let (low, high): ([f64; 4], [f64; 4]) = (moments(1.0 - 1e-12), moments(1.0 + 1e-12));
        assert!(low.iter().zip(&high).all(|(a, b)| (a - b).abs() < 1e-11));
        for u in [1e-9, 0.3, 2.0, 500.0] {
            let dual = moments(Dual64::new(u, 1.0));
            let (ahead, behind) = (moments(u * (1.0 + 1e-6)), moments(u * (1.0 - 1e-6)));
            for k in 0..4 {
                let numeric = (ahead[k] - behind[k]) / (2e-6 * u);
                assert!((dual[k].eps - numeric).abs() < 1e-5 * dual[k].eps.abs().max(1e-3), "{u} {k}");
            }
        }
    }
}
