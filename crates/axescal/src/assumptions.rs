//! What the recordings did not show and was taken as zero, and how far that may turn a direction.

use common::{Assumption, Axis, Document};
use estimate::Problem;
use nalgebra::{DMatrix, Matrix3};
use physics::frames::ARCSEC;

use crate::freedom::{residual_field_std, separates_constants};
use crate::unknowns::{Unknown, turns};
use crate::{AxesProblem, Freedom, Observations, Solution};

pub fn list(document: &Document, observations: &Observations, solution: &Solution) -> Vec<Assumption> {
    let mut list = Vec::new();
    let constant = observations.readings.iter().any(|reading| reading.constant);
    let shift = |freedom: Freedom, is: &dyn Fn(Unknown) -> bool| shift(observations, solution, &freedom, is);
    let shown = observations.sensors.iter().any(|sensor| separates_constants(observations, *sensor));
    if constant && !shown && residual_field_std(document).is_none() {
        let freedom = Freedom { residual_field: Some([f64::INFINITY; 3]), ..solution.freedom.clone() };
        let is = |unknown| matches!(unknown, Unknown::ResidualField(_));
        list.push(Assumption {
            assumed: "the residual field is zero (no zero or reversed drives were recorded)".into(),
            arcsec_per_nt: Some(largest(&shift(freedom, &is)) / ARCSEC),
            arcsec_per_arcsec: None,
        });
    }
    let unstated = |axis: Axis| solution.freedom.offsets[axis.index()].is_none();
    if constant && observations.sensors.iter().any(|axis| unstated(*axis)) {
        let freedom = Freedom { offsets: [Some(f64::INFINITY); 3], ..solution.freedom.clone() };
        let is = |unknown| matches!(unknown, Unknown::Offset(axis) if unstated(axis));
        list.push(Assumption {
            assumed: "the sensor offsets in the calibration are exact".into(),
            arcsec_per_nt: Some(largest(&shift(freedom, &is)) / ARCSEC),
            arcsec_per_arcsec: None,
        });
    }
    if !solution.freedom.orientations {
        let mut uncertain = observations.clone();
        for group in &mut uncertain.orientations {
            group.orientation.uncertainty = Matrix3::identity();
        }
        let freedom = Freedom { orientations: true, ..solution.freedom.clone() };
        let is = |unknown| matches!(unknown, Unknown::Correction(..));
        let shift = self::shift(&uncertain, solution, &freedom, &is);
        list.push(Assumption {
            assumed: "the orientations are exact (no theodolite_arcsec is stated)".into(),
            arcsec_per_nt: None,
            arcsec_per_arcsec: Some(largest(&shift)),
        });
    }
    list
}

/// Change of the turns for a unit of each unknown that was left out and that `is` names: −C Jᵀ J_out.
fn shift(
    observations: &Observations,
    solution: &Solution,
    freedom: &Freedom,
    is: &dyn Fn(Unknown) -> bool,
) -> DMatrix<f64> {
    let problem = AxesProblem::new(observations, freedom, solution.noise);
    let (_, jacobian) = estimate::linearised(&problem, &solution.fit.state);
    let count = problem.readings();
    let out: Vec<usize> = (0..problem.unknowns()).filter(|place| is(problem.meaning[*place])).collect();
    let turns = turns(&solution.meaning);
    let mut shift = DMatrix::zeros(turns.len(), out.len());
    for (column, place) in out.iter().enumerate() {
        let normal: Vec<f64> = (0..solution.meaning.len())
            .map(|k| (0..count).map(|row| solution.fit.jacobian[(row, k)] * jacobian[(row, *place)]).sum())
            .collect();
        for (row, turn) in turns.iter().enumerate() {
            shift[(row, column)] =
                -normal.iter().enumerate().map(|(k, n)| solution.covariance[(*turn, k)] * n).sum::<f64>();
        }
    }
    shift
}

/// Largest turn of any direction for an error of unit length (singular value of a direction's pair of rows).
fn largest(shift: &DMatrix<f64>) -> f64 {
    (0..shift.nrows() / 2)
        .map(|direction| {
            let rows = shift.rows(2 * direction, 2);
            let square = rows * rows.transpose();
            nalgebra::Matrix2::new(square[(0, 0)], square[(0, 1)], square[(1, 0)], square[(1, 1)])
                .symmetric_eigenvalues()
                .max()
                .max(0.0)
                .sqrt()
        })
        .fold(0.0, f64::max)
}
