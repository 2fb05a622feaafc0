//! `calibration.uncertainty`, from which every standard uncertainty of a statement of conformity comes.

use common::uncertainty::{self, Block};
use common::{
    AdoptedEffect, AxesCalibration, Axis, Calibration, Document, Error, PerAxis, Quantity, SensorCalibration,
    TemperatureFit, Uncertainty, covariance,
};
use estimate::stats;
use faer::{Mat, mat};
use std::collections::HashMap;

use crate::conformity::verdict::normal_std;

/// The sources of a document, with what stands beside values that no source moves: what was found and is not
/// in the model, and the covariances of documents without `calibration.uncertainty`.
pub struct Joint {
    sources: Uncertainty,
    /// From standard uncertainty to 95 % interval, where the sources do not say it.
    factors: HashMap<String, f64>,
}

impl Joint {
    /// Of a document; an error where a stated covariance can be none.
    pub fn of(document: &Document) -> Result<Self, Error> {
        let calibration = document.calibration.clone().unwrap_or_default();
        let mut sources = calibration.uncertainty.clone().unwrap_or_default();
        let mut factors = HashMap::new();
        for (block, factor) in beside(document, &calibration) {
            if block.parameters.iter().any(|path| sources.std(path) > 0.0) {
                continue;
            }
            factors.extend(block.parameters.iter().map(|path| (path.clone(), factor)));
            let expected = "a covariance with no entry larger than the product of two standard uncertainties";
            let name = block.name.clone();
            sources.put(block).map_err(|found| Error::document(name, found, expected))?;
        }
        let stated = Document {
            facility: document.facility.clone(),
            instrument: document.instrument.clone(),
            calibration: Some(Calibration { uncertainty: Some(sources), ..calibration }),
            model: document.model.clone(),
            ..Document::default()
        };
        Ok(Self { sources: Uncertainty::of(&stated)?, factors })
    }

    /// Covariance of parameters, each standard uncertainty that of the normal distribution with the same 95 %
    /// interval.
    pub fn covariance(&self, parameters: &[String]) -> Mat<f64> {
        let wider: Vec<f64> = parameters.iter().map(|path| normal_std(1.0, self.factor(path))).collect();
        let covariance = self.sources.covariance(parameters);
        Mat::from_fn(wider.len(), wider.len(), |i, j| covariance[(i, j)] * (wider[i] * wider[j]))
    }

    /// From a parameter's standard uncertainty to its 95 % interval; zero where nothing says it.
    pub fn factor(&self, path: &str) -> f64 {
        let freedom = self.sources.degrees_of_freedom(path);
        let own = self.factors.get(path).copied().unwrap_or(0.0);
        if freedom.is_finite() { stats::coverage_factor(0.95, freedom) } else { own }
    }
}

pub fn axes(document: &Document) -> Option<&AxesCalibration> {
    document.calibration.as_ref()?.axes.as_ref()
}

pub fn sensor(document: &Document, axis: Axis) -> Option<&SensorCalibration> {
    document.calibration.as_ref()?.sensor(axis)
}

/// k of a sensor, and the unit of its readings.
pub fn sensitivity(found: &SensorCalibration) -> Option<(&Quantity, &'static str)> {
    let volt = found.sensitivity_nt_per_v.as_ref().map(|k| (k, "v"));
    volt.or(found.sensitivity_nt_per_nt.as_ref().map(|k| (k, "nt")))
}

pub fn effect(name: &str, sensor: Axis, parameter: &str) -> String {
    let effect = AdoptedEffect { effect: name.into(), sensor: Some(sensor), ..AdoptedEffect::default() };
    uncertainty::effect(&effect, parameter)
}

/// The effect of a name that the model has on a sensor in all recordings.
pub fn adopted<'a>(document: &'a Document, name: &str, sensor: Axis) -> Option<&'a AdoptedEffect> {
    let mut effects = document.model.iter().flat_map(|model| &model.effects);
    effects
        .find(|effect| effect.effect == name && effect.sensor == Some(sensor) && effect.recording.is_none())
}

/// The path of an offset: what axescal adds to one has the uncertainty of the sum.
pub fn offset(document: &Document, sensor: Axis) -> String {
    match added_std(document, sensor) {
        Some(_) => uncertainty::added_offset(sensor),
        None => uncertainty::sensor_offset(sensor),
    }
}

fn added_std(document: &Document, sensor: Axis) -> Option<f64> {
    axes(document)?.offsets_nt.as_ref()?.get(sensor)?.std()
}

/// What stands beside the values, with the factor to 95 % intervals.
fn beside(document: &Document, calibration: &Calibration) -> Vec<(Block, f64)> {
    let sensors = calibration.sensors.iter().flat_map(PerAxis::iter).flat_map(|(axis, found)| {
        let across = across(document, axis, found);
        [constants(document, axis, found), temperatures(axis, found), across]
    });
    sensors.flatten().chain(directions(calibration)).collect()
}

fn block(name: String, parameters: Vec<String>, covariance: Mat<f64>) -> Block {
    Block { name, degrees_of_freedom: f64::INFINITY, parameters, covariance, by: Vec::new() }
}

/// k and O as sensorcal and axescal found them.
fn constants(document: &Document, sensor: Axis, found: &SensorCalibration) -> Option<(Block, f64)> {
    let (k, unit) = sensitivity(found)?;
    let added = added_std(document, sensor);
    let (k, o) = (k.std()?, added.or(found.offset_nt.as_ref()?.std())?);
    let place = |name: &str| found.covariance_order.as_ref()?.iter().position(|key| key == name);
    let entry = |i: usize, j: usize| found.covariance.as_ref()?.get(i)?.get(j).copied();
    let both = place(&format!("sensitivity_nt_per_{unit}")).zip(place("offset_nt"));
    let both = both.filter(|_| added.is_none()).and_then(|(i, j)| entry(i, j)).unwrap_or(0.0);
    let factors = [
        found.sensitivity.as_ref().map(|fit| fit.noise.coverage_factor_95),
        found.reversal.as_ref().map(|reversal| reversal.coverage_factor_95),
    ];
    let paths = vec![uncertainty::sensitivity(sensor, unit), offset(document, sensor)];
    let covariance = mat![[k * k, both], [both, o * o]];
    let name = format!("calibration.sensors.{sensor}.covariance");
    Some((block(name, paths, covariance), factors.into_iter().flatten().fold(0.0, f64::max)))
}

fn temperatures(sensor: Axis, found: &SensorCalibration) -> Option<(Block, f64)> {
    let fit = found.temperature.as_ref().filter(|fit| !fit.covariance_order.is_empty())?;
    let paths = temperature_paths(sensor, fit)?;
    let name = format!("calibration.sensors.{sensor}.temperature.covariance");
    Some((block(name, paths, covariance::matrix(&fit.covariance)), fit.noise.coverage_factor_95))
}

pub fn temperature_paths(sensor: Axis, fit: &TemperatureFit) -> Option<Vec<String>> {
    let names = fit.covariance_order.iter().map(|name| name.split_once('.'));
    names.map(|name| name.map(|(of, parameter)| effect(of, sensor, parameter))).collect()
}

/// The parameters of fields across. One that could not be seen, and that the model does not state, is zero,
/// give or take the largest that was.
fn across(document: &Document, sensor: Axis, found: &SensorCalibration) -> Option<(Block, f64)> {
    let fit = found.cross_field.as_ref()?;
    let modelled = |name: &str| {
        let mut effects = document.model.iter().flat_map(|model| &model.effects);
        effects.any(|effect| effect.effect == name && effect.sensor == Some(sensor))
    };
    let (mut paths, mut places, mut variances) = (Vec::new(), Vec::new(), Vec::new());
    for (group, name, parameter) in ACROSS {
        let place = fit.covariance_order.iter().position(|key| *key == format!("{group}.{parameter}"));
        let of = if group == "offset" { &fit.offset } else { &fit.sensitivity };
        if place.is_some() || !modelled(name) {
            paths.push(effect(name, sensor, parameter));
            places.push(place);
            variances.push(of.values().map(Quantity::value).map(|size| size * size).fold(0.0, f64::max));
        }
    }
    let entry = |a: usize, b: usize| match places[a].zip(places[b]) {
        Some((i, j)) => fit.covariance.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0),
        None => variances[a] * f64::from(u8::from(a == b)),
    };
    let covariance = Mat::from_fn(paths.len(), paths.len(), entry);
    let name = format!("calibration.sensors.{sensor}.cross_field.covariance");
    Some((block(name, paths, covariance), fit.noise.coverage_factor_95))
}

/// Fields across: the group in sensorcal's lists, the effect and its parameter, in the order of the
/// catalogue's shapes.
pub const ACROSS: [(&str, &str, &str); 5] = [
    ("offset", "cross_field", "first_nt"),
    ("offset", "cross_field", "second_nt"),
    ("offset", "cross_field", "mixed_nt"),
    ("sensitivity", "cross_field_sensitivity", "first_nt"),
    ("sensitivity", "cross_field_sensitivity", "second_nt"),
];

/// The directions of the sensors, where their covariance is whole; what is not is refused where stated
/// covariances are read.
fn directions(calibration: &Calibration) -> Option<(Block, f64)> {
    let axes = calibration.axes.as_ref()?;
    let sensors = axes.sensors.as_ref()?;
    let (given, order) = (sensors.covariance.as_ref()?, sensors.covariance_order.as_ref()?);
    let place = |k: usize| order.iter().position(|key| *key == format!("matrix[{}][{}]", k % 3, k / 3));
    let places = (0..9).map(place).collect::<Option<Vec<usize>>>()?;
    let row =
        |i: &usize| places.iter().map(|j| given.get(*i)?.get(*j).copied()).collect::<Option<Vec<f64>>>();
    let covariance = covariance::matrix(&places.iter().map(row).collect::<Option<Vec<_>>>()?);
    let block =
        block("calibration.axes.sensors.covariance".into(), uncertainty::directions("sensors"), covariance);
    Some((block, axes.fit.as_ref().map_or(0.0, |fit| fit.coverage_factor_95)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_degrees_of_freedom_are_as_good_as_infinite() {
        let text = |freedom: &str| {
            format!(
                r#"{{"fluxcal": 1, "calibration": {{"sensors": {{"x": {{"offset_nt": {{"value": 0, "std": 1}}}}}}, "uncertainty": {{"sources":
                [{{"name": "scatter", "degrees_of_freedom": {freedom}, "moves": {{"calibration.sensors.x.offset_nt": 1}}}}]}}}}}}"#
            )
        };
        for (freedom, factor) in [("10", 2.228_138_85), ("9e5", 1.959_963_98), ("1e7", 1.959_963_98)] {
            let joint = Joint::of(&Document::parse(&text(freedom)).expect("a document")).expect("sources");
            let found = joint.factor(&uncertainty::sensor_offset(Axis::X));
            assert!((found - factor).abs() < 1e-5, "{freedom}: {found}");
        }
    }
}
