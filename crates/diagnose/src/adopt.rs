//! The accepted effects in the document's model, and the calibration that goes with them.

use common::{AdoptedEffect, AxesCalibration, AxesDirections, Document, Quantity, Uncertainty};
use indexmap::IndexMap;
use physics::{Acts, Parameter, Role, Unit, frames};

use crate::fit::Fit;
use crate::joint;
use crate::level::Rest;
use crate::model::{Model, Unknown};

use crate::{Error, Outcome};

/// Writes effects and calibration; gives the parameters of the effects as they are written.
pub fn adopt(
    document: &mut Document,
    model: &Model<'_>,
    outcome: &Outcome,
) -> Result<Vec<IndexMap<String, Quantity>>, Error> {
    let before = Uncertainty::of(document)?;
    effects(document, outcome);
    let known = outcome.base.state.effects.len();
    write(document, model, (&outcome.fit, &outcome.last.rest), before, known)?;
    let listed = document.model.iter().flat_map(|model| &model.effects);
    Ok(listed.map(|effect| effect.parameters.clone()).collect())
}

/// Writes the calibration of a fit without effects.
pub fn calibration(document: &mut Document, model: &Model<'_>, fit: (&Fit, &Rest)) -> Result<(), Error> {
    let before = Uncertainty::of(document)?;
    let known = fit.0.state.effects.len();
    write(document, model, fit, before, known)
}

/// Writes the constants of a fit, and the joint uncertainty of all that it moved; `before` is that of the
/// document as it came.
fn write(
    document: &mut Document,
    model: &Model<'_>,
    (fit, rest): (&Fit, &Rest),
    before: Uncertainty,
    known: usize,
) -> Result<(), Error> {
    let as_it_came = document.clone();
    constants(document, model, fit);
    let stated = Document { model: document.model.clone(), ..as_it_came };
    let (joint, paths) = joint::adopted(&stated, model, (fit, rest), before, known)?;
    joint::state(document, &joint, &paths);
    document.calibration.get_or_insert_default().uncertainty = Some(joint);
    Ok(())
}

fn effects(document: &mut Document, outcome: &Outcome) {
    let listed = document.model.get_or_insert_default();
    let known = outcome.base.state.effects.len();
    for (number, effect) in outcome.fit.state.effects.iter().enumerate() {
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
    for (unknown, shift) in model.unknowns.iter().zip(&state.base) {
        if *shift == 0.0 {
            continue;
        }
        match unknown {
            Unknown::Chain(parameter, unit) => match parameter {
                Parameter::Sensitivity(axis) => {
                    let known = basic(model, *unit).map(|basic| basic.sensors[axis.index()].sensitivity);
                    let sensor =
                        calibration.sensors.get_or_insert_default().entry(*axis).get_or_insert_default();
                    let place = match unit {
                        Unit::Volt => &mut sensor.sensitivity_nt_per_v,
                        Unit::Nanotesla => &mut sensor.sensitivity_nt_per_nt,
                    };
                    *place = known.map(|known| moved(place.as_ref(), known + shift));
                }
                Parameter::SensorOffset(axis) => {
                    // What axescal found is to be added has the uncertainty of the sum, and moves for it.
                    let added = calibration.axes.as_mut().and_then(|axes| axes.offsets_nt.as_mut());
                    let added = added.and_then(|added| added.entry(*axis).as_mut());
                    let place = match added.filter(|added| added.std().is_some()) {
                        Some(added) => added,
                        None => {
                            let sensors = calibration.sensors.get_or_insert_default();
                            sensors.entry(*axis).get_or_insert_default().offset_nt.get_or_insert_default()
                        }
                    };
                    *place = moved(Some(place), place.value() + shift);
                }
                Parameter::CoilConstant(axis) => {
                    let coil = calibration.coils.get_or_insert_default().entry(*axis).get_or_insert_default();
                    let known = coil.constant_nt_per_a.as_ref().map_or(0.0, Quantity::value);
                    coil.constant_nt_per_a = Some(moved(coil.constant_nt_per_a.as_ref(), known + shift));
                }
                Parameter::CoilOffset(axis) => {
                    let coil = calibration.coils.get_or_insert_default().entry(*axis).get_or_insert_default();
                    let known = coil.offset_nt.as_ref().map_or(0.0, Quantity::value);
                    coil.offset_nt = Some(moved(coil.offset_nt.as_ref(), known + shift));
                }
                Parameter::SensorTurn(..) => turned[0] = true,
                Parameter::CoilTurn(..) => turned[1] = true,
                Parameter::Effect(..) => {}
            },
            Unknown::Field(axis) => {
                let axes = calibration.axes.get_or_insert_default();
                let place = axes.residual_field_nt.get_or_insert_default().entry(*axis);
                let known = place.as_ref().map_or(0.0, Quantity::value);
                *place = Some(moved(place.as_ref(), known + shift));
            }
            Unknown::Level(_) | Unknown::Turn { .. } => {}
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
