//! Spectral lines of a periodogram: found, fitted by sines, subtracted.

use fourier::Complex;

use super::component::Component;
use super::level::Level;
use crate::stats::chi_squared_p;

/// Nominal probability that a series of noise has a line. By simulation it is 1.0 to 1.6 times as great, for
/// the scatter of the slope that is divided out: below 10⁻³.
const FALSE_LINE: f64 = 5e-4;
/// The lowest ordinate at which a line is sought: below there are too few neighbours.
const FIRST: usize = 7;
/// The neighbours of an ordinate with this share of what a line needs above the level are looked at.
const WORTH_A_LOOK: f64 = 0.6;
/// Ordinates on each side of a line that are left out: a sine is fitted to them.
const TAKEN: f64 = 2.0;
/// Lines so near to one another are fitted anew together (ordinates).
const TOGETHER: f64 = 50.0;
/// Most sines that are subtracted.
const MOST: usize = 200;
/// Most searches over the whole series.
const SEARCHES: usize = 10;
/// What a wandering line leaves beside it is within this share of its frequency.
const WANDERING: f64 = 0.02;
/// Ordinates beside a line are left out as long as noise alone is so high with this probability.
const CONTAMINATED: f64 = 1e-3;
/// Share of its frequency over which a line is followed at most.
const WIDEST: f64 = 0.1;

/// A sine in the series.
///
/// Sought from the seventh ordinate on, at the full resolution: an ordinate over the median of its neighbours
/// (a fifth of its number on either side, 24 to 200) that noise reaches in less than one of a thousand
/// series. A sine of least squares is fitted to the ordinates up to eight away and subtracted with all that
/// leaks from it, and the search repeated. The two ordinates on either side of each sine are left out, and
/// beyond them what is too high for noise.
///
/// A line that is no steady sine leaves weaker ones beside it: within 2 % of its frequency what is d
/// ordinates away and weaker than 1/d of it is not listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Frequency (Hz).
    pub frequency_hz: f64,
    /// Amplitude, half of peak to peak (unit of the samples).
    pub amplitude: f64,
    /// Probability that any ordinate of a series of noise stands out as much.
    pub p_value: f64,
}

/// Takes the lines out of a transform X_k, k < n/2; returns them, and which ordinates belong to one.
pub(super) fn take_out(transform: &mut [Complex<f64>], n: usize, length_s: f64) -> (Vec<Line>, Vec<bool>) {
    let mut power: Vec<f64> = transform.iter().map(Complex::norm_sqr).collect();
    let mut left_out = vec![false; power.len()];
    left_out[0] = true;
    let sought = power.len().saturating_sub(FIRST) as f64;
    let factor = WORTH_A_LOOK * (sought.max(1.0) / FALSE_LINE).ln();
    let mut found: Vec<(Component, f64)> = Vec::new();
    let mut level = Level::of(&power, &left_out);
    for _ in 0..SEARCHES {
        let before = found.len();
        for k in level.above(&power, &left_out, FIRST, factor) {
            // What leaked from a stronger line is gone by now.
            let p = any_of(sought, level.ln_p(&power, &left_out, k));
            if p < FALSE_LINE && found.len() < MOST {
                let component = Component::fit(transform, &level, n, k);
                component.subtract(transform, &mut power, &level, n);
                found.push((component, p));
            }
        }
        if found.len() == before {
            break;
        }
        fit_together(&mut found, transform, &mut power, &level, n);
        for (component, _) in &found {
            leave_out(&mut left_out, component.order - TAKEN, component.order + TAKEN);
        }
        level = Level::of(&power, &left_out);
    }
    let mut lines: Vec<(Component, f64)> = Vec::new();
    found.sort_by(|a, b| b.0.amplitude().total_cmp(&a.0.amplitude()));
    for (component, p) in found {
        let (low, high) = contaminated(component.order, &power, &left_out, &level);
        leave_out(&mut left_out, low, high);
        if !lines.iter().any(|(stronger, _)| is_part(&component, stronger)) {
            lines.push((component, p));
        }
    }
    lines.sort_by(|a, b| a.0.order.total_cmp(&b.0.order));
    let line = |(component, p_value): &(Component, f64)| Line {
        frequency_hz: component.order / length_s,
        amplitude: component.amplitude(),
        p_value: *p_value,
    };
    (lines.iter().map(line).collect(), left_out)
}

/// Whether a sine may be what a stronger line, whose frequency or amplitude is not steady, leaves beside it.
fn is_part(component: &Component, stronger: &Component) -> bool {
    let distance = (component.order - stronger.order).abs();
    let within = distance <= (WANDERING * stronger.order).max(TAKEN);
    within && component.amplitude() * distance <= stronger.amplitude()
}

/// Probability that any of `count` ordinates has the probability of a single one.
fn any_of(count: f64, ln_single: f64) -> f64 {
    (-(count * (-ln_single.exp()).ln_1p()).exp_m1()).max(f64::MIN_POSITIVE)
}

/// Fits sines that are near to others once more, without these.
fn fit_together(
    found: &mut [(Component, f64)],
    transform: &mut [Complex<f64>],
    power: &mut [f64],
    level: &Level,
    n: usize,
) {
    for i in 0..found.len() {
        let component = found[i].0;
        let near = |other: &(Component, f64)| (other.0.order - component.order).abs() < TOGETHER;
        if found.iter().filter(|other| near(other)).count() > 1 {
            let added = Component { half: -component.half, ..component };
            added.subtract(transform, power, level, n);
            let peak = (component.order.round() as usize).clamp(1, power.len() - 1);
            found[i].0 = Component::fit(transform, level, n, peak);
            found[i].0.subtract(transform, power, level, n);
        }
    }
}

/// Marks the ordinates from `low` to `high`.
fn leave_out(left_out: &mut [bool], low: f64, high: f64) {
    let (low, end) = (low.ceil().max(1.0) as usize, (high.floor() as usize + 1).min(left_out.len()));
    (low..end).for_each(|k| left_out[k] = true);
}

/// How far beside a line ordinates are too high for noise, in blocks that grow with the distance.
fn contaminated(order: f64, power: &[f64], left_out: &[bool], level: &Level) -> (f64, f64) {
    let widest = (WIDEST * order).max(TAKEN);
    let distance = |sign: f64| {
        let mut distance = TAKEN;
        while distance < widest {
            let next = (1.5 * distance + 2.0).min(widest);
            let (a, b) = (order + sign * distance, order + sign * next);
            let block = a.min(b).ceil().max(1.0) as usize..(a.max(b).floor() as usize + 1).min(power.len());
            let ratios = block.filter(|k| !left_out[*k]).map(|k| power[k] / level.at(k));
            let (count, sum) = ratios.fold((0.0, 0.0), |(count, sum), ratio| (count + 1.0, sum + ratio));
            if count > 0.0 && chi_squared_p(2.0 * sum, 2.0 * count) > CONTAMINATED {
                break;
            }
            distance = next;
        }
        distance
    };
    (order - distance(-1.0), order + distance(1.0))
}
