//! Findings of coilcal and sensorcal.

use common::{
    Code, CoilCalibration, CrossFieldFit, Departure, OffsetDrift, Quantity, ReversalOffset, SensitivityFit,
    SensorCalibration,
};

use super::largest;
use crate::{Effect, number};

const DAYS_PER_YEAR: f64 = 365.25;

/// What a coil's findings do.
pub fn coil(coil: &CoilCalibration, code: Code, _: &str) -> Effect {
    match code {
        Code::Nonlinear => off_the_line(coil),
        Code::LackOfFit => Effect::nt(coil.constant.as_ref().map(|fit| fit.rms_nt)),
        _ => Effect::Unstated(code.effect()),
    }
}

/// What a sensor's findings do.
pub fn sensor(sensor: &SensorCalibration, code: Code, about: &str) -> Effect {
    let (fit, reversal) = (sensor.sensitivity.as_deref(), sensor.reversal.as_deref());
    let (drift, cross) = (sensor.drift.as_deref(), sensor.cross_field.as_deref());
    match code {
        Code::Nonlinear => Effect::nt(fit.and_then(bend)),
        Code::HigherOrderTerm => Effect::nt(fit.and_then(|fit| term(fit, about))),
        Code::OffsetsDisagree => Effect::nt(apart(sensor)),
        Code::Outliers => Effect::nt(reversal.and_then(|fit| unlike(fit, about))),
        Code::ReversalsDiffer => Effect::nt(reversal.and_then(scattered)),
        Code::Trend => Effect::nt(drift.and_then(over_the_dates)),
        Code::AnnualTerm => Effect::nt(drift.and_then(|drift| Some(drift.annual.as_ref()?.amplitude_nt))),
        Code::FollowsTemperature => Effect::nt(drift.and_then(by_temperature)),
        Code::Departure => {
            let all = sensor.temperature.iter().flat_map(|fit| &fit.departures);
            pulled(all.filter(|one| one.departure == about))
        }
        Code::CrossField => Effect::nt(cross.and_then(coefficient)),
        Code::SquaredCrossField => pulled(cross.iter().flat_map(|fit| &fit.departures)),
        _ => Effect::Unstated(code.effect()),
    }
}

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
fn term(fit: &SensitivityFit, order: &str) -> Option<f64> {
    let pair = fit.orders.windows(2).find(|pair| pair[1].order.to_string() == order)?;
    Some((pair[0].rms_nt.powi(2) - pair[1].rms_nt.powi(2)).max(0.0).sqrt())
}

/// The offset in the coil less that by reversals.
fn apart(sensor: &SensorCalibration) -> Option<f64> {
    let (coil, turned) = (sensor.sensitivity.as_ref()?, sensor.reversal.as_ref()?);
    Some(coil.offset_nt.value() - turned.offset_nt.value())
}

/// The offset of the recording that is farthest from their mean, less that.
fn scattered(reversal: &ReversalOffset) -> Option<f64> {
    let mean = reversal.offset_nt.value();
    largest(reversal.recordings.iter().map(|one| one.offset_nt.value() - mean))
}

/// What the pairs that were left out would move the mean of their recording by.
fn unlike(reversal: &ReversalOffset, recording: &str) -> Option<f64> {
    let pairs = &reversal.recordings.iter().find(|one| one.recording == recording)?.pairs;
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

/// The largest parameter of departures that were found, in its standard uncertainties.
fn pulled<'a>(departures: impl Iterator<Item = &'a Departure>) -> Effect {
    let values = departures.filter(|one| one.found).flat_map(|one| one.parameter.values());
    Effect::std(largest(values.filter_map(|value| Some(value.value() / value.std()?))))
}

/// The largest coefficient, at 50 000 nT across.
fn coefficient(fit: &CrossFieldFit) -> Option<f64> {
    largest(fit.offset.values().chain(fit.sensitivity.values()).map(Quantity::value))
}
