//! From the recordings of a document to readings in nT.

use common::number::significant;
use common::{Axis, Code, Document, Noise, Recording, procedure};
use nalgebra::Vector3;
use physics::{Basic, Context, References, Unit};
use std::ops::Range;

use crate::added::Added;
use crate::observations::{Together, sensor_column};
use crate::{
    Error, NoiseSource, Observation, Observations, Options, OrientationGroup, Result, ac, checks, means,
};

/// A coil that makes less than this is as good as off, nT.
const WEAK_NT: f64 = 5.0;
/// Coils that are never driven with this share of the largest field are not asked for a direction.
const LEAST_DRIVE: f64 = 1e-3;

/// Reads every recording of the procedure, less what effects add to its readings.
pub fn observe(
    (document, references): (&Document, References),
    options: &Options,
    added: &Added,
    fits: &ac::Fits,
) -> Result<Observations> {
    let recorded = document.recordings.iter().enumerate();
    let recordings: Vec<(usize, &Recording)> =
        recorded.filter(|(_, recording)| recording.procedure == procedure::AXES_ORIENTATION).collect();
    if recordings.is_empty() {
        let found = "no recording with \"procedure\": \"axes_orientation\"";
        let expected =
            "at least one, with the drive of the coils, the readings of the sensors and the orientation";
        return Err(Error::document("recordings", found, expected));
    }
    let sensors = sensors(document, &recordings, options)?;
    let mut all = Observations {
        orientations: Vec::new(),
        readings: Vec::new(),
        together: Vec::new(),
        noise: NoiseSource::SineFits,
        unit: Unit::Volt,
        sensors,
        coils: Vec::new(),
        phases: Vec::new(),
        findings: Vec::new(),
    };
    let mut conditions: Vec<&common::Conditions> = Vec::new();
    let mut runs = Vec::new();
    for &(index, recording) in &recordings {
        let path = format!("recordings[{index}]");
        checks::columns(recording, &path, &all.sensors)?;
        let context = Context::new(document, recording, references).map_err(|error| {
            let path = physics_path(&path, recording, &error);
            error.at(&path)
        })?;
        all.unit = context.unit;
        let basic = checks::constants(document, recording, &context, &path, &mut all)?;
        let now = &recording.conditions;
        let same = conditions.iter().position(|seen| {
            (&seen.orientation, &seen.theodolite, &seen.setting)
                == (&now.orientation, &now.theodolite, &now.setting)
        });
        let orientation = same.unwrap_or_else(|| {
            if now.orientation.is_none() && now.theodolite.is_none() {
                all.findings.push(Code::NoOrientation.said(format!(
                    "recording \"{}\" states no orientation; the block is taken as aligned with GEO",
                    recording.id
                )));
            }
            conditions.push(now);
            all.orientations
                .push(OrientationGroup { orientation: context.orientation.clone(), recordings: Vec::new() });
            conditions.len() - 1
        });
        all.orientations[orientation].recordings.push(recording.id.clone());
        match now.drive_hz {
            Some(hz) => {
                let instrument = document.instrument.as_ref();
                let place = (index, orientation);
                runs.push(ac::run(place, hz, instrument, &context, &basic, (&all.sensors, added, fits))?);
            }
            None => rows(document, index, orientation, (&context, &basic), added, &mut all),
        }
    }
    ac::join(runs, &mut all)?;
    one_noise_for_all(&mut all);
    choose_coils(&mut all, options)?;
    checks::scale(&recordings, &all)?;
    Ok(all)
}

/// The path that an error of the forward model is about: the orientation, where that is no rotation.
fn physics_path(path: &str, recording: &Recording, error: &physics::Error) -> String {
    if !matches!(error, physics::Error::NotARotation { .. }) {
        return path.to_string();
    }
    let key = if recording.conditions.theodolite.is_some() { "theodolite" } else { "orientation" };
    format!("{path}.conditions.{key}")
}

/// Where any reading has no declared noise, none is used: one noise for all is then found from the residuals.
fn one_noise_for_all(all: &mut Observations) {
    if all.noise != NoiseSource::Residuals {
        return;
    }
    if all.readings.iter().any(|reading| reading.std_nt != 1.0) {
        all.findings.push(Code::NoiseNotDeclared.said(
            "the noise of some readings is not declared; one value for all is estimated from the residuals",
        ));
    }
    all.readings.iter_mut().for_each(|reading| reading.std_nt = 1.0);
    all.together.clear();
}

/// The sensors to be read: as asked, else as the instrument states, else as the columns say.
fn sensors(document: &Document, recordings: &[(usize, &Recording)], options: &Options) -> Result<Vec<Axis>> {
    let stated = document.instrument.as_ref().and_then(|instrument| instrument.sensors.clone());
    let mut sensors = match (options.sensor, stated) {
        (Some(sensor), _) => vec![sensor],
        (None, Some(stated)) => stated,
        (None, None) => Axis::ALL
            .into_iter()
            .filter(|axis| recordings.iter().any(|(_, recording)| sensor_column(recording, *axis).is_some()))
            .collect(),
    };
    sensors.sort();
    sensors.dedup();
    if !sensors.is_empty() {
        return Ok(sensors);
    }
    if document.instrument.as_ref().is_some_and(|instrument| instrument.sensors.is_some()) {
        return Err(Error::document("instrument.sensors", "an empty list", "the sensors that it has"));
    }
    let path = format!("recordings[{}].columns", recordings[0].0);
    Err(Error::document(path, "no sensor_*_v and no sensor_*_nt", "the readings of the sensors"))
}

/// Readings of a recording with constant drives: row by row, or drive by drive where noise with memory is
/// declared. A missing reading takes out itself alone.
fn rows(
    document: &Document,
    recording: usize,
    orientation: usize,
    (context, basic): (&Context<'_>, &Basic),
    added: &Added,
    all: &mut Observations,
) {
    let times = context.recording.column("time_s");
    let (length_s, step_s) = times.map_or((f64::INFINITY, f64::INFINITY), |times| {
        let span = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
        (span, span / (times.len().max(2) - 1) as f64)
    });
    let drive_nt: Vec<Vector3<f64>> = context.current_a.iter().map(|current| drive(basic, current)).collect();
    let field = |row: usize| drive_nt[row] + context.ambient(row);
    for sensor in all.sensors.clone() {
        let Some((_, column)) = sensor_column(context.recording, sensor) else { continue };
        let constants = &basic.sensors[sensor.index()];
        let noises = declared(document, sensor);
        let code = context.unit.code_width(document.instrument.as_ref()).unwrap_or(0.0);
        let code_nt = code * constants.sensitivity.abs();
        let std_nt = declared_std(&noises, code_nt, length_s, step_s);
        all.noise = match (all.noise, std_nt) {
            (NoiseSource::Residuals, _) | (_, None) => NoiseSource::Residuals,
            _ => NoiseSource::Declared,
        };
        let there = |row: usize| column[row].is_finite() && field(row).iter().all(|field| field.is_finite());
        let (groups, stds) = match means::means(&noises, times, &drive_nt, code_nt, there) {
            Some((groups, covariance)) => {
                let stds = covariance.diagonal().iter().map(|variance| Some(variance.sqrt())).collect();
                let rows = groups.iter().map(|group| group.start).collect();
                all.together.push(Together { recording, sensor, rows, covariance });
                (groups, stds)
            }
            None => {
                let single = (0..column.len()).filter(|row| there(*row)).map(|row| row..row + 1);
                let groups: Vec<Range<usize>> = single.collect();
                let stds = vec![std_nt; groups.len()];
                (groups, stds)
            }
        };
        let added_nt = added.along(recording, sensor);
        for (group, std_nt) in groups.into_iter().zip(stds) {
            let rows: Vec<usize> = group.filter(|row| there(*row)).collect();
            let count = rows.len() as f64;
            let mean = |of: &dyn Fn(usize) -> f64| rows.iter().map(|row| of(*row)).sum::<f64>() / count;
            let vector = |of: &dyn Fn(usize) -> Vector3<f64>| {
                rows.iter().fold(Vector3::zeros(), |sum, row| sum + of(*row)) / count
            };
            let value_nt = |row: usize| {
                constants.sensitivity * column[row] + constants.offset_nt
                    - added_nt.as_ref().map_or(0.0, |added| added[row])
            };
            all.readings.push(Observation {
                orientation,
                recording,
                row: rows[0],
                sensor,
                drive_nt: vector(&|row| drive_nt[row]),
                value_nt: mean(&value_nt),
                std_nt: std_nt.unwrap_or(1.0),
                ambient_nt: vector(&|row| context.ambient(row)),
                constant: true,
            });
        }
    }
}

/// The noise declared for a sensor with that of the field in the coils; none where that of the sensor is not.
fn declared(document: &Document, sensor: Axis) -> Vec<&Noise> {
    let own = document.instrument.as_ref().and_then(|instrument| instrument.noise_of(sensor));
    let field = document.facility.as_ref().and_then(|facility| facility.noise.as_ref());
    own.into_iter().chain(field.filter(|_| own.is_some())).collect()
}

/// White and flicker noise and the rounding of the converter, where noise is declared.
fn declared_std(noises: &[&Noise], code_nt: f64, length_s: f64, step_s: f64) -> Option<f64> {
    let rms = noises.iter().map(|noise| noise.rms_nt(length_s, step_s)).reduce(f64::hypot)?;
    let std = (rms * rms + code_nt * code_nt / 12.0).sqrt();
    (std > 0.0).then_some(std)
}

/// k I + B0 along each coil; a coil without current contributes its offset only where it is known.
fn drive(basic: &Basic, current_a: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from_fn(|c, _| basic.coils[c].constant_nt_per_a * current_a[c] + basic.coils[c].offset_nt)
}

/// The coils whose direction is asked for, and the readings that speak of them.
fn choose_coils(all: &mut Observations, options: &Options) -> Result<()> {
    if let Some(coil) = options.coil {
        all.readings.retain(|reading| {
            let others =
                (0..3).filter(|c| *c != coil.index()).map(|c| reading.drive_nt[c].abs()).fold(0.0, f64::max);
            others <= LEAST_DRIVE * reading.drive_nt[coil.index()].abs()
        });
    }
    let largest =
        |axis: Axis| all.readings.iter().map(|r| r.drive_nt[axis.index()].abs()).fold(0.0, f64::max);
    let most = Axis::ALL.into_iter().map(largest).fold(0.0, f64::max);
    all.coils =
        Axis::ALL.into_iter().filter(|axis| most > 0.0 && largest(*axis) > LEAST_DRIVE * most).collect();
    if all.coils.is_empty() {
        return Err(Error::Unanswerable(
            "no reading was taken with a coil driven; directions need at least one drive for each coil"
                .into(),
        ));
    }
    for axis in Axis::ALL.into_iter().filter(|axis| !all.coils.contains(axis)) {
        let field = largest(axis);
        if field > WEAK_NT {
            all.findings.push(Code::WeakCoil.about(axis).said(format!(
                "coil {axis} produces at most {} nT, too little for a direction; its nominal axis is assumed",
                significant(field, 3)
            )));
        }
    }
    Ok(())
}
