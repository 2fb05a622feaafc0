//! The directions of the sensors, and the axis that each is nearest to: swapped and mirrored channels.

use common::{Code, Finding};
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::model::{AXES, Model, NINE, Parameter, State, cosines};

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

/// For each sensor the axis of the stated ones that it is nearest to, and the sign.
pub struct Axes([(usize, f64); 3]);

/// The nearest axes, each taken once: the assignment with the largest sum of cosines.
pub fn nearest(mu: &Matrix3<f64>, stated: &Matrix3<f64>) -> Axes {
    let cosine = |sensor: usize, axis: usize| mu.column(sensor).dot(&stated.column(axis));
    let orders = [[0, 1, 2], [1, 0, 2], [0, 2, 1], [2, 1, 0], [1, 2, 0], [2, 0, 1]];
    let sum = |order: &[usize; 3]| (0..3).map(|sensor| cosine(sensor, order[sensor]).abs()).sum::<f64>();
    let best = orders.into_iter().max_by(|a, b| sum(a).total_cmp(&sum(b))).unwrap_or(orders[0]);
    Axes(std::array::from_fn(|sensor| (best[sensor], cosine(sensor, best[sensor]).signum())))
}

impl Axes {
    /// The stated directions in the order and with the signs that were found.
    pub fn mu(&self, stated: &Matrix3<f64>) -> Matrix3<f64> {
        let columns = self.0.map(|(axis, sign)| sign * stated.column(axis));
        Matrix3::from_columns(&columns)
    }

    pub fn told(&self) -> Option<Finding> {
        let order = self.0.map(|(axis, _)| axis);
        let mirrored: Vec<&str> =
            (0..3).filter(|sensor| self.0[*sensor].1 < 0.0).map(|sensor| AXES[sensor]).collect();
        let swapped: Vec<&str> =
            (0..3).filter(|sensor| order[*sensor] != *sensor).map(|sensor| AXES[sensor]).collect();
        let along = |sensor: usize| {
            let (axis, sign) = self.0[sensor];
            format!("{} along {}{}", AXES[sensor], if sign < 0.0 { "−" } else { "" }, AXES[axis])
        };
        let all = [0, 1, 2].map(along).join(", ");
        let left_handed = self.mu(&Matrix3::identity()).determinant() < 0.0;
        match (swapped.as_slice(), mirrored.as_slice(), left_handed) {
            ([], [], _) => None,
            ([a, b], [], _) => Some(Code::Swapped.said(format!(
                "the channels of sensors {a} and {b} are swapped, or the sensors are mounted that way: exchange the two columns, or state the directions under calibration.axes.sensors"
            ))),
            ([], [one], _) => Some(Code::SensorReversed.about(one).said(format!(
                "sensor {one} reads the field with the opposite sign: change the sign of its column, or state its direction under \
                 calibration.axes.sensors"
            ))),
            (_, _, true) => Some(Code::LeftHanded.said(format!(
                "the axes are left-handed ({all}): channels are swapped or mirrored; exchange columns or change signs, or state the directions \
                 under calibration.axes.sensors"
            ))),
            (_, _, false) => Some(Code::Rotated.said(format!(
                "the sensors are rotated relative to the axes of the attitude ({all}): state the directions under calibration.axes.sensors, or give \
                 the attitude of the sensors' own frame"
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swapped_and_mirrored() {
        let unit = Matrix3::identity();
        let told = |columns: [Vector3<f64>; 3]| nearest(&Matrix3::from_columns(&columns), &unit).told();
        let [x, y, z] = [Vector3::new(1.0, 0.02, 0.0), Vector3::new(0.01, 1.0, 0.03), Vector3::z()];
        assert_eq!(told([x, y, z]), None);
        let contains = |columns, words: &str| told(columns).is_some_and(|told| told.words.contains(words));
        assert!(contains([y, x, z], "sensors x and y are swapped"));
        assert!(contains([x, y, -z], "sensor z reads the field with the opposite sign"));
        assert!(contains([y, z, -x], "left-handed"));
        assert!(contains(
            [y, -x, z],
            "rotated relative to the axes of the attitude (x along y, y along −x, z along z)"
        ));
    }
}
