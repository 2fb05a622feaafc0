//! The source's route: the nonlinear equations by Gauss-Newton.

use common::Magnetometer;
use estimate::{Options, Problem};
use faer::MatMut;
use nalgebra::{Matrix3, Vector3};
use num_dual::Dual64;
use physics::{Real, frames};

use super::known::KnownFive;
use super::pair::Pair;
use super::parameters::EtaCovariance;
use super::singular::{no_answer, refuse_singular};
use crate::Error;

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
/// order of [`super::NAMES`]: the source's way, and a check of [`super::solve`], with which it shares no
/// formula.
pub fn solve_numerically(eta: &Matrix3<f64>, known: &KnownFive) -> Result<[f64; 14], Error> {
    known.check()?;
    refuse_singular(eta, &EtaCovariance::zeros())?;
    let scales = std::array::from_fn(|j| eta.column(j).amax());
    let options = Options { tolerance: 1e-15, ..Options::default() };
    let equations = Equations { eta, scales, known };
    let fit = estimate::solve(&equations, nominal(eta, known), None, &options).map_err(|why| {
        Error::Unanswerable(format!("the iteration for the fourteen parameters failed: {why}"))
    })?;
    // Fourteen equations that cannot all hold leave a residual, those of a pair in a plane a short rank.
    if fit.svd.rank() < UNKNOWNS || fit.cost > 1e-20 {
        return Err(no_answer());
    }
    Ok(fit.state.parameters())
}

/// A pair to start from: a reference with z along that of the frame, and β and ratios as they are known; the
/// test instrument as η shows it beside such a reference. With orthogonal axes on both sides K_ri η_ij/K_tj is a
/// rotation (or turns right into left): known ratios of one side give the other's from lengths of rows or
/// columns.
fn nominal(eta: &Matrix3<f64>, known: &KnownFive) -> Pair {
    let [_, _, third, x_y, z_y] = known.values;
    let factors = Vector3::new(x_y, 1.0, z_y);
    let (beta, reference) = match known.instrument {
        Magnetometer::Reference => (third, factors),
        Magnetometer::Test => {
            let lengths = Vector3::from_fn(|i, _| eta.row(i).transpose().component_div(&factors).norm());
            (0.0, lengths.map(|length| lengths.y / length))
        }
    };
    let columns = std::array::from_fn(|j| eta.column(j).component_mul(&reference));
    Pair::beside((beta, Vector3::z(), [reference.x, reference.z]), &columns)
}

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
    fn left<T: Real>(&self, pair: &Pair<T>) -> [T; UNKNOWNS] {
        let eta = pair.eta();
        let [z_r, x, y, z] = &pair.axes;
        let [_, xr_yr, zr_yr, xt_yt, zt_yt] = pair.ratios;
        let own = match self.known.instrument {
            Magnetometer::Reference => [z_r[0], z_r[1], pair.beta, xr_yr, zr_yr],
            Magnetometer::Test => [x.dot(y), y.dot(z), x.dot(z), xt_yt, zt_yt],
        };
        std::array::from_fn(|row| if row < 9 { eta[row] / self.scales[row / 3] } else { own[row - 9] })
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
        for (row, left) in self.left(pair).into_iter().enumerate() {
            let right =
                if row < 9 { self.eta[row] / self.scales[row / 3] } else { self.known.values[row - 9] };
            residual[row] = right - left;
        }
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
