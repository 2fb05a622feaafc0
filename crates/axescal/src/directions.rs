//! The directions among the unknowns.

use common::Axis;
use faer::Mat;
use nalgebra::Matrix3;
use physics::frames::tangents;

use crate::Solution;
use crate::unknowns::Unknown;

/// The 9×n matrix from the unknowns to the elements of a matrix of directions, column by column.
pub(crate) fn turns(
    solution: &Solution,
    axes: &[Axis],
    first: impl Fn(Axis) -> Unknown,
    matrix: &Matrix3<f64>,
) -> Mat<f64> {
    let mut map = Mat::zeros(9, solution.meaning.len());
    for &axis in axes {
        let Some(place) = solution.meaning.iter().position(|meaning| *meaning == first(axis)) else {
            continue;
        };
        for (k, tangent) in tangents(&matrix.column(axis.index()).into_owned()).iter().enumerate() {
            (0..3).for_each(|row| map[(3 * axis.index() + row, place + k)] = tangent[row]);
        }
    }
    map
}
