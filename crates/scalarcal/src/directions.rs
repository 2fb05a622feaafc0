//! The directions of the sensors as a function of the parameters.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::model::{Model, NINE, Parameter, State, cosines};

/// Step of the derivative of μ by a cosine.
const STEP: f64 = 1e-6;

/// μ⁻ᵀ: the field by what is read along the sensors.
pub fn unmixed(mu: &Matrix3<f64>) -> Matrix3<f64> {
    mu.transpose().try_inverse().unwrap_or_else(Matrix3::identity)
}

/// μ, the directions of the sensors with these cosines: of all turns of them together, which the magnitude
/// does not show, the one that is nearest to `like`, which may be left-handed.
pub fn frame(state: &State, like: &Matrix3<f64>) -> Matrix3<f64> {
    let own = cosines(state);
    // Cholesky's factor has unit vectors with these cosines as its columns.
    let Some(factor) = own.cholesky() else { return *like };
    let columns = factor.l().transpose();
    let hand = like.determinant().signum();
    hand * Rotation3::from_matrix(&(hand * like * columns.transpose())).into_inner() * columns
}

/// μ after a step: the nine as they are now, nearest to μ before, and the turn.
pub fn turned(state: &State, before: usize, mu: &Matrix3<f64>) -> Matrix3<f64> {
    let turn = Rotation3::from_scaled_axis(Vector3::from_column_slice(&state[before..before + 3]));
    turn.into_inner() * frame(state, mu)
}

/// The derivatives of μ by the parameters that turn sensors: cosines, and the turn of all.
pub fn directions_by(model: &Model, state: &State, mu: &Matrix3<f64>) -> Vec<Option<Matrix3<f64>>> {
    let of = |parameter: &Parameter| match parameter {
        Parameter::Cosine(pair) => {
            let moved = |by: f64| {
                let mut state = state[..NINE].to_vec();
                state[6 + pair] += by;
                frame(&state, mu)
            };
            Some((moved(STEP) - moved(-STEP)) / (2.0 * STEP))
        }
        Parameter::Turn(axis) => Some(Vector3::ith(*axis, 1.0).cross_matrix() * mu),
        _ => None,
    };
    model.parameters.iter().map(of).collect()
}
