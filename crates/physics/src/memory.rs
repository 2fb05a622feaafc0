//! State equations of effects with memory, over the recording's own times, whatever the steps.
//!
//! Between its samples a signal is the cubic through them whose slopes are the central differences (those of
//! `numpy.gradient`), with two exceptions. A step more than four times as long as a neighbour is a gap: there
//! the line is straight. Where the drive is held at both ends of a step it jumps in the middle, so that nothing
//! answers to a jump before it comes, and what is a little late misses none. Beyond its ends a signal goes on
//! straight for one step and is constant from there.
//!
//! All of this is linear in the signal: which steps are gaps and where the drive is held depends on what was
//! set alone.

use nalgebra::Vector3;

use crate::Real;

/// A step longer than this many times a neighbouring one is a gap.
const GAP: f64 = 4.0;
/// A step whose slope is less than this share of a neighbour's is flat.
const FLAT: f64 = 0.02;
/// Two lags whose ratio is nearer to one than this are taken as so far apart.
const APART: f64 = 1e-4;
/// Steps that differ by less than this share are one.
const SAME_STEP: f64 = 1e-9;

/// A signal between its samples.
pub struct Signal<'a, T> {
    time_s: &'a [f64],
    x: Vec<T>,
    held: &'a [bool],
}

/// What a lag was before the first row.
#[derive(Clone, Copy, Debug)]
pub enum Before<T> {
    /// In equilibrium with the first sample.
    Equilibrium,
    /// Following a signal that moved as it does in the first step.
    Moving,
    /// At a value.
    At(T),
}

/// One step of a signal: x(s) = a + b s + c s² + d s³ for s = 0..1 over `step_s` seconds, and a jump in the middle.
struct Cubic<T> {
    step_s: f64,
    powers: [T; 4],
    jump: T,
}

impl<'a, T: Real> Signal<'a, T> {
    /// The samples x at times that do not run backwards; missing ones (NaN) are bridged straight.
    pub fn new(time_s: &'a [f64], x: Vec<T>) -> Self {
        Self { time_s, x: bridged(time_s, x), held: &[] }
    }

    /// One component of a field.
    pub fn of(time_s: &'a [f64], field: &[Vector3<T>], component: usize) -> Self {
        Self::new(time_s, field.iter().map(|field| field[component]).collect())
    }

    /// The same with slopes of zero in the rows where the drive is held, and jumps between them; see [`held`].
    pub fn holding(self, held: &'a [bool]) -> Self {
        Self { held, ..self }
    }

    fn step_s(&self, row: usize) -> f64 {
        self.time_s[row + 1] - self.time_s[row]
    }

    /// Central difference, one-sided at ends and beside a step of no length; zero where it is held.
    fn slope(&self, row: usize) -> T {
        if self.held.get(row) == Some(&true) {
            return T::from(0.0);
        }
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
        let (from, rise, none) = (self.x[row], self.x[row + 1] - self.x[row], T::from(0.0));
        if self.held.get(row..=row + 1) == Some(&[true, true]) {
            return Cubic { step_s, powers: [from, none, none, none], jump: rise };
        }
        if self.is_gap(row) {
            return Cubic { step_s, powers: [from, rise, none, none], jump: none };
        }
        let (start, end) = (self.slope(row) * step_s, self.slope(row + 1) * step_s);
        let powers = [from, start, rise * 3.0 - start * 2.0 - end, start + end - rise * 2.0];
        Cubic { step_s, powers, jump: none }
    }

    fn is_gap(&self, row: usize) -> bool {
        let longer = |other: usize| self.step_s(row) > GAP * self.step_s(other) && self.step_s(other) > 0.0;
        (row > 0 && longer(row - 1)) || (row + 2 < self.time_s.len() && longer(row + 1))
    }

    /// First-order lag τ y' = x − y, exact for the signal.
    ///
    /// Over a step h with u = h/τ: y₊ = y e^(−u) + Σ p_k w_k(u) + jump (1 − e^(−u/2)), w_k = u ∫₀¹ e^(−u(1−s)) s^k ds.
    pub fn lagged(&self, tau_s: T, before: Before<T>) -> Vec<T> {
        let Some(first) = self.x.first() else { return Vec::new() };
        let mut y = match before {
            Before::Equilibrium => *first,
            Before::At(value) => value,
            // A straight line for one step before the first row, constant before that.
            Before::Moving if self.x.len() > 1 && self.step_s(0) > 0.0 && !self.is_gap(0) => {
                let left = (-tau_s.recip() * self.step_s(0)).exp();
                *first - self.slope(0) * tau_s * (-left + 1.0)
            }
            Before::Moving => *first,
        };
        let mut lagged = Vec::with_capacity(self.x.len());
        lagged.push(y);
        let (mut known, mut half, mut weights) = (f64::NAN, T::from(0.0), [T::from(0.0); 4]);
        for row in 0..self.x.len() - 1 {
            let cubic = self.cubic(row);
            if cubic.step_s > 0.0 {
                // Times are rounded: a step that differs by less than that is the same.
                if (cubic.step_s - known).abs() > SAME_STEP * known || known.is_nan() {
                    known = cubic.step_s;
                    let steps = tau_s.recip() * known;
                    half = (-steps / 2.0).exp();
                    weights = moments(steps);
                }
                y = y * half * half + cubic.jump * (-half + 1.0);
                for (power, weight) in cubic.powers.iter().zip(&weights) {
                    y += *power * *weight;
                }
            }
            lagged.push(y);
        }
        lagged
    }

    /// Two lags one after the other, τ and r τ: (1 + τ d/dt)(1 + r τ d/dt) y = x, from following the signal. It is the
    /// sum of both relaxations, (L_τ − r L_rτ)/(1 − r); one lag where r = 0.
    pub fn lagged_twice(&self, tau_s: T, ratio: T) -> Vec<T> {
        let mut y = self.lagged(tau_s, Before::Moving);
        if ratio.re() > 0.0 {
            let ratio = if (ratio.re() - 1.0).abs() < APART { T::from(1.0 - APART) } else { ratio };
            for (y, second) in y.iter_mut().zip(self.lagged(tau_s * ratio, Before::Moving)) {
                *y = (*y - second * ratio) / (-ratio + 1.0);
            }
        }
        y
    }

    /// The signal at times t − delay(row).
    pub fn delayed(&self, delay_s: impl Fn(usize) -> T) -> Vec<T> {
        let mut row = 0;
        (0..self.x.len())
            .map(|at| {
                let when = -delay_s(at) + self.time_s[at];
                self.at(when, &mut row)
            })
            .collect()
    }

    /// The value at a time; `row` is where the search begins and where it ended.
    fn at(&self, when: T, row: &mut usize) -> T {
        let last = self.x.len() - 1;
        let t = when.re();
        // Beyond the ends: straight for one step, then constant.
        if last == 0 || t <= self.time_s[0] {
            let reach = if last > 0 && !self.is_gap(0) { self.step_s(0) } else { 0.0 };
            let away = if t < self.time_s[0] - reach { T::from(-reach) } else { when - self.time_s[0] };
            return if reach > 0.0 { self.x[0] + self.slope(0) * away } else { self.x[0] };
        }
        if t >= self.time_s[last] {
            let reach = if self.is_gap(last - 1) { 0.0 } else { self.step_s(last - 1) };
            let away = if t > self.time_s[last] + reach { T::from(reach) } else { when - self.time_s[last] };
            return if reach > 0.0 { self.x[last] + self.slope(last) * away } else { self.x[last] };
        }
        while *row > 0 && self.time_s[*row] > t {
            *row -= 1;
        }
        while *row + 1 < last && self.time_s[*row + 1] <= t {
            *row += 1;
        }
        let Cubic { step_s, powers: [a, b, c, d], jump } = self.cubic(*row);
        let s = (when - self.time_s[*row]) / step_s;
        let smooth = a + s * (b + s * (c + s * d));
        if s.re() < 0.5 { smooth } else { smooth + jump }
    }
}

impl Signal<'_, f64> {
    /// ∫ x dt from the first row to each, exact for the signal.
    pub fn integral(&self) -> Vec<f64> {
        let mut sum = 0.0;
        let steps = (1..self.x.len()).map(|row| {
            let Cubic { step_s, powers: [a, b, c, d], jump } = self.cubic(row - 1);
            sum += step_s * (a + b / 2.0 + c / 3.0 + d / 4.0 + jump / 2.0);
            sum
        });
        std::iter::once(0.0).take(self.x.len()).chain(steps).collect()
    }
}

/// w_k(u) = u ∫₀¹ e^(−u(1−s)) s^k ds for k = 0..3; w_k = 1 − k w_(k−1)/u, backwards from a series where u is
/// small.
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

/// The rows near a jump in which every series of a drive is held on one side at least: the step there is
/// [`FLAT`] times less steep than one beside it. A crest is not held. Empty where no row is.
pub fn held<const N: usize>(time_s: &[f64], drive: &[[f64; N]]) -> Vec<bool> {
    let rate = |step: usize, k: usize| match time_s[step + 1] - time_s[step] {
        length if length > 0.0 => (drive[step + 1][k] - drive[step][k]) / length,
        _ => 0.0,
    };
    let steps = drive.len().min(time_s.len()).saturating_sub(1);
    let flat = |step: usize, k: usize| {
        let before = if step > 0 { rate(step - 1, k) } else { 0.0 };
        let after = if step + 1 < steps { rate(step + 1, k) } else { 0.0 };
        rate(step, k).abs() <= FLAT * before.abs().max(after.abs()) && before * after >= 0.0
    };
    let is_held = |row: usize| {
        let beside = row.saturating_sub(1)..(row + 1).min(steps);
        let beside = beside.filter(|step| time_s[step + 1] > time_s[*step]);
        let holds = |k: usize| beside.clone().any(|step| flat(step, k));
        let mut near = row.saturating_sub(2)..(row + 2).min(steps);
        (0..N).all(holds) && near.any(|step| (0..N).any(|k| rate(step, k) != 0.0))
    };
    let rows: Vec<bool> = (0..drive.len()).map(is_held).collect();
    if rows.contains(&true) { rows } else { Vec::new() }
}

/// x with straight lines for missing samples, constant at the ends; zero if all are missing.
pub fn bridged<T: Real>(time_s: &[f64], mut x: Vec<T>) -> Vec<T> {
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
        for (t, y) in time.iter().zip(Signal::new(&time, ramp.clone()).lagged(tau, Before::Equilibrium)) {
            assert!((y - 2.0 * (t - tau * (1.0 - (-t / tau).exp()))).abs() < 1e-12);
        }
        // Having moved like that for one step before: the ramp began at −0.1 s.
        for (t, y) in time.iter().zip(Signal::new(&time, ramp).lagged(tau, Before::Moving)) {
            let began = t + 0.1;
            assert!((y + 0.2 - 2.0 * (began - tau * (1.0 - (-began / tau).exp()))).abs() < 1e-12);
        }
        // A constant 5 from 0: 5 (1 − e^(−t/τ)); the missing sample changes nothing.
        let level = [5.0, 5.0, f64::NAN, 5.0, 5.0, 5.0, 5.0];
        for (t, y) in time.iter().zip(Signal::new(&time, level.to_vec()).lagged(tau, Before::At(0.0))) {
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
            let lagged = signal.lagged(tau, Before::Moving);
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
    fn two_lags_by_hand() {
        // Of a ramp of 1 unit/s from equilibrium: t − (a + b) + (a² e^(−t/a) − b² e^(−t/b))/(a − b).
        let time: Vec<f64> = (0..50).map(|row| f64::from(row) * 0.3).collect();
        let ramp = Signal { time_s: &time, x: time.clone(), held: &[] };
        let (a, b) = (3.0_f64, 1.2_f64);
        let began = |t: f64| t + 0.3;
        for (t, y) in time.iter().zip(ramp.lagged_twice(a, b / a)) {
            let s = began(*t);
            let left = (a * a * (-s / a).exp() - b * b * (-s / b).exp()) / (a - b);
            assert!((y + 0.3 - (s - (a + b) + left)).abs() < 1e-12, "{t}");
        }
        let [near, equal] = [0.999, 1.0].map(|ratio| ramp.lagged_twice(a, ratio)[40]);
        assert!((near - equal).abs() < 1e-2, "{near} {equal}");
    }

    #[test]
    fn nothing_answers_to_a_jump_before_it_comes() {
        let time: Vec<f64> = (0..8).map(f64::from).collect();
        let drive = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let mask = held(&time, &drive.map(|x| [x]));
        assert_eq!(mask, [false, true, true, true, true, false, false, false]);
        // One drive after the other.
        let turns: Vec<[f64; 2]> = (0..8).map(|row| [drive[row], if row > 3 { 2.0 } else { 0.0 }]).collect();
        assert!((2..5).all(|row| held(&time, &turns)[row]));
        let signal = Signal::new(&time, drive.to_vec()).holding(&mask);
        let lagged: Vec<f64> = signal.lagged(0.1, Before::Moving);
        assert!(lagged[..3].iter().all(|y| *y == 0.0) && (lagged[4] - 1.0).abs() < 1e-3, "{lagged:?}");
        let delayed = signal.delayed(|_| 0.2);
        assert_eq!(delayed[2..5], [0.0, 1.0, 1.0]);
        // What lags misses e^(−h/2τ) of the jump in the middle of the step.
        let missed = 1.0 - signal.lagged(1.0, Before::Moving)[3];
        assert!((missed - (-0.5_f64).exp()).abs() < 1e-12, "{missed}");
        // A crest between two equal samples is no plateau, nor is a drive beside which another one moves.
        let crest: Vec<[f64; 1]> = time.iter().map(|t| [-(t - 3.5) * (t - 3.5)]).collect();
        assert!(held(&time, &crest).is_empty());
        let both: Vec<[f64; 2]> = drive.iter().zip(&time).map(|(x, t)| [*x, 0.1 * t]).collect();
        assert!(held(&time, &both).is_empty());
    }

    #[test]
    fn beyond_the_ends_it_is_straight_for_one_step() {
        let time = [0.0, 1.0, 2.0];
        let signal = Signal::new(&time, vec![0.0, 1.0, 2.0]);
        let shifted = |delay: f64| signal.delayed(|_| delay);
        assert_eq!(shifted(0.5), [-0.5, 0.5, 1.5]);
        assert_eq!(shifted(5.0), [-1.0, -1.0, -1.0]);
        assert_eq!(shifted(-9.0), [3.0, 3.0, 3.0]);
        assert!(Signal::<f64>::new(&[], Vec::new()).delayed(|_| 1.0).is_empty());
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
