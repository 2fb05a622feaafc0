//! The directions among the unknowns.

use common::Axis;
use faer::Mat;
use nalgebra::Matrix3;
use physics::frames::tangents;

use crate::unknowns::{Unknown, place};
use crate::{Observations, Solution};

/// The 9×n matrices from the unknowns to the elements of the directions of sensors and of coils, column by
/// column.
pub(crate) fn turns(observations: &Observations, solution: &Solution) -> [Mat<f64>; 2] {
    let of = |axes: &[Axis], matrix: &Matrix3<f64>, unknown: fn(Axis, usize) -> Unknown| {
        let mut map = Mat::zeros(9, solution.meaning.len());
        for &axis in axes {
            let Some(place) = place(&solution.meaning, unknown(axis, 0)) else { continue };
            for (k, tangent) in tangents(&matrix.column(axis.index()).into_owned()).iter().enumerate() {
                (0..3).for_each(|row| map[(3 * axis.index() + row, place + k)] = tangent[row]);
            }
        }
        map
    };
    let state = &solution.fit.state;
    [
        of(&observations.sensors, &state.mu, Unknown::Sensor),
        of(&observations.coils, &state.eta, Unknown::Coil),
    ]
}
