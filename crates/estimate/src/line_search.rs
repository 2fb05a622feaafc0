//! Searches along a line: how far to go along a step, where a function is largest, where one is zero.

/// What the first of the shares 1, ½, ¼, … of a step, `most` of them, leads to that is taken; None where none
/// is.
pub fn halved<T>(most: i32, mut taken: impl FnMut(f64) -> Option<T>) -> Option<T> {
    (0..most).find_map(|halvings| taken(0.5_f64.powi(halvings)))
}

/// Most steps of a climb, and most halvings of one.
const STEPS: usize = 30;
const HALVINGS: i32 = 12;
/// The longest step of a climb.
const LONGEST: f64 = 1.0;

/// Climbs from a place within limits until a step moves it by less than an accuracy. `step`, to the maximum
/// of a parabola, is cut to one and halved until `above` finds a place better than where it began.
pub fn climb<T>(
    start: (f64, T),
    (low, high): (f64, f64),
    accuracy: f64,
    step: impl Fn(&(f64, T)) -> Option<f64>,
    above: impl Fn(&(f64, T), f64) -> Option<T>,
) -> (f64, T) {
    let mut at = start;
    for _ in 0..STEPS {
        let place = at.0;
        let Some(step) = step(&at).map(|step| step.clamp(-LONGEST, LONGEST)) else { break };
        let next = halved(HALVINGS, |share| {
            let next = (place + share * step).clamp(low, high);
            Some((next, above(&at, next)?))
        });
        let Some(next) = next else { break };
        at = next;
        if (at.0 - place).abs() < accuracy {
            break;
        }
    }
    at
}

/// (√5 − 1)/2.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// The argument between two at which a function with one maximum is largest, by golden sections, each 0.618
/// of the one before (J. Kiefer, Proc. Am. Math. Soc. 4 (1953) 502).
pub fn largest((mut low, mut high): (f64, f64), sections: usize, mut value: impl FnMut(f64) -> f64) -> f64 {
    let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_left, mut at_right) = (value(left), value(right));
    for _ in 0..sections {
        if at_left > at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = value(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = value(right);
        }
    }
    0.5 * (low + high)
}

/// How well a zero is to be known: by its argument, as a share of that, or by its value.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// Share of the argument.
    pub relative: f64,
    /// Value.
    pub value: f64,
}

/// Most steps to a zero.
const MOST: usize = 200;

/// The zero of a rising function between two arguments, given with their values: the secant of the ends, an
/// end that stays twice counting half (the Illinois method: M. Dowell and P. Jarratt, BIT 11 (1971) 168).
///
/// Errors: those of the function.
pub fn zero<E>(
    (mut low, mut below): (f64, f64),
    (mut high, mut above): (f64, f64),
    accuracy: Accuracy,
    mut value: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let (mut at, mut stayed) = (high, 0);
    for _ in 0..MOST {
        if high - low <= accuracy.relative * high.abs() {
            break;
        }
        at = (low * above - high * below) / (above - below);
        let found = value(at)?;
        if found.abs() <= accuracy.value {
            break;
        }
        if found > 0.0 {
            (high, above) = (at, found);
            below *= if stayed > 0 { 0.5 } else { 1.0 };
            stayed = 1;
        } else {
            (low, below) = (at, found);
            above *= if stayed < 0 { 0.5 } else { 1.0 };
            stayed = -1;
        }
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn the_first_share_that_is_taken() {
        assert_eq!(halved(12, |share| (share < 0.3).then_some(share)), Some(0.25));
        assert_eq!(halved(2, |share| (share < 0.3).then_some(share)), None);
    }

    #[test]
    fn a_climb_ends_at_the_maximum_or_at_its_limit() {
        // −ln cosh: whole steps from beyond 1.09 overshoot ever farther.
        let value = |x: f64| -x.cosh().ln();
        let step = |(x, _): &(f64, f64)| Some(-x.tanh() * x.cosh().powi(2));
        let above = |(_, reached): &(f64, f64), x: f64| (value(x) > *reached).then_some(value(x));
        let (at, _) = climb((2.5, value(2.5)), (-9.0, 9.0), 1e-9, step, above);
        assert!(at.abs() < 1e-7, "{at}");
        assert_eq!(climb((2.5, value(2.5)), (0.5, 9.0), 1e-9, step, above).0, 0.5);
    }

    #[test]
    fn the_largest_value_and_the_zero_of_known_functions() {
        let at = largest((0.0, 3.0), 40, f64::sin);
        assert!((at - std::f64::consts::FRAC_PI_2).abs() < 1e-7, "{at}");
        let accuracy = Accuracy { relative: 1e-15, value: 0.0 };
        let mut calls = 0;
        let cubic = |x: f64| {
            calls += 1;
            Ok::<_, Infallible>(x * x * x - 2.0)
        };
        let Ok(root) = zero((0.0, -2.0), (8.0, 510.0), accuracy, cubic);
        assert!((root - 2.0_f64.cbrt()).abs() < 1e-14 && calls < 30, "{root} after {calls}");
    }
}
