//! The accepted effects in the document's model, and the calibration that goes with them.

use common::{AdoptedEffect, AxesCalibration, AxesDirections, Document, Quantity, Uncertainty};
use indexmap::IndexMap;
use physics::{Acts, Parameter, Role, Unit, frames};

use crate::fit::Fit;
use crate::joint;
use crate::model::{Model, Unknown, moving_place};
use crate::{Error, Ground, Outcome};

/// Writes effects and calibration; gives the parameters of the effects as they are written.
pub fn adopt(
    document: &mut Document,
    model: &Model<'_>,
    outcome: &Outcome,
) -> Result<Vec<IndexMap<String, Quantity>>, Error> {
    let before = Uncertainty::of(document)?;
    effects(document, outcome);
    let known = outcome.base.fit.state.effects.len();
    write(document, model, &outcome.now, before, known)?;
    let listed = document.model.iter().flat_map(|model| &model.effects);
    Ok(listed.map(|effect| effect.parameters.clone()).collect())
}

/// Writes the calibration of a fit without effects.
pub fn calibration(document: &mut Document, model: &Model<'_>, ground: &Ground) -> Result<(), Error> {
    let before = Uncertainty::of(document)?;
    write(document, model, ground, before, ground.fit.state.effects.len())
}

/// Writes the constants of a fit, and the joint uncertainty of all that it moved; `before` is the earlier one.
fn write(
    document: &mut Document,
    model: &Model<'_>,
    ground: &Ground,
    before: Uncertainty,
    known: usize,
) -> Result<(), Error> {
    let as_it_came = document.clone();
    constants(document, model, &ground.fit);
    let stated = Document { model: document.model.clone(), ..as_it_came };
    let (joint, paths) = joint::adopted(&stated, model, ground, before, known)?;
    joint::state(document, &joint, &paths);
    document.calibration.get_or_insert_default().uncertainty = Some(joint);
    Ok(())
}

fn effects(document: &mut Document, outcome: &Outcome) {
    let listed = document.model.get_or_insert_default();
    let known = outcome.base.fit.state.effects.len();
    for (number, effect) in outcome.now.fit.state.effects.iter().enumerate() {
        let parameters = outcome.parameters[number].clone();
        if number < known {
            // What the document knew of it and is not fitted stays as it was.
            for (info, (name, quantity)) in effect.kind.parameters().iter().zip(parameters) {
                if info.role != Role::Epoch && quantity.std().is_some_and(|std| std > 0.0) {
                    listed.effects[number].parameters.insert(name, quantity);
                }
            }
            continue;
        }
        let coil = effect.kind.about().acts == Acts::OneCoil;
        listed.effects.push(AdoptedEffect {
            effect: effect.kind.name().into(),
            sensor: effect.axis.filter(|_| !coil),
            coil: effect.axis.filter(|_| coil),
            column: effect.column.clone(),
            recording: effect.recording.clone(),
            parameters,
            extra: [("found_by".to_string(), "diagnose".into())].into_iter().collect(),
            ..AdoptedEffect::default()
        });
    }
}

/// A quantity moved to where the fit has it, with the uncertainty that it had.
fn moved(old: Option<&Quantity>, value: f64) -> Quantity {
    old.and_then(Quantity::std).map_or(Quantity::Bare(value), |std| Quantity::new(value, std))
}

/// Moves the constants to where a fit has them.
fn constants(document: &mut Document, model: &Model<'_>, fit: &Fit) {
    let state = &fit.state;
    let mut turned = [false; 2];
    let calibration = document.calibration.get_or_insert_default();
    for (unknown, shift) in model.unknowns.iter().zip(&state.base).filter(|(_, shift)| **shift != 0.0) {
        match unknown {
            Unknown::Chain(Parameter::SensorTurn(..), _) => turned[0] = true,
            Unknown::Chain(Parameter::CoilTurn(..), _) => turned[1] = true,
            _ => {
                let Some(place) = moving_place(calibration, unknown) else { continue };
                let known = match unknown {
                    Unknown::Chain(Parameter::Sensitivity(axis), unit) => {
                        basic(model, *unit).map(|basic| basic.sensors[axis.index()].sensitivity)
                    }
                    _ => Some(place.as_ref().map_or(0.0, Quantity::value)),
                };
                *place = known.map(|known| moved(place.as_ref(), known + shift));
            }
        }
    }
    let (basic, _) = model.setting(state, 0);
    let axes: &mut AxesCalibration = calibration.axes.get_or_insert_default();
    for (turned, place, matrix) in
        [(turned[0], &mut axes.sensors, basic.mu), (turned[1], &mut axes.coils, basic.eta)]
    {
        if turned {
            // What else was stated of the old ones is not of these; keys that this version does not know stay.
            let extra = place.take().unwrap_or_default().extra;
            *place = Some(AxesDirections {
                matrix: Some(frames::rows(&matrix)),
                extra,
                ..AxesDirections::default()
            });
        }
    }
    if axes == &AxesCalibration::default() {
        calibration.axes = None;
    }
}

/// The chain of the readings in a unit, as it came.
fn basic<'m>(model: &'m Model<'_>, unit: Unit) -> Option<&'m physics::Basic> {
    let mut runs = model.observed.runs.iter();
    runs.find(|run| run.setting.context.unit == unit).map(|run| &run.setting.basic)
}
