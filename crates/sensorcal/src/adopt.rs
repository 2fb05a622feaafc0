//! What was found, as effects of the catalogue in the document's model.

use common::{AdoptedEffect, Axis, CrossFieldFit, Document, Quantity, SensorCalibration, uncertainty};
use indexmap::IndexMap;
use physics::Kind;

use crate::SensorFindings;
use crate::departure::FOUND_BELOW;
use crate::effects;

/// Who put an effect into the model: on a second run it is replaced.
const FOUND_BY: (&str, &str) = ("found_by", "sensorcal");

/// Puts the effects of temperature, the nonlinearity and the effect of fields across into `model.effects`, in
/// place of what an earlier run put there for this sensor, or of what was stated of the same effects.
pub fn adopt(document: &mut Document, sensor: Axis, found: &SensorFindings) {
    let mut effects: Vec<AdoptedEffect> = Vec::new();
    if found.calibration.temperature.is_some() {
        let mut at = 0;
        for effect in &found.conditions.effects {
            let parameters = effect.kind.parameters().iter().zip(&effect.parameters).enumerate();
            let quantities = parameters
                .map(|(number, (info, value))| {
                    let variance = found.conditions.covariance[(at + number, at + number)];
                    (info.name.to_string(), Quantity::new(*value, variance.sqrt()))
                })
                .collect();
            at += effect.parameters.len();
            effects.push(one(effect.kind, sensor, quantities));
        }
    }
    for (kind, size) in found.constants.iter().flat_map(|constants| &constants.nonlinearity) {
        let parameter = kind.parameters()[0].name.to_string();
        effects.push(one(*kind, sensor, [(parameter, size.clone())].into_iter().collect()));
    }
    if let (Some(cross), Some(of_cross)) = (&found.calibration.cross_field, &found.across)
        && across_matters(&found.calibration)
    {
        effects.extend(across(cross, sensor, of_cross.likely));
    }
    let mine =
        |effect: &AdoptedEffect| effect.extra.get(FOUND_BY.0).and_then(|by| by.as_str()) == Some(FOUND_BY.1);
    let anew: Vec<String> = effects.iter().map(|effect| effect.effect.clone()).collect();
    let earlier = |effect: &AdoptedEffect| {
        effect.sensor == Some(sensor)
            && effect.recording.is_none()
            && (mine(effect) || anew.contains(&effect.effect))
    };
    if effects.is_empty() && document.model.is_none() {
        return;
    }
    let model = document.model.get_or_insert_default();
    model.effects.retain(|effect| !earlier(effect));
    model.effects.extend(effects);
}

pub fn one(kind: Kind, sensor: Axis, parameters: IndexMap<String, Quantity>) -> AdoptedEffect {
    let extra = [(FOUND_BY.0.to_string(), FOUND_BY.1.into())].into_iter().collect();
    AdoptedEffect {
        effect: kind.name().into(),
        sensor: Some(sensor),
        parameters,
        extra,
        ..AdoptedEffect::default()
    }
}

pub fn path(kind: Kind, sensor: Axis, parameter: &str) -> String {
    uncertainty::effect(&one(kind, sensor, IndexMap::new()), parameter)
}

pub fn across_matters(calibration: &SensorCalibration) -> bool {
    let test = calibration.cross_field.as_ref().and_then(|cross| cross.significance);
    test.is_some_and(|test| test.p_value < FOUND_BELOW)
}

/// The effects of fields across; one not seen is zero, give or take what the others make likely.
fn across(cross: &CrossFieldFit, sensor: Axis, likely: [f64; 2]) -> Vec<AdoptedEffect> {
    let [offset, sensitivity] = effects::KINDS;
    let both = [(offset, &cross.offset, likely[0]), (sensitivity, &cross.sensitivity, likely[1])];
    let found = both.into_iter().filter(|(_, found, _)| !found.is_empty());
    let effect = |(kind, found, likely): (Kind, &IndexMap<String, Quantity>, f64)| {
        let all = kind.parameters().iter();
        let value = |name: &str| found.get(name).cloned().unwrap_or(Quantity::new(0.0, likely));
        one(kind, sensor, all.map(|info| (info.name.to_string(), value(info.name))).collect())
    };
    found.map(effect).collect()
}
