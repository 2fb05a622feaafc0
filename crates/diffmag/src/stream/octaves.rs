use estimate::exact::Sum;
use estimate::positive::Positive;
use estimate::stats;
use faer::Mat;
use serde::Serialize;

use super::moments::Level;

/// The reference's x, y, z, the place, and what is to be explained.
pub const COLUMNS: usize = 5;
/// Unknowns of an axis.
pub const UNKNOWNS: usize = COLUMNS - 1;
/// Fewer differences than these do not tell η.
const LEAST: u64 = 8;
const PROBABILITY: f64 = 0.95;

/// The differences of one octave as one axis of the test instrument has them.
pub struct Differences {
    /// Places of a block, 2^L.
    pub length: f64,
    /// Differences.
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
    /// Averaging time 2^L Δt, s.
    pub averaging_s: f64,
    /// Differences of neighbouring blocks.
    pub differences: u64,
    /// Pairs of which a block has less than three quarters of its samples.
    pub broken: u64,
    /// Allan deviation of d less its drift, by blocks that do not overlap, nT.
    pub allan_nt: f64,
    /// 95 % interval of the Allan deviation, the differences taken as independent, nT.
    pub allan_interval_nt: [f64; 2],
    /// The same of the noise that was fitted, nT.
    pub fitted_nt: f64,
    /// η of this octave alone; none with fewer than eight differences.
    pub eta: Option<[f64; 3]>,
    /// Its standard uncertainty, the differences taken as independent: Student's t with `differences` − 3.
    pub eta_std: Option<[f64; 3]>,
    /// Share of the square of T's differences that R explains here, R².
    pub coherence: Option<f64>,
}

impl Octave {
    /// Of a level's differences with the fitted variance of a difference there and the degrees of freedom
    /// that the fit took.
    pub fn of(differences: &Differences, level: &Level, step_s: f64, fit: &OctaveFit<'_>) -> Self {
        let variance = |sum: f64| sum / (2.0 * differences.count);
        let squares = differences.squares(fit.coefficients);
        let allan = variance(squares);
        let (low, high) = stats::variance_interval((differences.count - fit.taken).max(0.5), PROBABILITY);
        let alone = (level.count >= LEAST).then(|| alone(differences, level, fit)).flatten();
        Octave {
            averaging_s: differences.length * step_s,
            differences: level.count,
            broken: level.broken,
            allan_nt: allan.sqrt(),
            allan_interval_nt: [(allan * low).sqrt(), (allan * high).sqrt()],
            fitted_nt: (0.5 * fit.variance).sqrt(),
            eta: alone.map(|(eta, _, _)| eta),
            eta_std: alone.map(|(_, std, _)| std),
            coherence: alone.map(|(_, _, coherence)| coherence),
        }
    }
}

/// The fit of all octaves, as one of them sees it.
pub struct OctaveFit<'a> {
    /// Corrections of η₀, and the drift (nT a place).
    pub coefficients: &'a [f64],
    /// η₀.
    pub provisional: [f64; 3],
    /// The test's axis.
    pub axis: usize,
    /// Fitted variance of a difference.
    pub variance: f64,
    /// Degrees of freedom that the fit took from this octave.
    pub taken: f64,
}

/// η of an octave, its standard uncertainty and the coherence.
fn alone(differences: &Differences, level: &Level, fit: &OctaveFit<'_>) -> Option<([f64; 3], [f64; 3], f64)> {
    let products = &differences.products;
    let inverse = Positive::of(&Mat::from_fn(3, 3, |i, j| products[i][j])).ok()?.inverse;
    let right: [f64; 3] = std::array::from_fn(|i| products[i][UNKNOWNS]);
    let correction: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| inverse[(i, j)] * right[j]).sum());
    let [x, y, z] = correction;
    let squares = differences.squares(&[x, y, z, 0.0]);
    let variance = squares / (differences.count - 3.0);
    let whole = level.product(4 + fit.axis, 4 + fit.axis).value();
    Some((
        std::array::from_fn(|i| fit.provisional[i] + correction[i]),
        std::array::from_fn(|i| (variance * inverse[(i, i)]).sqrt()),
        1.0 - squares / whole,
    ))
}
