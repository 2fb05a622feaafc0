//! Offset drift: offsets from date to date ("Measurement of Sensor Noise in Low Field": what takes longer
//! than a day to a week is offset).

use common::number::{counted, plural};
use common::{Axis, Document, DriftDates, OffsetDrift, Quantity, procedure};

use crate::Error;
use crate::conditions::Conditions;
use crate::readings::recordings;
use crate::reversal::{self, Outcome, Sensitivity};
use crate::shape::Shape;
use crate::trend::{self, ANNUAL_FROM, Date};

/// Mean, trend, yearly term and temperature's part of the offsets of all dates; None without a recording.
pub fn drift(
    document: &Document,
    sensor: Axis,
    sensitivity: Sensitivity<'_>,
    noise: &dyn Fn(f64) -> Shape,
    conditions: &Conditions,
) -> Result<Option<OffsetDrift>, Error> {
    let mut dates = Vec::new();
    for (path, recording) in recordings(document, procedure::OFFSET_DRIFT, sensor)? {
        let Some(start) = recording.start() else {
            let expected = "the date of the recording, as in 1977-05-26T14:44:35Z";
            return Err(Error::document(format!("{path}.start"), "no such key", expected));
        };
        let Outcome { reversal, scatter_nt2, by_temperature, .. } =
            reversal::one(document, recording, &path, sensor, sensitivity, noise, conditions)?;
        let column = recording.column("sensor_temperature_c").unwrap_or_default();
        let known: Vec<f64> = column.iter().copied().filter(|t| t.is_finite()).collect();
        dates.push(Date {
            recording: recording.id.clone(),
            time_s: start.unix_s,
            offset: reversal.offset_nt,
            temperature_c: (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64),
            scatter_nt2,
            by_temperature,
        });
    }
    if dates.is_empty() {
        return Ok(None);
    }
    dates.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    if dates.len() < 3 {
        return Err(Error::Unanswerable(format!(
            "sensor {sensor}: `offset_drift` was recorded on {}; a mean and its scatter need 3 dates, a trend 5, a yearly term {}",
            counted(dates.len(), "date"),
            ANNUAL_FROM.1
        )));
    }
    Ok(Some(result(&dates, conditions)?))
}

fn result(dates: &[Date], conditions: &Conditions) -> Result<OffsetDrift, Error> {
    let day = |date: &Date| date.days_from(&dates[0]);
    let count = dates.len() as f64;
    let own = |date: &Date| date.scatter_nt2;
    let corrected = dates.iter().all(|date| date.by_temperature.is_some());
    let own_mean = dates.iter().map(own).sum::<f64>() / count;
    let mean = dates.iter().map(|date| date.offset.value()).sum::<f64>() / count;
    let square = dates.iter().map(|date| (date.offset.value() - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // Errors of the coefficients of temperature are common to all dates.
    let common = common(dates, conditions);
    let average = |column: &Vec<f64>| column.iter().sum::<f64>() / count;
    let common_mean = conditions.variance(&common.iter().map(average).collect::<Vec<_>>());
    let mut found = OffsetDrift {
        mean_nt: Quantity::new(mean, (own_mean / count + common_mean).sqrt()),
        rms_nt: square.sqrt(),
        own_rms_nt: (square - own_mean).max(0.0).sqrt(),
        dates: DriftDates {
            recording: dates.iter().map(|date| date.recording.clone()).collect(),
            time_d: dates.iter().map(day).collect(),
            offset_nt: dates.iter().map(|date| date.offset.value()).collect(),
            std_nt: dates.iter().map(|date| own(date).sqrt()).collect(),
            residual_nt: dates.iter().map(|date| date.offset.value() - mean).collect(),
            sensor_temperature_c: dates.iter().filter_map(|date| date.temperature_c).collect(),
        },
        ..OffsetDrift::default()
    };
    if dates.len() >= 5 {
        trend::fit(dates, (conditions, &common), &mut found)?;
    } else {
        found.findings.push(format!(
            "{} {} no trend: at least five are needed",
            counted(dates.len(), "date"),
            plural(dates.len(), "determines", "determine")
        ));
    }
    if corrected {
        found.findings.push("offsets are corrected to the reference temperatures".into());
    }
    Ok(found)
}

/// For each parameter of the temperatures, how it moves the offset of each date; empty where they were not
/// taken off.
fn common(dates: &[Date], conditions: &Conditions) -> Vec<Vec<f64>> {
    let of = |parameter: usize| {
        dates.iter().map(move |date| date.by_temperature.as_ref().map_or(0.0, |by| by[parameter]))
    };
    (0..conditions.covariance.nrows()).map(|parameter| of(parameter).collect()).collect()
}
