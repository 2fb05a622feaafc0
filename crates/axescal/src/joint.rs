//! What the directions owe to what was known before: constants, resistor, voltmeter, effects.
//!
//! The fit holds an unknown u with prior knowledge to zero by the weight P. Where the truth is x instead, all
//! unknowns err by −C P x. A constant of the document that errs by δ makes x = δ ∂x/∂constant, so its sources
//! move the directions by −C P ∂x/∂constant. What the prior adds to C by its row of the fit is left out for
//! that, so that sources bring it in with all that they have in common.

use common::covariance;
use common::uncertainty::{self, Block, By};
use common::{Axis, Document, PerAxis, Uncertainty};
use estimate::stats;
use faer::{ColRef, Mat};

use crate::freedom::{constant, drive};
use crate::unknowns::{Unknown, place};
use crate::{AxesProblem, AxesState, Error, Observations, Result, Solution};

/// The covariance of the unknowns, split: what the readings and theodolites make, and what parameters do.
pub struct Split {
    own: Mat<f64>,
    by: By,
}

/// Splits the covariance of a solution and restates it with all that the sources have in common; `by_effects`
/// is how the unknowns err with the parameters of the model.
pub fn restate(
    document: &Document,
    observations: &Observations,
    solution: &mut Solution,
    by_effects: By,
) -> Result<Split> {
    let joint = Uncertainty::of(document)?;
    let problem = AxesProblem::new(observations, &solution.freedom, solution.noise);
    let count = solution.meaning.len();
    let covariance = &solution.covariance;
    let mut by = by_effects;
    // C Jᵀ: what one standard deviation of each row of the fit moves the unknowns by.
    let mut rows = covariance * solution.fit.jacobian.transpose();
    let first = observations.readings.len();
    for (row, (place, weight)) in problem.priors.iter().enumerate() {
        let truth = truths(document, (observations, &solution.fit.state), solution.meaning[*place]);
        let variance = joint.covariance_by(&truth).sum();
        // C P for this unknown, P = 1/σ².
        let gain: Vec<f64> = (0..count).map(|k| covariance[(k, *place)] * weight * weight).collect();
        let left = (1.0 - variance * weight * weight).max(0.0).sqrt();
        (0..count).for_each(|k| rows[(k, first + row)] *= left);
        let error = |change: f64| gain.iter().map(|gain| -gain * change).collect();
        by.extend(truth.into_iter().map(|(path, change)| (path, error(change[0]))));
    }
    let own = &rows * rows.transpose();
    solution.covariance = if by.is_empty() { own.clone() } else { &own + joint.covariance_by(&by) };
    Ok(Split { own, by })
}

/// What an unknown is in truth where parameters of the document err: each with the derivative.
fn truths(document: &Document, (observations, state): (&Observations, &AxesState), unknown: Unknown) -> By {
    let calibration = document.calibration.as_ref();
    let of = |drive: By, which: usize, factor: f64| {
        drive.into_iter().map(move |(path, like)| (path, vec![factor * like[which]]))
    };
    match unknown {
        Unknown::SensorScale(axis) => {
            let sensor = calibration.and_then(|calibration| calibration.sensor(axis));
            let k = sensor.and_then(|sensor| physics::sensitivity(sensor, observations.unit));
            let path = uncertainty::sensitivity(axis, observations.unit.suffix());
            k.map(|k| (path, vec![1.0 / k.value()])).into_iter().collect()
        }
        Unknown::Offset(axis) => vec![(uncertainty::sensor_offset(axis), vec![1.0])],
        Unknown::CoilScale(axis) => of(drive(document, axis), 0, -1.0 / constant(document, axis)).collect(),
        Unknown::ResidualField(k) => {
            let coils = observations.coils.iter();
            coils.flat_map(|coil| of(drive(document, *coil), 1, -state.eta[(k, coil.index())])).collect()
        }
        Unknown::Sensor(..) | Unknown::Coil(..) | Unknown::Correction(..) => By::new(),
    }
}

/// Takes the directions, and the constants found with them, into the document's joint uncertainty.
pub fn adopt(
    document: &mut Document,
    observations: &Observations,
    solution: &Solution,
    split: &Split,
) -> Result<()> {
    let count = solution.meaning.len();
    let mut parameters =
        ["sensors", "coils"].map(uncertainty::directions).into_iter().flatten().collect::<Vec<_>>();
    let mut rows: Vec<Vec<f64>> = solution.turns(observations).iter().flat_map(covariance::rows).collect();
    // What is to be added to an offset errs against the unknown, the field with it.
    for (path, unknown, sign) in constants(document) {
        if let Some(place) = place(&solution.meaning, unknown) {
            parameters.push(path);
            rows.push((0..count).map(|k| if k == place { sign } else { 0.0 }).collect());
        }
    }
    let map = Mat::from_fn(rows.len(), count, |i, j| rows[i][j]);
    let of = |by: &[f64]| (&map * ColRef::from_slice(by)).iter().copied().collect();
    let mut joint = Uncertainty::of(document)?;
    joint
        .put(Block {
            name: "axes: readings and theodolites".into(),
            degrees_of_freedom: solution.noise_freedom,
            parameters,
            covariance: &map * &split.own * map.transpose(),
            by: split.by.iter().map(|(path, by)| (path.clone(), of(by))).collect(),
        })
        .map_err(|found| Error::Unanswerable(format!("the covariance of the directions is {found}")))?;
    let calibration = document.calibration.get_or_insert_default();
    let axes = calibration.axes.get_or_insert_default();
    for (each, path) in [
        (&mut axes.offsets_nt, uncertainty::added_offset as fn(Axis) -> String),
        (&mut axes.residual_field_nt, uncertainty::residual_field),
    ] {
        for axis in Axis::ALL {
            if let Some(quantity) = each.as_mut().and_then(|each| each.entry(axis).as_mut()) {
                let freedom = joint.degrees_of_freedom(&path(axis));
                *quantity = quantity.clone().covered_by(stats::coverage_factor(0.95, freedom));
            }
        }
    }
    calibration.uncertainty = Some(joint);
    Ok(())
}

/// The offsets and the components of the residual field that were written: their paths, the unknowns, and the
/// signs with which the unknowns' errors are theirs.
fn constants(document: &Document) -> Vec<(String, Unknown, f64)> {
    let axes = document.calibration.iter().flat_map(|calibration| &calibration.axes);
    let offsets = axes.clone().flat_map(|axes| &axes.offsets_nt).flat_map(PerAxis::iter);
    let field = axes.flat_map(|axes| &axes.residual_field_nt).flat_map(PerAxis::iter);
    let offset = |(axis, _)| (uncertainty::added_offset(axis), Unknown::Offset(axis), -1.0);
    let component =
        |(axis, _): (Axis, _)| (uncertainty::residual_field(axis), Unknown::ResidualField(axis.index()), 1.0);
    offsets.map(offset).chain(field.map(component)).collect()
}
