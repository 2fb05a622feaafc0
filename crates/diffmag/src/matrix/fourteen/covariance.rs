//! Uncertainty to first order (JCGM 100, 5.2), with exact derivatives and a rule for azimuths of vertical
//! axes.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use num_dual::Dual64;

use super::closed;
use super::known::KnownFive;
use super::pair::{ANGLES, BETA, Pair, RATIOS};
use super::parameters::{EtaCovariance, Fourteen, NAMES};

/// π/√3, rad: the standard deviation of an azimuth that may be any.
pub const UNDETERMINED_RAD: f64 = 1.813_799_364_234_217_8;

/// An azimuth no better than this is beyond propagation to first order, rad: its axis is within four of its
/// standard uncertainties of the vertical.
const LOOSE_RAD: f64 = 0.25;
/// An axis this near to the vertical has lost its azimuth to rounding.
const POLE: f64 = 1e-12;

/// The parameters of `pair`, found from η and what is known, with their covariance J Σ Jᵀ.
///
/// Where an axis is vertical within four standard uncertainties (that of its azimuth would exceed 0.25 rad to
/// first order), the azimuth takes [`UNDETERMINED_RAD`], the polar angle the root mean square of the tilt
/// about the value found, and neither correlates with anything. Nearer to the vertical than that, first-order
/// intervals of 95 % hold the azimuth in 60 to 90 % of cases only.
pub(super) fn propagate(
    pair: &Pair,
    eta: &Matrix3<f64>,
    eta_covariance: &EtaCovariance,
    known: &KnownFive,
) -> Fourteen {
    let mut given = SMatrix::<f64, 14, 14>::zeros();
    given.fixed_view_mut::<9, 9>(0, 0).copy_from(eta_covariance);
    given.fixed_view_mut::<5, 5>(9, 9).copy_from(&known.covariance);
    // Derivatives by the nine elements of η and the five known values, of the parameters, of the horizontal
    // parts of the four axes, and of the cosines. One run of the closed form for each given number, that
    // number carrying the derivative.
    let mut jacobian = SMatrix::<f64, 14, 14>::zeros();
    let mut horizontal = [SMatrix::<f64, 2, 14>::zeros(); 4];
    let mut cosines = SMatrix::<f64, 6, 14>::zeros();
    for number in 0..14 {
        let mut lifted_eta = eta.map(Dual64::from);
        let mut lifted_values = known.values.map(Dual64::from);
        if number < 9 {
            lifted_eta[number].eps = 1.0;
        } else {
            lifted_values[number - 9].eps = 1.0;
        }
        let moved = closed::solve(&lifted_eta, known.instrument, &lifted_values);
        let mut column = jacobian.column_mut(number);
        column[BETA] = moved.beta.eps;
        for (k, ratio) in moved.ratios.iter().enumerate() {
            column[RATIOS + k] = ratio.eps;
        }
        for (k, [azimuth, polar]) in ANGLES.into_iter().enumerate() {
            let change = moved.axes[k].map(|component| component.eps);
            [column[azimuth], column[polar]] = turn(&pair.axes[k], &change);
            horizontal[k].set_column(number, &change.xy());
        }
        cosines.set_column(number, &SVector::from(moved.cosines().map(|cosine| cosine.eps)));
    }
    let covariance = jacobian * given * jacobian.transpose();
    let mut covariance = (covariance + covariance.transpose()) * 0.5;
    let mut undetermined = Vec::new();
    for (k, [azimuth, polar]) in ANGLES.into_iter().enumerate() {
        let lost = pair.axes[k].xy().norm() < POLE;
        if lost || covariance[(azimuth, azimuth)] > LOOSE_RAD * LOOSE_RAD {
            for place in [azimuth, polar] {
                covariance.row_mut(place).fill(0.0);
                covariance.column_mut(place).fill(0.0);
            }
            covariance[(azimuth, azimuth)] = UNDETERMINED_RAD * UNDETERMINED_RAD;
            covariance[(polar, polar)] = (horizontal[k] * given * horizontal[k].transpose()).trace();
            undetermined.push(NAMES[azimuth]);
        }
    }
    let spread = cosines * given * cosines.transpose();
    Fourteen {
        values: pair.parameters(),
        covariance,
        undetermined,
        cosines: pair.cosines(),
        cosine_uncertainties: std::array::from_fn(|k| spread[(k, k)].max(0.0).sqrt()),
    }
}

/// Changes of azimuth and polar angle (rad) of a unit vector a = (x, y, z) that moves by da, with h² = x² +
/// y²: dφ = (y dx − x dy)/h², dθ = z (x dx + y dy)/h − h dz. Zero for a vertical axis, which has neither.
fn turn(axis: &Vector3<f64>, change: &Vector3<f64>) -> [f64; 2] {
    let h = axis.x.hypot(axis.y);
    if h < POLE {
        return [0.0, 0.0];
    }
    let azimuth = (axis.y * change.x - axis.x * change.y) / (h * h);
    let polar = axis.z * (axis.x * change.x + axis.y * change.y) / h - h * change.z;
    [azimuth, polar]
}
