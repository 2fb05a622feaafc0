use common::OctaveAgreement;
use estimate::exact::Sum;

use super::moments::Level;
use crate::octave::{Octave, UNKNOWNS};

/// Fewer differences than these do not tell η.
const LEAST: u64 = 8;

/// Places of a block, 2^L.
pub fn length(level: usize) -> f64 {
    2.0_f64.powi(level as i32)
}

/// Of a level, for a test axis with a provisional η₀ and drift b₀ (nT a place): the columns are (r_x, r_y, r_z, 0,
/// T − R η₀ − b₀ place), as a drift is told by what is slower. With sums that keep their rounding, because T and
/// R η₀ are nearly the same.
pub fn differences(level: &Level, axis: usize, provisional: [f64; 3], drift: f64) -> Octave {
    let known = [(1, provisional[0]), (2, provisional[1]), (3, provisional[2]), (0, drift)];
    let test = 4 + axis;
    let rest = |channel: usize| -> Sum {
        let mut sum = level.product(channel, test);
        known.iter().for_each(|(other, factor)| sum.add_times(-factor, level.product(channel, *other)));
        sum
    };
    let mut square = rest(test);
    known.iter().for_each(|(other, factor)| square.add_times(-factor, rest(*other)));
    let product = |i: usize, j: usize| match (i, j) {
        (UNKNOWNS, UNKNOWNS) => square.value(),
        (i, j) if i.max(j) < 3 => level.product(i + 1, j + 1).value(),
        (i, j) if i.max(j) == UNKNOWNS && i.min(j) < 3 => rest(i.min(j) + 1).value(),
        _ => 0.0,
    };
    let products = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
    Octave { count: level.count as f64, products }
}

/// How the instruments agree in an octave alone: η, its standard uncertainty (Student's t with three degrees of
/// freedom fewer than differences) and the coherence R². No η of fewer than eight differences.
pub fn agreement(
    octave: &Octave,
    level: &Level,
    averaging_s: f64,
    axis: usize,
    provisional: [f64; 3],
) -> OctaveAgreement {
    let known = OctaveAgreement { averaging_s, differences: level.count, ..OctaveAgreement::default() };
    let Some((eta, inverse, squares)) = octave.alone().filter(|_| level.count >= LEAST) else {
        return known;
    };
    let variance = squares / (octave.count - 3.0);
    let whole = level.product(4 + axis, 4 + axis).value();
    OctaveAgreement {
        matrix: Some(std::array::from_fn(|i| provisional[i] + eta[i])),
        std: Some(std::array::from_fn(|i| (variance * inverse[(i, i)]).sqrt())),
        coherence: Some(1.0 - squares / whole),
        ..known
    }
}
