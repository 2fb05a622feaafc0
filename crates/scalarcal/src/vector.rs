//! Twelve parameters: the readings against a field known with its direction, turned into SEN by the attitude.
//!
//! The field B in GEO gives μᵢ·RB along each sensor, and ρᵢ = kᵢVᵢ + Oᵢ − μᵢ·RB is linear in all but the
//! directions. Along the field μ⁻ᵀρ has the errors of the field model; across it those of the attitude as
//! well, |B| times an angle, so that it weighs less (Holme and Bloxham 1996). Beside a scalar magnetometer,
//! which is better along the field, what is across it alone is used, together with the calibration by the
//! magnitude: noise of equal size in the sensors is independent between the two.
//!
//! Source: R. Holme, J. Bloxham, The treatment of attitude errors in satellite geomagnetic data, Phys. Earth
//! Planet. Inter. 98 (1996) 221–233.

use common::{Code, Document, VectorFit};
use estimate::Svd;
use faer::{Col, Mat};
use nalgebra::{Matrix3, Rotation3};
use physics::frames::ARCSEC;

use crate::design::Rows;
use crate::directions::{frame, nearest, turned};
use crate::fit::FittedState;
use crate::kalman::WHITE;
use crate::known_field::Vectors;
use crate::linear::{Linear, RANK_TOLERANCE, root};
use crate::model::{Model, Parameter};
use crate::read::Series;
use crate::solved::Solved;
use crate::{Error, weakest};

/// Rounds in which parameters, directions and weights settle.
const ROUNDS: usize = 3;
/// A combination of the parameters that is uncertain by more than this share of the field is not determined.
const UNDETERMINED: f64 = 0.1;

/// Takes what the direction of the field says into a calibration by its magnitude.
///
/// Errors: a recording without field or attitude; attitudes that do not determine the calibration.
pub fn solve(document: &Document, mut solved: Solved, series: &[Series]) -> Result<Solved, Error> {
    let (scales, stated) = (solved.given.scales, solved.given.mu);
    let mut vectors = Vectors::read(document, Rows::new(series, scales))?;
    let (start, inverse) = vectors.start(&solved.model)?;
    let axes = nearest(&start, &stated);
    solved.scalar.findings.extend(axes.told());
    if inverse {
        solved.scalar.findings.push(
            Code::AttitudeInverted.said("the readings agree with the inverse of the attitude: attitude_{w,x,y,z} must be GEO → SEN; reverse the signs of x, y and z"),
        );
    }
    let count = solved.model.parameters.len() + 3;
    let before = solved.found.state.len();
    solved.model.parameters.extend((0..3).map(Parameter::Turn));
    solved.found.state.extend([0.0; 3]);
    // Beside a scalar magnetometer the calibration by the magnitude is held, with its covariance.
    let by_magnitude = solved.found.clone();
    solved.held =
        if vectors.scalar { known(&solved.found, before).padded(count) } else { Linear::none(count) };
    let prior = solved.given.known && !vectors.scalar;
    solved.known = if prior { solved.given.prior.padded(count) } else { solved.held.clone() };
    let sensor = solved.found.sensor;
    let mut mu = frame(&solved.found.state, &start);
    let mut spread = vectors.spread(&solved.model, &solved.found.state, &mu);
    let mut noise = None;
    for round in 0..=ROUNDS {
        solved.found.state[before..].fill(0.0);
        vectors.share = if sensor > 0.0 { 1.0 - (sensor / spread.along).min(1.0) } else { 0.0 };
        let groups = vectors.groups(&solved.model, &solved.found.state, &mu, spread);
        let base = solved.given.form(spread.along);
        let freedom = (groups.rows - count as f64).max(1.0);
        let linear = groups.linear(WHITE, spread.along * groups.rows / freedom, true);
        let Some(linear) = linear else { break };
        let all = linear.and(&solved.known.about(&solved.found.state));
        let svd = all.svd()?;
        if svd.rank() < count {
            return Err(undetermined(&solved.model, &all.jacobian));
        }
        let step = svd.solve(&all.right);
        solved.found.covariance = svd.covariance();
        solved.found.jacobian = linear.and(&solved.held).jacobian;
        if round < ROUNDS {
            solved.found.state.iter_mut().zip(&step).for_each(|(value, step)| *value += step);
        } else {
            let averaged = groups.average(
                &mut solved.found,
                (&solved.held, &solved.known),
                // The sensors' memory may be too small beside the noise of the field.
                (base.unwrap_or(WHITE), true, scales.magnitude_nt),
            )?;
            noise = averaged;
            solved.found.freedom = freedom;
            if vectors.scalar {
                kept(&mut solved.found, &by_magnitude, before);
            }
        }
        mu = turned(&solved.found.state, before, &mu);
        spread = vectors.spread(&solved.model, &solved.found.state, &mu);
    }
    solved.found.seen = Svd::of(solved.found.jacobian.as_ref(), RANK_TOLERANCE)?;
    let worst = (0..count).map(|k| solved.found.covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    if worst > UNDETERMINED {
        return Err(undetermined(&solved.model, &solved.found.jacobian));
    }
    let nine = frame(&solved.found.state, &axes.mu(&stated));
    let turn = Rotation3::from_matrix_unchecked(mu * nine.try_inverse().unwrap_or_else(Matrix3::identity));
    solved.found.state[before..].copy_from_slice(turn.scaled_axis().as_slice());
    solved.found.variance = spread.along;
    solved.mu = mu;
    let rms = |variance: f64| variance.sqrt() * scales.magnitude_nt;
    solved.scalar.vector = Some(VectorFit {
        moments: spread.moments as u64,
        rms_along_nt: rms(spread.along),
        rms_across_nt: rms(spread.across),
        attitude_std_arcsec: spread.attitude.sqrt() / ARCSEC,
        across_only: vectors.scalar,
        memory_of: noise.as_ref().filter(|(form, _)| form.ratio > 0.0).map(|(form, _)| form.of.name().into()),
        noise: noise.map(|(_, noise)| noise),
    });
    Ok(solved)
}

/// Keeps the parameters that the magnitude shows as they were found by it, and of the rest what is to be
/// expected given those. What the direction says of them is not used: the noise with memory of the sensors,
/// which the magnitude shows, is hidden there beside that of the field.
fn kept(found: &mut FittedState, by_magnitude: &FittedState, before: usize) {
    let count = found.state.len();
    // G = C_tn C_nn⁻¹.
    let weights = known(found, before).jacobian;
    let mut map = found.covariance.subcols(0, before) * weights.transpose() * &weights;
    map.subrows_mut(0, before).copy_from(Mat::<f64>::identity(before, before));
    let moved = Col::from_fn(before, |k| by_magnitude.state[k] - found.state[k]);
    found.state.iter_mut().zip((&map * moved).iter()).for_each(|(value, by)| *value += by);
    let alone = &found.covariance - &map * found.covariance.subrows(0, before);
    let carried = &map * &by_magnitude.covariance * map.transpose();
    found.covariance = Mat::from_fn(count, count, |i, j| {
        carried[(i, j)] + if i < before || j < before { 0.0 } else { alone[(i, j)] }
    });
    found.jacobian = root(&found.covariance);
}

/// The first parameters of a fit as rows of one that takes its place.
fn known(found: &FittedState, count: usize) -> Linear {
    let covariance = found.covariance.submatrix(0, 0, count, count).to_owned();
    Linear::known(&found.state[..count], &covariance)
}

fn undetermined(model: &Model, jacobian: &Mat<f64>) -> Error {
    let information = jacobian.transpose() * jacobian;
    let names =
        weakest::least(&information).map(|(_, weakest)| weakest::named(model, &weakest)).unwrap_or_default();
    let list: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
    Error::Unanswerable(format!(
        "field and attitude do not determine the calibration: {} cannot be determined. Record more attitudes, so that the field lies along each \
         sensor in both directions and between them",
        if list.is_empty() { "some parameters".into() } else { list.join(", ") }
    ))
}
