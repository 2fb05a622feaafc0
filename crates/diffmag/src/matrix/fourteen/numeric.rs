//! The source's route: the nonlinear equations by Gauss-Newton.

use estimate::{Options, Problem};
use faer::MatMut;
use nalgebra::{Matrix3, Vector3};
use num_dual::Dual64;
use physics::{Real, frames};

use super::error::{self, Error};
use super::known::{KnownAxes, KnownFive};
use super::pair::{Pair, axis, dot};
use super::parameters::{ANGLES, EtaCovariance};

/// β, five ratios, two turns of each of four axes.
const UNKNOWNS: usize = 14;

/// Nine equations η(pair) = η, each in units of the largest element of its column, and five that the pair has
/// what is known.
struct Equations<'a> {
    eta: &'a Matrix3<f64>,
    scales: [f64; 3],
    known: &'a KnownFive,
}

/// The fourteen parameters by Gauss-Newton on the nine equations of η and the five of what is known, in the
/// order of
/// [`super::NAMES`]: the source's way, and a check of [`super::solve`], with which it shares no formula.
///
/// It starts from the known values of a known reference, or else from a reference with axes along those of
/// the frame.
pub fn solve_numerically(eta: &Matrix3<f64>, known: &KnownFive) -> Result<[f64; 14], Error> {
    known.check()?;
    error::refuse_singular(eta, &EtaCovariance::zeros())?;
    let scales = std::array::from_fn(|j| eta.column(j).amax());
    let options = Options { tolerance: 1e-15, ..Options::default() };
    let start = nominal(eta, known);
    let fit = estimate::solve(&Equations { eta, scales, known }, start, None, &options)?;
    // Fourteen equations that cannot all hold leave a residual, those of a pair in a plane a short rank.
    if fit.svd.rank() < UNKNOWNS || fit.cost > 1e-20 {
        return Err(Error::NoAnswer);
    }
    let mut values = fit.state.parameters();
    if let KnownAxes::Reference([alpha, _, gamma]) = known.axes {
        let [azimuth, polar] = ANGLES[0];
        (values[azimuth], values[polar]) = (alpha, gamma);
    }
    Ok(values)
}

/// A pair to start from: the reference as it is known, or with axes along those of the frame; the test
/// instrument as η shows it beside a reference with orthogonal axes. With orthogonal axes on both sides K_ri
/// η_ij/K_tj is a rotation (or turns right into left): known ratios of one side give the other's from lengths
/// of rows or columns.
fn nominal(eta: &Matrix3<f64>, known: &KnownFive) -> Pair {
    let [x_y, z_y] = known.ratios;
    let factors = Vector3::new(x_y, 1.0, z_y);
    let (beta, z_r) = match known.axes {
        KnownAxes::Reference([alpha, beta, gamma]) => (beta, axis(alpha, gamma)),
        KnownAxes::ReferenceTilts([_, _, beta]) => (beta, Vector3::z()),
        KnownAxes::Test(_) => (0.0, Vector3::z()),
    };
    let reference = match known.axes {
        KnownAxes::Test(_) => {
            let lengths = Vector3::from_fn(|i, _| eta.row(i).transpose().component_div(&factors).norm());
            lengths.map(|length| lengths.y / length)
        }
        _ => factors,
    };
    let facing = Vector3::new(beta.cos().signum(), 1.0, z_r.z.signum());
    let columns: [Vector3<f64>; 3] =
        std::array::from_fn(|j| eta.column(j).component_mul(&reference).component_mul(&facing));
    let lengths = columns.map(|column| column.norm());
    let [x, y, z]: [Vector3<f64>; 3] = std::array::from_fn(|j| columns[j] / lengths[j]);
    Pair {
        beta,
        axes: [z_r, x, y, z],
        ratios: [
            lengths[0] / reference.x,
            reference.x,
            reference.z,
            lengths[0] / lengths[1],
            lengths[2] / lengths[1],
        ],
    }
}

/// The pair with one of its unknowns moved.
fn moved<T: Real>(pair: &Pair, step: &[T; UNKNOWNS]) -> Pair<T> {
    let [beta, a, b, c, d, e, turns @ ..] = step;
    let by = [a, b, c, d, e];
    Pair {
        beta: *beta + pair.beta,
        axes: std::array::from_fn(|k| frames::turned(&pair.axes[k], [turns[2 * k], turns[2 * k + 1]])),
        ratios: std::array::from_fn(|k| *by[k] + pair.ratios[k]),
    }
}

impl Equations<'_> {
    /// The left sides of the fourteen equations.
    fn left<T: Real>(&self, pair: &Pair<T>) -> [T; UNKNOWNS] {
        let eta = pair.eta();
        let [z, test @ ..] = &pair.axes;
        let own = match self.known.axes {
            KnownAxes::Reference(_) | KnownAxes::ReferenceTilts(_) => {
                [z[0], z[1], pair.beta, pair.ratios[1], pair.ratios[2]]
            }
            KnownAxes::Test(_) => {
                let [x, y, z] = test;
                [dot(x, y), dot(y, z), dot(x, z), pair.ratios[3], pair.ratios[4]]
            }
        };
        std::array::from_fn(|row| if row < 9 { eta[row] / self.scales[row / 3] } else { own[row - 9] })
    }

    /// Their right sides.
    fn right(&self) -> [f64; UNKNOWNS] {
        let [x_y, z_y] = self.known.ratios;
        let own = match self.known.axes {
            KnownAxes::Reference([alpha, beta, gamma]) => {
                let z = axis(alpha, gamma);
                [z.x, z.y, beta, x_y, z_y]
            }
            KnownAxes::ReferenceTilts([a, b, c]) | KnownAxes::Test([a, b, c]) => [a, b, c, x_y, z_y],
        };
        std::array::from_fn(|row| if row < 9 { self.eta[row] / self.scales[row / 3] } else { own[row - 9] })
    }
}

impl Problem for Equations<'_> {
    type State = Pair;

    fn unknowns(&self) -> usize {
        UNKNOWNS
    }

    fn rows(&self) -> usize {
        UNKNOWNS
    }

    fn linearise(&self, pair: &Pair, residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
        let (left, right) = (self.left(pair), self.right());
        (0..UNKNOWNS).for_each(|row| residual[row] = right[row] - left[row]);
        for unknown in 0..UNKNOWNS {
            let mut step = [Dual64::from(0.0); UNKNOWNS];
            step[unknown].eps = 1.0;
            for (row, left) in self.left(&moved(pair, &step)).iter().enumerate() {
                jacobian[(row, unknown)] = left.eps;
            }
        }
    }

    fn advance(&self, pair: &Pair, step: &[f64]) -> Pair {
        moved(pair, &std::array::from_fn(|unknown| step[unknown]))
    }
}
