//! A set of directions with its uncertainty, as the document states it.

use common::{AxesDirections, Axis, OneOrEach, Quantity};
use indexmap::IndexMap;
use nalgebra::{Matrix2, Matrix3, Vector3};

use crate::frames::{self, ARCSEC, angle, tangents};

/// Matrix, uncertainties and angles of the axes that are known; `covariance` is that of the nine elements of
/// the matrix, column by column.
pub fn directions(axes: &[Axis], matrix: &Matrix3<f64>, covariance: Vec<Vec<f64>>) -> AxesDirections {
    let column = |axis: Axis| matrix.column(axis.index()).into_owned();
    // Standard uncertainty of a linear function of the nine elements.
    let std = |weights: &[(Axis, Vector3<f64>)]| -> f64 {
        let mut variance = 0.0;
        for (a, left) in weights {
            for (b, right) in weights {
                for row in 0..3 {
                    for other in 0..3 {
                        variance +=
                            left[row] * covariance[3 * a.index() + row][3 * b.index() + other] * right[other];
                    }
                }
            }
        }
        variance.max(0.0).sqrt()
    };
    let largest = |axis: Axis| -> f64 {
        let [a, b] = tangents(&column(axis));
        let block = |left: &Vector3<f64>, right: &Vector3<f64>| -> f64 {
            let first = 3 * axis.index();
            (0..9).map(|k| left[k / 3] * covariance[first + k / 3][first + k % 3] * right[k % 3]).sum()
        };
        let ellipse = Matrix2::new(block(&a, &a), block(&a, &b), block(&b, &a), block(&b, &b));
        ellipse.symmetric_eigenvalues().max().max(0.0).sqrt()
    };
    let mut non_orthogonality = IndexMap::new();
    for (first, second) in [(Axis::X, Axis::Y), (Axis::Y, Axis::Z), (Axis::X, Axis::Z)] {
        if axes.contains(&first) && axes.contains(&second) {
            let (a, b) = (column(first), column(second));
            let sine = a.dot(&b).clamp(-1.0, 1.0);
            let std = std(&[(first, b), (second, a)]) / (1.0 - sine * sine).max(1e-12).sqrt();
            non_orthogonality
                .insert(format!("{first}{second}"), Quantity::new(sine.asin() / ARCSEC, std / ARCSEC));
        }
    }
    let off_nominal = axes.iter().map(|&axis| {
        let (own, meant) = (column(axis), Vector3::ith(axis.index(), 1.0));
        let towards = own * own.dot(&meant) - meant;
        let std = if towards.norm() > 1e-9 { std(&[(axis, towards.normalize())]) } else { largest(axis) };
        (axis, Quantity::new(angle(&own, &meant) / ARCSEC, std / ARCSEC))
    });
    let complete = axes.len() == 3;
    let known = axes.iter().map(|&axis| (axis, column(axis).into())).collect();
    AxesDirections {
        matrix: complete.then(|| frames::rows(matrix)),
        directions: (!complete).then_some(known),
        std_arcsec: Some(OneOrEach::Each(axes.iter().map(|&axis| (axis, largest(axis) / ARCSEC)).collect())),
        off_nominal_arcsec: Some(off_nominal.collect()),
        non_orthogonality_arcsec: (!non_orthogonality.is_empty()).then_some(non_orthogonality),
        covariance: Some(covariance),
        covariance_order: Some((0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect()),
        extra: Default::default(),
    }
}
