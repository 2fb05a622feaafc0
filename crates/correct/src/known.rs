//! What the correction rests on: the uncertainties of the parameters of the chain behind the field, jointly.

use common::uncertainty::{self, By, root};
use common::{Axis, Document, Quantity, Uncertainty};
use faer::{ColRef, Mat};
use physics::frames::{matrix, tangents};
use physics::{Direction, EffectInstance, Parameter, Role, Unit};

/// A parameter of the chain as a sum of parameters of the document.
type Stated = (Parameter, Vec<(String, f64)>);

/// Independent sources of uncertainty of a document with its joint uncertainty, by how each moves the
/// parameters of the chain; their outer products add up to the covariance. For readings in `unit`: k and O of
/// each sensor, the directions of the sensors, and the parameters of `effects`, which stand at these `places`
/// of `model.effects`.
pub fn sources(
    document: &Document,
    joint: &Uncertainty,
    (effects, places): (&[EffectInstance], &[usize]),
    unit: Unit,
) -> Result<Vec<Direction>, common::Error> {
    let mut stated: Vec<Stated> =
        Axis::ALL.iter().flat_map(|axis| constants(document, *axis, unit)).collect();
    stated.extend(turns(document));
    stated.extend(model(document, effects, places));
    let of = |at: usize, weight: f64| {
        (0..stated.len()).map(|other| if other == at { weight } else { 0.0 }).collect()
    };
    let by = stated.iter().enumerate();
    let by: By = by
        .flat_map(|(at, (_, by))| by.iter().map(move |(path, weight)| (path.clone(), of(at, *weight))))
        .collect();
    let all = joint.covariance_by(&by);
    let moving: Vec<usize> = (0..stated.len()).filter(|at| all[(*at, *at)] != 0.0).collect();
    let covariance = Mat::from_fn(moving.len(), moving.len(), |a, b| all[(moving[a], moving[b])]);
    // No more sources than parameters, and each beginning one parameter later.
    let sources = root(&covariance).map_err(|found| {
        common::Error::document("calibration.uncertainty", found, "moves that make a covariance")
    })?;
    let parameters = || moving.iter().map(|at| stated[*at].0);
    let direction = |moves: ColRef<'_, f64>| {
        parameters().zip(moves.iter().copied()).filter(|(_, moved)| *moved != 0.0).collect()
    };
    Ok(sources.col_iter().map(direction).collect())
}

/// k and O of one sensor. What axescal found to be added to O has O's own uncertainty in it as what was known
/// before: its uncertainty is that of their sum.
fn constants(document: &Document, axis: Axis, unit: Unit) -> [Stated; 2] {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let added = axes.and_then(|axes| axes.offsets_nt.as_ref()?.get(axis)).and_then(Quantity::std);
    let offset = match added {
        Some(_) => uncertainty::added_offset(axis),
        None => uncertainty::sensor_offset(axis),
    };
    let scale = uncertainty::sensitivity(axis, unit.suffix());
    [(Parameter::Sensitivity(axis), scale), (Parameter::SensorOffset(axis), offset)]
        .map(|(parameter, path)| (parameter, vec![(path, 1.0)]))
}

/// The turns of the sensors along their tangents, by the nine cosines.
fn turns(document: &Document) -> Vec<Stated> {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let Some(rows) = axes.and_then(|axes| axes.sensors.as_ref()?.matrix.as_ref()) else { return Vec::new() };
    let mu = matrix(rows);
    let paths = uncertainty::directions("sensors");
    let of = |axis: Axis| {
        let first = 3 * axis.index();
        let both = tangents(&mu.column(axis.index()).into_owned()).into_iter().enumerate();
        let paths = &paths[first..first + 3];
        both.map(move |(which, tangent)| {
            let by = paths.iter().cloned().zip(tangent.iter().copied()).collect();
            (Parameter::SensorTurn(axis, which), by)
        })
    };
    Axis::ALL.into_iter().flat_map(of).collect()
}

fn model(document: &Document, effects: &[EffectInstance], places: &[usize]) -> Vec<Stated> {
    let Some(adopted) = document.model.as_ref().map(|model| &model.effects) else { return Vec::new() };
    let mut all = Vec::new();
    for (number, (effect, at)) in effects.iter().zip(places).enumerate() {
        for (place, info) in effect.kind.parameters().iter().enumerate() {
            // The moment of a step or a spike has no derivative.
            if info.role != Role::Epoch {
                let path = uncertainty::effect(&adopted[*at], info.name);
                all.push((Parameter::Effect(number, place), vec![(path, 1.0)]));
            }
        }
    }
    all
}
