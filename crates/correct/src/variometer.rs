//! The field of a variometer by the baselines that `absolute` adopted: definitive data of an observatory.

use common::number::significant;
use common::{AdoptedBaselines, Axis, Document, Error, Recording, procedure};
use estimate::stats::{median, rms};
use nalgebra::{Matrix3, Vector3};
use physics::{Components, Unit};

use crate::noise::{length_and_step_s, variance_nt2};
use crate::{Corrected, Frame, flags};

/// |vector| minus the scalar magnetometer, corrected for the difference of the pillars.
pub const DELTA_F: &str = "delta_f_nt";

/// The adopted baselines of a document, where it has some.
pub fn adopted(document: &Document) -> Option<(Components, &AdoptedBaselines)> {
    let absolute = document.calibration.as_ref()?.absolute.as_ref()?;
    Some((Components::of(absolute.components.as_deref()?)?, absolute.adopted.as_ref()?))
}

/// Whether a recording is corrected by them: one of a variometer, and in a document that knows no sensors any other.
pub fn is_by_baselines(document: &Document, recording: &Recording) -> bool {
    let of_sensors =
        document.calibration.as_ref().is_some_and(|all| all.sensors.is_some() || all.axes.is_some());
    adopted(document).is_some() && (recording.procedure == procedure::VARIOMETER || !of_sensors)
}

/// The frame in which a recording is corrected: baselines give the field north, east and down.
pub fn frame(document: &Document, recording: &Recording, asked: Frame) -> Frame {
    if is_by_baselines(document, recording) { Frame::Geo } else { asked }
}

/// Corrects a recording: B of `physics::Components` with the baseline at the time of each row. `length_and_step` is of
/// the whole series where this is a piece of it, s.
/// Errors: a recording without a start or times, or in V; baselines of other components.
pub fn correct(
    document: &Document,
    recording: &Recording,
    path: &str,
    length_and_step: Option<[f64; 2]>,
) -> Result<Corrected, Error> {
    let Some((components, baselines)) = adopted(document) else { return Ok(Corrected::default()) };
    let Some((start, times)) = recording.start().zip(recording.column("time_s")) else {
        let expected =
            "start and time_s: a baseline changes with time; of a file --recording gives the start";
        return Err(Error::document(path, "no times", expected));
    };
    let [Some(x), Some(y), Some(z)] = Axis::ALL.map(|axis| recording.axis_column("sensor", axis, "nt"))
    else {
        let expected = "sensor_x_nt, sensor_y_nt and sensor_z_nt, which baselines in nT are added to";
        return Err(Error::document(format!("{path}.columns"), "no readings in nT", expected));
    };
    let keys = components.keys();
    let columns = keys.map(|key| baselines.components.get(key));
    if let Some(missing) = columns.iter().position(Option::is_none) {
        let place = "calibration.absolute.adopted.components";
        let expected = format!("{}, a baseline of a variometer along {}", keys[missing], components.name());
        return Err(Error::document(place, "no such component", expected));
    }
    let stated = recording.conditions.extra.get("components").and_then(|stated| stated.as_str());
    if let Some(other) = stated.filter(|stated| *stated != components.name()) {
        let expected = format!("\"{}\", for which the baselines were adopted", components.name());
        let path = format!("{path}.conditions.components");
        return Err(Error::document(path, format!("\"{other}\""), expected));
    }
    let origin = common::time::Start::parse(&baselines.start).map_or(0.0, |origin| origin.unix_s);
    let units = Vector3::from(components.units());
    let series = length_and_step.or_else(|| length_and_step_s(times));
    let noise = Axis::ALL.map(|axis| variance_nt2(document, axis, Unit::Nanotesla, 1.0, series));
    let noise = Matrix3::from_diagonal(&Vector3::from(noise));
    let mut left = Vec::new();
    let mut follows = Vec::new();
    for (k, baseline) in columns.into_iter().flatten().enumerate() {
        for one in &baseline.follows {
            match recording.column(&one.column) {
                Some(column) => follows.push((k, one, column)),
                None => {
                    left.push(format!("the baseline is not corrected for {}, which is missing", one.column))
                }
            }
        }
    }
    let common = if left.is_empty() { 0 } else { flags::EFFECT_LEFT };
    let mut corrected = Corrected { left, ..Corrected::default() };
    for (row, time) in times.iter().enumerate() {
        let reading = Vector3::new(x[row], y[row], z[row]);
        let [first, second, third] = keys.map(|key| baselines.at(key, start.unix_s - origin + time));
        let mut flag = common;
        let (mut field, mut std) = (Vector3::repeat(f64::NAN), Vector3::repeat(f64::NAN));
        match first.zip(second).zip(third) {
            _ if reading.iter().any(|value| !value.is_finite()) => flag |= flags::MISSING,
            None => flag |= flags::NOT_INVERTIBLE,
            Some(((first, second), third)) => {
                let known = [first, second, third];
                let mut value = Vector3::from(known.map(|[value, _]| value));
                let mut variance = Vector3::from(known.map(|[_, std]| std * std));
                for (k, one, column) in &follows {
                    let off = column[row] - one.reference;
                    value[*k] += one.coefficient.value() * off;
                    variance[*k] += (one.coefficient.std().unwrap_or(0.0) * off).powi(2);
                }
                let (found, by) = components.field_nt(&reading, &value.component_mul(&units));
                let own = variance.component_mul(&units.component_mul(&units));
                // The rotation is small: noise of the sensors is taken as noise along north and east.
                let covariance = by * Matrix3::from_diagonal(&own) * by.transpose() + noise;
                if found.iter().all(|value| value.is_finite()) {
                    (field, std) = (found, covariance.diagonal().map(f64::sqrt));
                } else {
                    flag |= flags::MISSING;
                }
            }
        }
        for k in 0..3 {
            corrected.field_nt[k].push(field[k]);
            corrected.std_nt[k].push(std[k]);
        }
        corrected.flags.push(flag);
    }
    Ok(corrected)
}

/// ΔF = |vector| − scalar at the absolute pier, nT, of a corrected recording with a scalar magnetometer.
pub fn delta_f(document: &Document, recording: &Recording, corrected: &Corrected) -> Option<Vec<f64>> {
    let (_, baselines) = adopted(document)?;
    let scalar = recording.column("reference_nt")?;
    let [x, y, z] = &corrected.field_nt;
    let one = |row: usize| x[row].hypot(y[row]).hypot(z[row]) - scalar[row] - baselines.pillar_difference_nt;
    Some((0..scalar.len()).map(one).collect())
}

pub fn words(recording: &Recording) -> Option<String> {
    let mut all: Vec<f64> =
        recording.column(DELTA_F)?.iter().copied().filter(|value| value.is_finite()).collect();
    if all.is_empty() {
        return None;
    }
    let middle = median(&all);
    all.iter_mut().for_each(|value| *value -= middle);
    let (id, middle, rms) = (&recording.id, significant(middle, 2), significant(rms(&all), 2));
    Some(format!(
        "\"{id}\": |vector| minus the scalar magnetometer (delta_f_nt): median {middle} nT, rms about the median {rms} nT"
    ))
}
