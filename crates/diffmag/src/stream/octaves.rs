use common::OctaveAgreement;
use estimate::exact::Sum;
use estimate::positive::Positive;
use estimate::stats;
use faer::Mat;
use serde::Serialize;

use super::moments::Level;

/// The reference's x, y, z, the place, and what is to be explained.
pub const COLUMNS: usize = 5;
pub const UNKNOWNS: usize = COLUMNS - 1;
/// Fewer differences than these do not tell η.
const LEAST: u64 = 8;
const PROBABILITY: f64 = 0.95;

/// The differences of one octave as one axis of the test instrument has them.
pub struct Differences {
    /// Places of a block, 2^L.
    pub length: f64,
    pub count: f64,
    /// Σ z zᵀ of the columns z = (r_x, r_y, r_z, 0, T − R η₀ − b₀ place): a drift is told by what is slower.
    pub products: [[f64; COLUMNS]; COLUMNS],
}

impl Differences {
    /// Of a level, for a test axis with a provisional η₀ and drift b₀ (nT a place); with sums that keep their
    /// rounding, because T and R η₀ are nearly the same.
    pub fn of(number: usize, level: &Level, axis: usize, provisional: [f64; 3], drift: f64) -> Self {
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
        Self { length: 2.0_f64.powi(number as i32), count: level.count as f64, products }
    }

    /// Σ of the squares that coefficients leave.
    pub fn squares(&self, coefficients: &[f64]) -> f64 {
        let rest = |i: usize| if i == UNKNOWNS { 1.0 } else { -coefficients[i] };
        let mut sum = 0.0;
        for i in 0..COLUMNS {
            for j in 0..COLUMNS {
                sum += rest(i) * rest(j) * self.products[i][j];
            }
        }
        sum
    }
}

/// One axis of the test instrument at one octave: blocks of 2^L samples and their successors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Octave {
    /// η of this octave alone; none with fewer than eight differences.
    pub agreement: OctaveAgreement,
    /// Allan deviation of d less its drift, by blocks that do not overlap, nT.
    pub allan_nt: f64,
    /// 95 % interval of the Allan deviation, the differences taken as independent, nT.
    pub allan_interval_nt: [f64; 2],
}

impl Octave {
    /// Of a level's differences.
    pub fn of(differences: &Differences, level: &Level, step_s: f64, fit: &OctaveFit<'_>) -> Self {
        let allan = differences.squares(fit.coefficients) / (2.0 * differences.count);
        let (low, high) = stats::variance_interval((differences.count - fit.taken).max(0.5), PROBABILITY);
        let alone = (level.count >= LEAST).then(|| alone(differences, level, fit)).flatten();
        Octave {
            agreement: OctaveAgreement {
                averaging_s: differences.length * step_s,
                differences: level.count,
                ..alone.unwrap_or_default()
            },
            allan_nt: allan.sqrt(),
            allan_interval_nt: [(allan * low).sqrt(), (allan * high).sqrt()],
        }
    }
}

/// The fit of all octaves, as one of them sees it.
pub struct OctaveFit<'a> {
    /// Corrections of η₀, and the drift (nT a place).
    pub coefficients: &'a [f64],
    /// η₀.
    pub provisional: [f64; 3],
    pub axis: usize,
    /// Degrees of freedom that the fit took from this octave.
    pub taken: f64,
}

/// η of an octave, its standard uncertainty (Student's t with three degrees of freedom fewer than differences)
/// and the coherence R².
fn alone(differences: &Differences, level: &Level, fit: &OctaveFit<'_>) -> Option<OctaveAgreement> {
    let products = &differences.products;
    let inverse = Positive::of(&Mat::from_fn(3, 3, |i, j| products[i][j])).ok()?.inverse;
    let right: [f64; 3] = std::array::from_fn(|i| products[i][UNKNOWNS]);
    let correction: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| inverse[(i, j)] * right[j]).sum());
    let [x, y, z] = correction;
    let squares = differences.squares(&[x, y, z, 0.0]);
    let variance = squares / (differences.count - 3.0);
    let whole = level.product(4 + fit.axis, 4 + fit.axis).value();
    Some(OctaveAgreement {
        matrix: Some(std::array::from_fn(|i| fit.provisional[i] + correction[i])),
        std: Some(std::array::from_fn(|i| (variance * inverse[(i, i)]).sqrt())),
        coherence: Some(1.0 - squares / whole),
        ..OctaveAgreement::default()
    })
}
