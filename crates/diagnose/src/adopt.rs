//! The accepted effects in the document's model, and the calibration that goes with them.

use common::{AdoptedEffect, AxesCalibration, AxesDirections, Axis, Document, OneOrEach, PerAxis, Quantity};
use nalgebra::Matrix3;
use physics::{Acts, Parameter, Role, Unit, frames};

use crate::Outcome;
use crate::fit::Fit;
use crate::model::{Instrument, Model, Unknown};
use crate::reach;
use crate::report::effect_quantities;

/// Writes effects and calibration.
pub fn adopt(document: &mut Document, model: &Model<'_>, outcome: &Outcome) {
    effects(document, model, outcome);
    calibration(document, model, (&outcome.fit, outcome.last.rest.scale()));
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
            from_s: None,
            to_s: None,
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

/// Writes the calibration of a fit, with how much larger than the noise its residual is.
pub fn calibration(document: &mut Document, model: &Model<'_>, (fit, scale): (&Fit, f64)) {
    let state = &fit.state;
    // What the recordings do not determine keeps the uncertainty that is stated of it, or has none.
    let held = reach::undetermined(model, fit);
    let std = |number: usize| match held.contains(&number) {
        true => f64::NAN,
        false => (fit.covariance[(number, number)] * scale).sqrt(),
    };
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
        let known = &model.observed.runs[run].setting.basic;
        let axes: &mut AxesCalibration = calibration.axes.get_or_insert_default();
        for (turned, place, before, matrix, is_coil) in [
            (turned[0], &mut axes.sensors, &known.mu, basic.mu, false),
            (turned[1], &mut axes.coils, &known.eta, basic.eta, true),
        ] {
            if turned {
                // Keys that this version does not know stay.
                let extra = place.take().unwrap_or_default().extra;
                let found = directions(model, (fit, scale), [before, &matrix], is_coil);
                *place = Some(AxesDirections { extra, ..found });
            }
        }
        if axes == &AxesCalibration::default() {
            calibration.axes = None;
        }
    }
    together(document, model, (fit, scale));
    let calibration = document.calibration.get_or_insert_default();
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
        let offsets = Axis::ALL.map(offset).into_iter().collect::<PerAxis<Quantity>>();
        let extra = old.as_ref().map(|old| old.extra.clone()).unwrap_or_default();
        found.offset_nt = Some(PerAxis { extra, ..offsets });
    }
}

/// The axis and the number of an unknown turn of a sensor, or of a coil.
fn turn_of(unknown: &Unknown, coils: bool) -> Option<(Axis, usize)> {
    match unknown {
        Unknown::Chain(Parameter::CoilTurn(axis, which), Instrument::Read(_)) if coils => {
            Some((*axis, *which))
        }
        Unknown::Chain(Parameter::SensorTurn(axis, which), Instrument::Read(_)) if !coils => {
            Some((*axis, *which))
        }
        _ => None,
    }
}

/// Directions as the final fit has them, turned from those of `before`, with the covariance of the turns. What else was stated
/// of them was of the old ones.
fn directions(
    model: &Model<'_>,
    (fit, scale): (&Fit, f64),
    [before, after]: [&Matrix3<f64>; 2],
    coils: bool,
) -> AxesDirections {
    let turns: Vec<(usize, Axis, usize)> = (model.unknowns.iter().enumerate())
        .filter_map(|(number, unknown)| turn_of(unknown, coils).map(|(axis, which)| (number, axis, which)))
        .collect();
    let shift = |axis: Axis, which: usize| {
        let number = turns.iter().find(|(_, of, k)| (*of, *k) == (axis, which)).map(|(number, ..)| *number);
        number.map_or(0.0, |number| fit.state.base[number])
    };
    // How the nine cosines, column by column, move with each turn.
    let moved = turns.iter().map(|(number, axis, which)| {
        let direction = before.column(axis.index()).into_owned();
        let along = frames::turned_derivatives(&direction, [shift(*axis, 0), shift(*axis, 1)])[*which];
        let mut cosines = [0.0; 9];
        cosines[3 * axis.index()..][..3].copy_from_slice(along.as_slice());
        (*number, cosines)
    });
    let moved: Vec<(usize, [f64; 9])> = moved.collect();
    let element = |i: usize, j: usize| -> f64 {
        let pairs = moved.iter().flat_map(|a| moved.iter().map(move |b| (a, b)));
        pairs.map(|((a, da), (b, db))| da[i] * fit.covariance[(*a, *b)] * scale * db[j]).sum()
    };
    let all: Vec<Vec<f64>> = (0..9).map(|i| (0..9).map(|j| element(i, j)).collect()).collect();
    let held = reach::undetermined(model, fit);
    let known = all.iter().flatten().all(|value| value.is_finite())
        && turns.iter().all(|(number, ..)| !held.contains(number));
    let widest = |axis: Axis| {
        let own = Matrix3::from_fn(|r, s| all[3 * axis.index() + r][3 * axis.index() + s]);
        own.symmetric_eigenvalues().max().max(0.0).sqrt() / frames::ARCSEC
    };
    AxesDirections {
        matrix: Some(frames::rows(after)),
        std_arcsec: known
            .then(|| OneOrEach::Each(Axis::ALL.map(|axis| (axis, widest(axis))).into_iter().collect())),
        covariance_order: known.then(|| (0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect()),
        covariance: known.then_some(all),
        ..AxesDirections::default()
    }
}

/// The covariance of each sensor's k and O and of each coil's constant and offset, as the final fit has them.
fn together(document: &mut Document, model: &Model<'_>, (fit, scale): (&Fit, f64)) {
    let Some(calibration) = document.calibration.as_mut() else { return };
    for axis in Axis::ALL {
        if let Some(sensor) = calibration.sensors.as_mut().and_then(|sensors| sensors.entry(axis).as_mut()) {
            let keys = match (&sensor.sensitivity_nt_per_v, &sensor.sensitivity_nt_per_nt) {
                (Some(_), None) => Some(["sensitivity_nt_per_v", "offset_nt"]),
                (None, Some(_)) => Some(["sensitivity_nt_per_nt", "offset_nt"]),
                _ => None,
            };
            let both = [Parameter::Sensitivity(axis), Parameter::SensorOffset(axis)];
            let stated = (&mut sensor.covariance, &mut sensor.covariance_order);
            restate(model, (fit, scale), both, keys, stated);
        }
        if let Some(coil) = calibration.coils.as_mut().and_then(|coils| coils.entry(axis).as_mut()) {
            let both = [Parameter::CoilConstant(axis), Parameter::CoilOffset(axis)];
            let stated = (&mut coil.covariance, &mut coil.covariance_order);
            restate(model, (fit, scale), both, Some(["constant_nt_per_a", "offset_nt"]), stated);
        }
    }
}

/// Where the fit moved one of two constants, the covariance that was stated is of other values: theirs takes its place, or none where
/// the fit does not have both.
fn restate(
    model: &Model<'_>,
    (fit, scale): (&Fit, f64),
    both: [Parameter; 2],
    keys: Option<[&str; 2]>,
    (covariance, order): (&mut Option<Vec<Vec<f64>>>, &mut Option<Vec<String>>),
) {
    let place = |parameter: Parameter| {
        model.unknowns.iter().position(
            |unknown| matches!(unknown, Unknown::Chain(own, Instrument::Read(_)) if *own == parameter),
        )
    };
    let places = both.map(place);
    if places.iter().flatten().all(|number| fit.state.base[*number] == 0.0) {
        return;
    }
    (*covariance, *order) = (None, None);
    let ([Some(first), Some(second)], Some(keys)) = (places, keys) else { return };
    let places = [first, second];
    let held = reach::undetermined(model, fit);
    if places.iter().any(|number| held.contains(number)) {
        return;
    }
    let fitted = places.map(|a| places.map(|b| fit.covariance[(a, b)] * scale).to_vec()).to_vec();
    if fitted.iter().flatten().all(|value| value.is_finite()) {
        *covariance = Some(fitted);
        *order = Some(keys.map(str::to_string).to_vec());
    }
}

/// The chain of the readings in a unit, as it came.
fn basic<'m>(model: &'m Model<'_>, unit: Unit) -> Option<&'m physics::Basic> {
    let mut runs = model.observed.runs.iter().filter(|run| !run.differential());
    runs.find(|run| run.setting.context.unit == unit).map(|run| &run.setting.basic)
}
