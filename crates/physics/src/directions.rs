//! A set of directions with its uncertainty, as the document states it.

use common::covariance::{between, rows};
use common::{AxesDirections, Axis, OneOrEach, Quantity};
use faer::Mat;
use indexmap::IndexMap;
use nalgebra::{Matrix3, Matrix3x2, Vector3};

use crate::frames::{self, ARCSEC, angle, tangents};

/// Matrix, uncertainties and angles of the axes that are known; `covariance` is of the matrix's elements,
/// column by column.
pub fn directions(axes: &[Axis], matrix: &Matrix3<f64>, covariance: &Mat<f64>) -> AxesDirections {
    let column = |axis: Axis| matrix.column(axis.index()).into_owned();
    // Standard uncertainty of a linear function of the nine elements.
    let std = |weights: &[(Axis, Vector3<f64>)]| -> f64 {
        let mut by = [Vector3::zeros(); 3];
        weights.iter().for_each(|(axis, weight)| by[axis.index()] = *weight);
        let by: Vec<f64> = by.iter().flatten().copied().collect();
        between(covariance, &by, &by).max(0.0).sqrt()
    };
    let largest = |axis: Axis| -> f64 {
        let first = 3 * axis.index();
        let own = Matrix3::from_fn(|r, s| covariance[(first + r, first + s)]);
        let across = Matrix3x2::from_columns(&tangents(&column(axis)));
        let ellipse = across.transpose() * own * across;
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
        covariance: Some(rows(covariance)),
        covariance_order: Some((0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect()),
        extra: Default::default(),
    }
}
