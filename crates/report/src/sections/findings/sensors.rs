//! Findings of coilcal and sensorcal.

use common::{Code, CoilCalibration, Departure, Quantity, SensorCalibration};

use super::largest;
use crate::{Effect, number};

const DAYS_PER_YEAR: f64 = 365.25;

pub fn coil(coil: &CoilCalibration, code: Code, _: &str) -> Option<Effect> {
    Some(match code {
        // What is fitted beside constant and offset: the largest distance of the fitted field from their line,
        // among the levels.
        Code::Nonlinear => {
            let residuals = &coil.constant.as_ref()?.residuals;
            let [k, offset] =
                [coil.constant_nt_per_a.as_ref()?, coil.offset_nt.as_ref()?].map(Quantity::value);
            let fields = residuals.field_nt.iter().zip(&residuals.residual_nt);
            let levels = residuals.drive_a.iter().zip(fields);
            let off = levels.map(|(drive, (field, residual))| field - residual - (k * drive + offset));
            Effect::nt(largest(off))
        }
        Code::LackOfFit => Effect::nt(coil.constant.as_ref()?.rms_nt),
        _ => Effect::Unstated(code.effect()),
    })
}

pub fn sensor(sensor: &SensorCalibration, code: Code, about: &str) -> Option<Effect> {
    Some(match code {
        // What fitting a departure changes at the readings, at most.
        Code::Nonlinear => {
            let residuals = &sensor.sensitivity.as_ref()?.residuals;
            let pairs = residuals.deviation_nt.iter().zip(&residuals.residual_nt);
            Effect::nt(largest(pairs.map(|(line, all)| line - all)))
        }
        // The rms of what the polynomial's highest term adds.
        Code::HigherOrderTerm => {
            let orders = &sensor.sensitivity.as_ref()?.orders;
            let pair = orders.windows(2).find(|pair| pair[1].order.to_string() == about)?;
            Effect::nt((pair[0].rms_nt.powi(2) - pair[1].rms_nt.powi(2)).max(0.0).sqrt())
        }
        // The offset in the coil less that by reversals.
        Code::OffsetsDisagree => {
            let (coil, turned) = (sensor.sensitivity.as_ref()?, sensor.reversal.as_ref()?);
            Effect::nt(coil.offset_nt.value() - turned.offset_nt.value())
        }
        // What the pairs that were left out would move the mean of their recording by.
        Code::Outliers => {
            let mut recordings = sensor.reversal.as_ref()?.recordings.iter();
            let pairs = &recordings.find(|one| one.recording == about)?.pairs;
            let used = pairs.offset_nt.iter().zip(&pairs.used).filter(|(_, used)| **used);
            Effect::nt(mean(pairs.offset_nt.iter())? - mean(used.map(|(offset, _)| offset))?)
        }
        // The offset of the recording that is farthest from their mean, less that.
        Code::ReversalsDiffer => {
            let reversal = sensor.reversal.as_ref()?;
            let mean = reversal.offset_nt.value();
            Effect::nt(largest(reversal.recordings.iter().map(|one| one.offset_nt.value() - mean)))
        }
        Code::Trend => {
            let drift = sensor.drift.as_ref()?;
            let [first, last] = number::ends(drift.dates.time_d.iter().copied())?;
            Effect::nt(drift.trend_nt_per_year.as_ref()?.value() * (last - first) / DAYS_PER_YEAR)
        }
        Code::AnnualTerm => Effect::nt(sensor.drift.as_ref()?.annual.as_ref()?.amplitude_nt),
        Code::FollowsTemperature => {
            let drift = sensor.drift.as_ref()?;
            let [low, high] = number::ends(drift.dates.sensor_temperature_c.iter().copied())?;
            Effect::nt(drift.temperature_nt_per_k.as_ref()?.value() * (high - low))
        }
        Code::Departure => {
            let all = sensor.temperature.iter().flat_map(|fit| &fit.departures);
            pulled(all.filter(|one| one.departure == about))
        }
        // The largest coefficient, at 50 000 nT across.
        Code::CrossField => {
            let fit = sensor.cross_field.as_ref()?;
            Effect::nt(largest(fit.offset.values().chain(fit.sensitivity.values()).map(Quantity::value)))
        }
        Code::SquaredCrossField => pulled(sensor.cross_field.iter().flat_map(|fit| &fit.departures)),
        _ => Effect::Unstated(code.effect()),
    })
}

fn mean<'a>(values: impl Iterator<Item = &'a f64> + Clone) -> Option<f64> {
    let count = values.clone().count();
    (count > 0).then(|| values.sum::<f64>() / count as f64)
}

/// The largest parameter of departures that were found, in its standard uncertainties.
fn pulled<'a>(departures: impl Iterator<Item = &'a Departure>) -> Effect {
    let values = departures.filter(|one| one.found).flat_map(|one| one.parameter.values());
    Effect::std(largest(values.filter_map(|value| Some(value.value() / value.std()?))))
}
