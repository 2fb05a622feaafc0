//! Findings of coilcal and sensorcal.

use common::{
    CoilCalibration, CrossFieldFit, OffsetDrift, Quantity, ReversalOffset, SensitivityFit, SensorCalibration,
    TemperatureFit,
};

use super::{LEFT_OUT, NOT_SHOWN, NOT_SIGNIFICANT, Rule, UNCERTAINTY, UNDECIDED, departure, largest};
use crate::{Effect, number};

const DAYS_PER_YEAR: f64 = 365.25;

/// What a coil's findings do.
pub const COIL: [Rule<CoilCalibration>; 4] = [
    ("not a straight line: ", |coil, _| off_the_line(coil)),
    ("would explain the readings about as well", |_, _| UNDECIDED),
    ("the levels scatter more than repeated readings", |coil, _| {
        Effect::nt(coil.constant.as_ref().map(|fit| fit.rms_nt))
    }),
    ("the current was recorded in one direction only", |_, _| NOT_SHOWN),
];

/// What findings on the sensitivity do.
pub const SENSITIVITY: [Rule<SensorCalibration>; 9] = [
    ("not a straight line: ", |sensor, _| Effect::nt(sensor.sensitivity.as_deref().and_then(bend))),
    ("would explain the readings about as well", |_, _| UNDECIDED),
    ("a term of order ", |sensor, words| {
        Effect::nt(sensor.sensitivity.as_deref().and_then(|fit| term(fit, words)))
    }),
    ("the output is saturated ", |_, _| LEFT_OUT),
    ("the residuals are not normal", |_, _| UNCERTAINTY),
    ("the residuals are serially correlated", |_, _| UNCERTAINTY),
    ("times as much as the sensor's own noise", |_, _| UNCERTAINTY),
    ("they disagree", |sensor, _| Effect::nt(apart(sensor))),
    ("no temperatures were recorded in", |_, _| NOT_SHOWN),
];

/// What findings on the offset by turning do.
pub const REVERSAL: [Rule<ReversalOffset>; 2] = [
    ("and left out", |reversal, words| Effect::nt(unlike(reversal, words))),
    ("the recordings differ by more than their scatter", |reversal, _| {
        let mean = reversal.offset_nt.value();
        Effect::nt(largest(reversal.recordings.iter().map(|one| one.offset_nt.value() - mean)))
    }),
];

/// What findings on the drift do.
pub const DRIFT: [Rule<OffsetDrift>; 6] = [
    ("under correlated noise", |drift, words| {
        let significant = words.starts_with("the trend is significant");
        if significant { Effect::nt(over_the_dates(drift)) } else { NOT_SIGNIFICANT }
    }),
    ("the dates neither establish nor exclude", |_, _| UNCERTAINTY),
    ("a yearly term of ", |drift, _| Effect::nt(drift.annual.as_ref().map(|annual| annual.amplitude_nt))),
    ("the offset follows the sensor's temperature", |drift, _| Effect::nt(by_temperature(drift))),
    ("no trend: at least five are needed", |_, _| NOT_SHOWN),
    ("corrected to the reference temperatures", |_, _| Effect::NOT_HELD),
];

/// What findings on the noise do.
pub const NOISE: [Rule<()>; 5] = [
    ("the noise measured at its highest frequencies", |_, _| UNCERTAINTY),
    ("the spectrum is not of the form A/f^α plus white noise", |_, _| UNCERTAINTY),
    ("the exponent is at the limit of its range", |_, _| UNCERTAINTY),
    ("no flicker noise was detected", |_, _| UNCERTAINTY),
    ("its white noise is underestimated", |_, _| UNCERTAINTY),
];

/// What findings on temperatures do.
pub const TEMPERATURE: [Rule<TemperatureFit>; 2] = [
    ("besides the polynomials, the readings show ", |fit, words| departure(&fit.departures, words)),
    ("varied together", |_, _| NOT_SHOWN),
];

/// What findings on fields across do.
pub const CROSS_FIELD: [Rule<CrossFieldFit>; 5] = [
    ("cannot be determined", |_, _| NOT_SHOWN),
    ("do not affect sensor ", |_, _| NOT_SIGNIFICANT),
    ("transverse fields affect sensor ", |fit, _| Effect::nt(coefficient(fit))),
    ("k also depends on the square of the transverse field", |fit, _| {
        let found = fit.departures.iter().filter(|one| one.found).flat_map(|one| one.parameter.values());
        Effect::std(largest(found.filter_map(|value| Some(value.value() / value.std()?))))
    }),
    ("no temperatures were recorded in", |_, _| NOT_SHOWN),
];

/// What is fitted beside constant and offset: the largest distance of the fitted field from their line, among
/// the levels.
fn off_the_line(coil: &CoilCalibration) -> Effect {
    let constants = coil.constant_nt_per_a.as_ref().zip(coil.offset_nt.as_ref());
    let Some((fit, (k, offset))) = coil.constant.as_ref().zip(constants) else { return Effect::NOT_HELD };
    let residuals = &fit.residuals;
    let levels = residuals.drive_a.iter().zip(residuals.field_nt.iter().zip(&residuals.residual_nt));
    let line = |drive: f64| k.value() * drive + offset.value();
    Effect::nt(largest(levels.map(|(drive, (field, residual))| field - residual - line(*drive))))
}

/// What fitting a departure changes at the readings, at most.
fn bend(fit: &SensitivityFit) -> Option<f64> {
    let residuals = &fit.residuals;
    largest(residuals.deviation_nt.iter().zip(&residuals.residual_nt).map(|(line, all)| line - all))
}

/// The rms of what the polynomial's highest term adds.
fn term(fit: &SensitivityFit, words: &str) -> Option<f64> {
    let named = |order: usize| words.starts_with(&format!("a term of order {order} "));
    let pair = fit.orders.windows(2).find(|pair| named(pair[1].order))?;
    Some((pair[0].rms_nt.powi(2) - pair[1].rms_nt.powi(2)).max(0.0).sqrt())
}

/// The offset in the coil less that by reversals.
fn apart(sensor: &SensorCalibration) -> Option<f64> {
    let (coil, turned) = (sensor.sensitivity.as_ref()?, sensor.reversal.as_ref()?);
    Some(coil.offset_nt.value() - turned.offset_nt.value())
}

/// What the pairs that were left out would move the mean of their recording by.
fn unlike(reversal: &ReversalOffset, words: &str) -> Option<f64> {
    let named = |recording: &str| words.contains(&format!("recording \"{recording}\""));
    let pairs = &reversal.recordings.iter().find(|one| named(&one.recording))?.pairs;
    let used = pairs.offset_nt.iter().zip(&pairs.used).filter(|(_, used)| **used).map(|(offset, _)| *offset);
    Some(mean(pairs.offset_nt.iter().copied())? - mean(used)?)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let all: Vec<f64> = values.collect();
    (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
}

fn over_the_dates(drift: &OffsetDrift) -> Option<f64> {
    let [first, last] = number::ends(drift.dates.time_d.iter().copied())?;
    Some(drift.trend_nt_per_year.as_ref()?.value() * (last - first) / DAYS_PER_YEAR)
}

fn by_temperature(drift: &OffsetDrift) -> Option<f64> {
    let [low, high] = number::ends(drift.dates.sensor_temperature_c.iter().copied())?;
    Some(drift.temperature_nt_per_k.as_ref()?.value() * (high - low))
}

/// The largest coefficient, at 50 000 nT across.
fn coefficient(fit: &CrossFieldFit) -> Option<f64> {
    largest(fit.offset.values().chain(fit.sensitivity.values()).map(Quantity::value))
}
