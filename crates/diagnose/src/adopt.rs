//! The accepted effects in the document's model, and the calibration that goes with them.

use common::{AdoptedEffect, AxesCalibration, AxesDirections, Axis, Document, PerAxis, Quantity};
use nalgebra::Matrix3;
use physics::{Acts, EffectInstance, Parameter, Role, Unit, frames};

use crate::Outcome;
use crate::model::{Instrument, Model, Unknown};
use crate::report::effect_quantities;

/// Writes effects and calibration.
pub fn adopt(document: &mut Document, model: &Model<'_>, outcome: &Outcome) {
    effects(document, model, outcome);
    calibration(document, model, outcome);
}

fn effects(document: &mut Document, model: &Model<'_>, outcome: &Outcome) {
    let listed = document.model.get_or_insert_default();
    let known = outcome.base.state.effects.len();
    for (number, effect) in outcome.fit.state.effects.iter().enumerate() {
        let parameters = effect_quantities(model, outcome, number);
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
        });
    }
}

/// A quantity moved to where the fit has it; its uncertainty is the fit's where that determines it, else the one that it had, if any.
fn moved(old: Option<&Quantity>, value: f64, std: f64) -> Quantity {
    let fitted = Some(std).filter(|std| std.is_finite() && *std > 0.0);
    fitted
        .or_else(|| old.and_then(Quantity::std))
        .map_or(Quantity::Bare(value), |std| Quantity::new(value, std))
}

/// Writes the calibration of the final fit.
pub fn calibration(document: &mut Document, model: &Model<'_>, outcome: &Outcome) {
    let state = &outcome.fit.state;
    let scale = outcome.last.rest.scale();
    let std = |number: usize| (outcome.fit.covariance[(number, number)] * scale).sqrt();
    let mut turned = [false; 2];
    let mut pair = false;
    let calibration = document.calibration.get_or_insert_default();
    for (number, (unknown, shift)) in model.unknowns.iter().zip(&state.base).enumerate() {
        let std = std(number);
        if *shift == 0.0 {
            continue;
        }
        match unknown {
            Unknown::Chain(_, Instrument::Pair) => pair = true,
            Unknown::Chain(parameter, Instrument::Read(unit)) => match parameter {
                Parameter::Sensitivity(axis) => {
                    let known = basic(model, *unit).map(|basic| basic.sensors[axis.index()].sensitivity);
                    let sensor =
                        calibration.sensors.get_or_insert_default().entry(*axis).get_or_insert_default();
                    let place = match unit {
                        Unit::Volt => &mut sensor.sensitivity_nt_per_v,
                        Unit::Nanotesla => &mut sensor.sensitivity_nt_per_nt,
                    };
                    *place = known.map(|known| moved(place.as_ref(), known + shift, std));
                }
                Parameter::SensorOffset(axis) => {
                    let sensor =
                        calibration.sensors.get_or_insert_default().entry(*axis).get_or_insert_default();
                    let known = sensor.offset_nt.as_ref().map_or(0.0, Quantity::value);
                    sensor.offset_nt = Some(moved(sensor.offset_nt.as_ref(), known + shift, std));
                }
                Parameter::CoilConstant(axis) => {
                    let coil = calibration.coils.get_or_insert_default().entry(*axis).get_or_insert_default();
                    let known = coil.constant_nt_per_a.as_ref().map_or(0.0, Quantity::value);
                    coil.constant_nt_per_a = Some(moved(coil.constant_nt_per_a.as_ref(), known + shift, std));
                }
                Parameter::CoilOffset(axis) => {
                    let coil = calibration.coils.get_or_insert_default().entry(*axis).get_or_insert_default();
                    let known = coil.offset_nt.as_ref().map_or(0.0, Quantity::value);
                    coil.offset_nt = Some(moved(coil.offset_nt.as_ref(), known + shift, std));
                }
                Parameter::SensorTurn(..) => turned[0] = true,
                Parameter::CoilTurn(..) => turned[1] = true,
                Parameter::Effect(..) => {}
            },
            Unknown::Field(axis) => {
                let axes = calibration.axes.get_or_insert_default();
                let place = axes.residual_field_nt.get_or_insert_default().entry(*axis);
                let known = place.as_ref().map_or(0.0, Quantity::value);
                *place = Some(moved(place.as_ref(), known + shift, std));
            }
            Unknown::Level(_) | Unknown::Turn { .. } => {}
        }
    }
    let fitted = (0..model.observed.runs.len()).find(|run| !model.observed.runs[*run].differential());
    if let Some(run) = fitted {
        let (basic, _) = model.setting(state, run);
        let axes: &mut AxesCalibration = calibration.axes.get_or_insert_default();
        for (turned, place, matrix) in
            [(turned[0], &mut axes.sensors, basic.mu), (turned[1], &mut axes.coils, basic.eta)]
        {
            if turned {
                let place: &mut AxesDirections = place.get_or_insert_default();
                place.matrix = Some(frames::rows(&matrix));
            }
        }
        if axes == &AxesCalibration::default() {
            calibration.axes = None;
        }
    }
    let differential = (0..model.observed.runs.len()).find(|run| model.observed.runs[*run].differential());
    if let Some(run) = differential.filter(|_| pair) {
        let (basic, _) = model.setting(state, run);
        let found = calibration.differential.get_or_insert_default();
        let k = basic.sensors.map(|sensor| sensor.sensitivity);
        found.matrix = Some(frames::rows(&Matrix3::from_fn(|i, j| basic.mu[(i, j)] / k[j])));
        let old = found.offset_nt.take();
        let offset = |axis: Axis| {
            let old = old.as_ref().and_then(|old| old.get(axis));
            (axis, moved(old, -basic.sensors[axis.index()].offset_nt / k[axis.index()], f64::NAN))
        };
        found.offset_nt = Some(Axis::ALL.map(offset).into_iter().collect::<PerAxis<Quantity>>());
    }
}

/// The chain of the readings in a unit, as it came.
fn basic<'m>(model: &'m Model<'_>, unit: Unit) -> Option<&'m physics::Basic> {
    let mut runs = model.observed.runs.iter().filter(|run| !run.differential());
    runs.find(|run| run.setting.context.unit == unit).map(|run| &run.setting.basic)
}

/// Whether an effect acts on coils.
pub fn on_coil(effect: &EffectInstance) -> bool {
    effect.kind.about().acts == Acts::OneCoil
}
