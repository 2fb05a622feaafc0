//! The rows of one moment: what the sensors read against a field that is known with its direction.

use nalgebra::{Matrix3, Vector3};

use crate::directions::{directions_by, unmixed};
use crate::model::{Model, Parameter, State};

/// A moment: what the sensors read, and the field that is known.
pub struct Moment {
    pub own: [f64; 3],
    pub z: Vec<f64>,
    /// In SEN, over the typical magnitude.
    pub field: Vector3<f64>,
    pub rotation: Matrix3<f64>,
}

/// How much rows err: variances over the square of the typical magnitude.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    pub along: f64,
    pub across: f64,
    /// What the attitude adds across it, by the square of the field.
    pub attitude: f64,
    pub moments: usize,
}

/// A state about which moments become rows.
pub struct About<'s> {
    model: &'s Model,
    state: &'s State,
    mu: &'s Matrix3<f64>,
    /// μ⁻ᵀ.
    inverse: Matrix3<f64>,
    by: Vec<Option<Matrix3<f64>>>,
    share: f64,
    scalar: bool,
    spread: Spread,
}

impl<'s> About<'s> {
    /// About a state with its directions, by the share of the field in the noise and whether a scalar
    /// magnetometer reads beside.
    pub fn new(
        model: &'s Model,
        state: &'s State,
        mu: &'s Matrix3<f64>,
        (share, scalar): (f64, bool),
        spread: Spread,
    ) -> Self {
        let inverse = unmixed(mu);
        Self { model, state, mu, inverse, by: directions_by(model, state, mu), share, scalar, spread }
    }

    /// Along the field and twice across it: what is to be explained, its derivatives, and what the row reads
    /// of the noise of the field in GEO. The derivatives are taken at the most likely field and reading: at
    /// what was read, they would be correlated with the residual.
    pub fn rows(&self, moment: &Moment) -> Vec<Vec<f64>> {
        let field = &moment.field;
        let off = Vector3::from(moment.own) - self.mu.transpose() * field;
        let likely = field + self.share * (self.inverse * off);
        let own = Vector3::from(moment.own) - (1.0 - self.share) * off;
        let derivative = |(j, parameter): (usize, &Parameter)| -> Vector3<f64> {
            match parameter {
                Parameter::Sensitivity(axis) => {
                    let read = moment.z[*axis] + (own[*axis] - moment.own[*axis]) / self.state[*axis];
                    Vector3::ith(*axis, read)
                }
                Parameter::Offset(axis) => Vector3::ith(*axis, 1.0),
                Parameter::Effect { follows, .. } => Vector3::from_fn(|axis, _| {
                    follows[axis].map_or(0.0, |(column, factor)| -factor * moment.z[column])
                }),
                _ => self.by[j].map_or_else(Vector3::zeros, |by| -(by.transpose() * likely)),
            }
        };
        let derivatives: Vec<Vector3<f64>> =
            self.model.parameters.iter().enumerate().map(derivative).collect();
        let unit = field.normalize();
        let first = unit.cross(&Vector3::ith(unit.iamin(), 1.0)).normalize();
        let attitude = self.spread.attitude * field.norm_squared();
        let across = (self.spread.along / (self.spread.along + attitude)).sqrt();
        let all = [(unit, 1.0), (first, across), (unit.cross(&first), across)];
        all.into_iter()
            .skip(usize::from(self.scalar))
            .map(|(direction, weight)| {
                let along = weight * (self.inverse.transpose() * direction);
                let geo = weight * (moment.rotation.transpose() * direction);
                std::iter::once(-along.dot(&off))
                    .chain(derivatives.iter().map(|by| along.dot(by)))
                    .chain(geo.iter().copied())
                    .collect()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::{frame, turned};
    use crate::model::own;
    use crate::terms::ONE;

    #[test]
    fn rows_move_as_their_derivatives_say() {
        let effect = Parameter::Effect {
            number: [0, 0],
            follows: [Some((4, 1.0)), None, Some((4, 0.7))],
            name: String::new(),
        };
        let turns = (0..3).map(Parameter::Turn);
        let model = Model::new(ONE + 2, std::iter::once(effect).chain(turns));
        let state = vec![1.1, 0.9, 1.02, 0.01, -0.02, 0.03, 0.05, -0.04, 0.02, 0.3, 0.0, 0.0, 0.0];
        let mu = frame(&state, &Matrix3::new(0.0, 1.0, 0.1, -1.0, 0.0, 0.0, 0.0, 0.1, 1.0));
        let z = vec![0.4, -0.3, 0.8, 1.0, 0.2, 0.97];
        // A field that explains the readings: where it does not, the weights move as well.
        let along = Vector3::from(own(&model.along(&state), &z));
        let field = mu.transpose().try_inverse().expect("axes") * along;
        let spread = Spread { along: 1e-8, across: 3e-8, attitude: 2e-8, moments: 1 };
        let rows = |state: &State, mu: &Matrix3<f64>| {
            let own = own(&model.along(state), &z);
            let moment = Moment { own, z: z.clone(), field, rotation: Matrix3::identity() };
            About::new(&model, state, mu, (0.5, false), spread).rows(&moment)
        };
        let at = rows(&state, &mu);
        for (j, parameter) in model.parameters.iter().enumerate() {
            let moved = |by: f64| {
                let mut state = state.clone();
                state[j] += by;
                rows(&state, &turned(&state, 10, &mu))
            };
            let (up, down) = (moved(1e-6), moved(-1e-6));
            for k in 0..3 {
                // What is to be explained falls as the residual rises.
                let slope = -(up[k][0] - down[k][0]) / 2e-6;
                let found = at[k][1 + j];
                assert!((slope - found).abs() < 1e-8, "{parameter:?}, row {k}: {slope} {found}");
            }
        }
    }
}
