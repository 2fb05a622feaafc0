//! Each sensor by itself (NASA, "Calibration of Individual Sensors"): sensitivity and nonlinearity, offset by
//! reversals, noise, offset drift, temperature, fields across.
//!
//! B = k V + O along the sensor's own axis. Predictions and derivatives are those of `physics`; what is found
//! of temperatures, nonlinearity and fields across goes to `model.effects` under the catalogue's names, so
//! that it can be simulated and corrected. Uncertainties from scatter (type A) rest on the noise as it was
//! measured, declared, or left by the fit, with its memory; those of the coil's constant and of the
//! temperature coefficients (type B) are common to all readings.
//!
//! All fits are one mechanism (`fit`). The unknowns are parameters of `physics`, each own to a recording or
//! common to all, and columns. Residuals and derivatives come from `predict_with_jacobian`;
//! `estimate::correlated` makes the steps under the covariance that `noise::covariance` gives for exactly the
//! process from which `noise::series` draws. Where the noise is not known, the allowed covariances are
//! averaged by restricted likelihood, and `estimate::mixture` makes one interval of them by its quantiles.
//! What is known with an uncertainty (a coil constant, a coefficient) moves the unknowns through the same
//! derivatives. `drift` fits the dates' offsets, `wander` their noise.

mod adopt;
mod allowed;
mod budget;
mod combine;
mod conditions;
mod cross_field;
mod departure;
mod drift;
mod effects;
mod fit;
mod heated;
mod leaning;
mod levels;
mod noise;
mod passes;
mod readings;
mod reversal;
mod saturation;
mod sensitivity;
mod shape;
mod sides;
mod sizes;
mod temperature;
mod wander;
mod words;

pub use common::Error;
pub use words::summary;

use clap::Args;
use common::uncertainty;
use common::{Axis, Document, Quantity, SensorCalibration, Uncertainty, procedure};
use faer::Mat;
use physics::{References, Unit};
use program::number;
use rayon::prelude::*;

use crate::conditions::Conditions;
use crate::cross_field::AcrossFindings;
use crate::reversal::Turned;
use crate::sensitivity::Constants;
use crate::shape::Subject;
use crate::sides::Sides;

type Result<T, E = Error> = std::result::Result<T, E>;

/// What is asked of sensorcal.
#[derive(Args, Clone, Debug, PartialEq)]
pub struct Options {
    /// How far the turn of a reversal may miss 180°, deg
    #[arg(long, value_name = "DEG", default_value_t = 3.0, value_parser = number::not_negative)]
    pub turn_deg: f64,
    /// How far axes may be from nominal where the document does not give them (standard deviation), deg
    #[arg(long, value_name = "DEG", default_value_t = 3.0, value_parser = number::not_negative)]
    pub axes_std_deg: f64,
    /// Fields along the sensor for the error budget, nT [default: zero, half and all of what was applied]
    #[arg(long, value_name = "NT", value_delimiter = ',', value_parser = number::finite)]
    pub budget_field_nt: Vec<f64>,
    /// Temperatures less the reference for the error budget, K [default: 0, and 10 where coefficients are known]
    #[arg(long, value_name = "K", value_delimiter = ',', value_parser = number::finite)]
    pub budget_warmer_k: Vec<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { turn_deg: 3.0, axes_std_deg: 3.0, budget_field_nt: Vec::new(), budget_warmer_k: Vec::new() }
    }
}

impl Options {
    /// What the history records of the request.
    pub fn arguments(&self) -> Vec<String> {
        let degrees = [("turn-deg", self.turn_deg), ("axes-std-deg", self.axes_std_deg)];
        let lists = [("budget-field-nt", &self.budget_field_nt), ("budget-warmer-k", &self.budget_warmer_k)];
        let listed = lists.into_iter().filter(|(_, values)| !values.is_empty()).map(|(name, values)| {
            let values: Vec<String> = values.iter().map(f64::to_string).collect();
            format!("--{name}={}", values.join(","))
        });
        degrees.map(|(name, deg)| format!("--{name}={deg}")).into_iter().chain(listed).collect()
    }
}

/// The procedures that are read here.
pub const PROCEDURES: [&str; 6] = [
    procedure::SENSOR_SENSITIVITY,
    procedure::SENSOR_OFFSET_REVERSAL,
    procedure::SENSOR_NOISE,
    procedure::OFFSET_DRIFT,
    procedure::TEMPERATURE_RUN,
    procedure::CROSS_FIELD,
];

struct SensorFindings {
    calibration: SensorCalibration,
    conditions: Conditions,
    constants: Option<Constants>,
    turned: Option<Turned>,
    across: Option<AcrossFindings>,
}

/// Where no recording is for this stage.
const NOTHING: &str = "no recording with the procedure `sensor_sensitivity`, `sensor_offset_reversal`, `sensor_noise`, `offset_drift`, `temperature_run` or `cross_field`; sensorcal needs readings of a sensor in a coil's field or in a shield";

/// Finds what the recordings show of each sensor and writes it to `calibration.sensors`, the effects to
/// `model.effects`; a sensor without a recording of a kind keeps what the document says of it.
pub fn run(mut document: Document, options: &Options) -> Result<Document> {
    if !document.recordings.iter().any(|recording| PROCEDURES.contains(&recording.procedure.as_str())) {
        return Err(Error::Request(NOTHING.into()));
    }
    let sides = Sides::of(&document, options.axes_std_deg);
    let references = References::of(&document);
    let found = Axis::ALL.par_iter().map(|sensor| one((&document, references), *sensor, &sides));
    let mut found: Vec<SensorFindings> = found.collect::<Result<_>>()?;
    in_passes((&document, references), &mut found, &sides)?;
    let shield: Vec<Option<f64>> = found.iter().map(|found| shield(&found.calibration)).collect();
    let mut joint = Uncertainty::of(&document)?;
    for (sensor, mut found) in Axis::ALL.into_iter().zip(found) {
        if found.calibration == SensorCalibration::default() {
            continue;
        }
        if let Some(reversal) = &mut found.calibration.reversal {
            let [one, other] = [1, 2].map(|step| shield[(sensor.index() + step) % 3]);
            let across_nt = one.zip(other).map(|(one, other)| one.hypot(other));
            reversal.imperfect_turn = reversal::imperfect(&reversal.recordings, options.turn_deg, across_nt);
        }
        adopt::adopt(&mut document, sensor, &found);
        if let Some(block) = found.conditions.block.take() {
            joint.put(block).map_err(Error::Unanswerable)?;
        }
        if let Some(across) = found.across.take().filter(|_| adopt::across_matters(&found.calibration)) {
            joint.put(across.block).map_err(Error::Unanswerable)?;
        }
        let sensors = document.calibration.get_or_insert_default().sensors.get_or_insert_default();
        let entry = sensors.entry(sensor).get_or_insert_default();
        let (constants, conditions) = (found.constants.as_ref(), &found.conditions);
        let offsets = (constants, found.turned.as_ref());
        combine::into(entry, found.calibration, offsets, conditions, (sensor, &mut joint))?;
        if let Some(constants) = constants {
            entry.budget = budget::budget(entry, constants, conditions, options);
        }
    }
    physics::state_references(&mut document, &references);
    if let Some(calibration) = &mut document.calibration {
        calibration.common_extrema =
            calibration.sensors.as_ref().map(temperature::common_extrema).unwrap_or_default();
    }
    state(&mut document, &joint);
    document.calibration.get_or_insert_default().uncertainty = Some(joint);
    // With what is stated of fields across that were not seen.
    let joint = Uncertainty::of(&document)?;
    let kept = (!joint.sources.is_empty()).then_some(joint);
    document.calibration.get_or_insert_default().uncertainty = kept;
    Ok(document)
}

/// Scores the correction for fields across in two passes where all three sensors were read.
fn in_passes(
    (document, references): (&Document, References),
    found: &mut [SensorFindings],
    sides: &Sides,
) -> Result<()> {
    let mut across = found.iter().filter_map(|found| found.across.as_ref());
    if across.all(|across| across.left_out.is_empty()) {
        return Ok(());
    }
    let mu = sides.solve(&[])?.mu;
    for sensor in Axis::ALL {
        let runs = readings::runs(document, references, procedure::CROSS_FIELD, sensor).unwrap_or_default();
        let Some(unit) = runs.first().map(|run| run.context.unit) else { continue };
        let sensors = Axis::ALL.map(|axis| {
            let SensorFindings { constants, calibration, .. } = &found[axis.index()];
            passes::corrected(document, (axis, unit), constants.as_ref(), calibration.cross_field.as_deref())
        });
        let of = &mut found[sensor.index()];
        let Some(across) = &of.across else { continue };
        let passes = passes::score(&runs, sensor, &across.left_out, (&sensors, &mu));
        let held_out = of.calibration.cross_field.as_mut().and_then(|fit| fit.held_out.as_mut());
        if let (Some([first, second]), Some(held_out)) = (passes, held_out) {
            (held_out.first_pass_nt, held_out.second_pass_nt) = (Some(first), Some(second));
        }
    }
    Ok(())
}

/// Gives the effects that were found the uncertainties that the sources say.
fn state(document: &mut Document, joint: &Uncertainty) {
    for effect in document.model.iter_mut().flat_map(|model| &mut model.effects) {
        let paths: Vec<String> =
            effect.parameters.keys().map(|name| uncertainty::effect(effect, name)).collect();
        for (quantity, path) in effect.parameters.values_mut().zip(paths) {
            if joint.std(&path) > 0.0 {
                *quantity = combine::quantity(joint, &path, quantity.value());
            }
        }
    }
}

/// Field of the shield along a sensor, nT: the largest of all its recordings.
fn shield(calibration: &SensorCalibration) -> Option<f64> {
    let recordings = calibration.reversal.as_ref()?.recordings.iter();
    recordings.map(|reversal| reversal.shield_field_nt.value().abs()).reduce(f64::max)
}

fn one(
    (document, references): (&Document, References),
    sensor: Axis,
    sides: &Sides,
) -> Result<SensorFindings> {
    let first = |unit: Unit| first_sensitivity((document, references), sensor, unit);
    let noise = noise::analyse(document, sensor, &first)?;
    let of = Subject { document, references, sensor, measured: noise.as_ref() };
    let (temperature, conditions) = match temperature::coefficients(of)? {
        Some((fit, conditions)) => (Some(fit), conditions),
        None => (None, stated(document, sensor)?),
    };
    let constants = sensitivity::calibrate(of, &conditions)?;
    let k = |unit: Unit| match &constants {
        Some(found) if found.unit == unit => Some((found.sensitivity, found.covariance[0][0].sqrt())),
        _ => first(unit),
    };
    let (reversal, turned) = reversal::offset(of, &k, &conditions)?.unzip();
    let drift = drift::drift(of, &k, &conditions)?;
    let (cross_field, across) = cross_field::coefficients(of, &conditions, sides)?.unzip();
    let calibration = SensorCalibration {
        sensitivity: constants.as_ref().map(|found| Box::new(found.fit.clone())),
        reversal: reversal.map(Box::new),
        noise: noise.map(Box::new),
        drift: drift.map(Box::new),
        temperature: temperature.map(Box::new),
        cross_field: cross_field.map(Box::new),
        ..SensorCalibration::default()
    };
    Ok(SensorFindings { calibration, conditions, constants, turned, across })
}

/// The sensitivity as it is known before the fits, with its standard uncertainty: from straight lines through
/// the recordings in a coil, else as the document states it, else nominal.
fn first_sensitivity(
    (document, references): (&Document, References),
    sensor: Axis,
    unit: Unit,
) -> Option<(f64, f64)> {
    let runs =
        readings::runs(document, references, procedure::SENSOR_SENSITIVITY, sensor).unwrap_or_default();
    if runs.first().is_some_and(|run| run.context.unit == unit) {
        return Some((readings::first_sensitivity(&runs), 0.0));
    }
    let stated = document.calibration.as_ref().and_then(|c| c.sensor(sensor));
    if let Some(quantity) = stated.and_then(|stated| physics::sensitivity(stated, unit)) {
        return Some((quantity.value(), quantity.std().unwrap_or(0.0)));
    }
    match unit {
        Unit::Nanotesla => Some((1.0, 0.0)),
        Unit::Volt => document.instrument.as_ref()?.nominal_sensitivity_nt_per_v.map(|k| (k, 0.0)),
    }
}

/// What the document's model says of temperatures, where no recording does.
fn stated(document: &Document, sensor: Axis) -> Result<Conditions> {
    let adopted = physics::adopt(document).map_err(|error| error.at("model"))?;
    let kinds = heated::KINDS.concat().concat();
    let mut conditions = Conditions::none();
    let mut variances = Vec::new();
    let listed = document.model.iter().flat_map(|model| &model.effects);
    for (instance, stated) in adopted.into_iter().zip(listed) {
        if instance.axis != Some(sensor) || instance.recording.is_some() || !kinds.contains(&instance.kind) {
            continue;
        }
        for info in instance.kind.parameters() {
            let std = stated.parameters.get(info.name).and_then(Quantity::std).unwrap_or(0.0);
            variances.push(std * std);
            conditions.paths.push(uncertainty::effect(stated, info.name));
        }
        conditions.effects.push(instance);
    }
    let count = variances.len();
    conditions.covariance = Mat::from_fn(count, count, |i, j| if i == j { variances[i] } else { 0.0 });
    Ok(conditions)
}
