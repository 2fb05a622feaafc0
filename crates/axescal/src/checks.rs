//! What must be there before readings can be made of a recording, each fault with its own sentence.

use common::number::{counted, significant};
use common::{Axis, Code, Document, Recording};
use physics::{Basic, Context, Unit};

use crate::observations::sensor_column;
use crate::{Error, Observations, Result};

/// With fewer than three sensors and coils, readings below this share of the drive are in another unit.
const LEAST_OF_A_PART: f64 = 5e-3;
/// Readings further from the drive than this factor are in another unit.
const UNIT_FACTOR: f64 = 3.0;
/// The largest of some hundred readings has noise of no more than so many standard deviations.
const NOISE_WITHIN: f64 = 5.0;

/// Every sensor has its column, and every column holds a reading.
pub fn columns(recording: &Recording, path: &str, sensors: &[Axis]) -> Result<()> {
    recording.at_hand(path)?;
    let present: Vec<&str> = recording.columns.keys().map(String::as_str).collect();
    let missing = |what: String| Error::document(format!("{path}.columns"), present.join(", "), what);
    let drive = |axis: Axis| ["a", "v"].map(|unit| recording.axis_column("coil", axis, unit));
    if Axis::ALL.into_iter().flat_map(drive).all(|column| column.is_none()) {
        let what = "the drive of the coils, coil_x_a, coil_y_a, coil_z_a (or in V over the resistors)";
        return Err(missing(what.into()));
    }
    if let Some(axis) = Axis::ALL.into_iter().find(|axis| drive(*axis).iter().all(Option::is_some)) {
        return Err(missing(format!("coil_{axis}_a or coil_{axis}_v, not both")));
    }
    for axis in Axis::ALL {
        for (unit, column) in ["a", "v"].iter().zip(drive(axis)) {
            if column.is_some_and(|column| !column.is_empty() && column.iter().all(|drive| drive.is_nan())) {
                let key = format!("{path}.columns.coil_{axis}_{unit}");
                let expected =
                    "at least one row with a drive; write 0 where the coil was off, or remove the recording";
                return Err(Error::document(key, "a drive that is null in every row", expected));
            }
        }
    }
    let in_unit =
        |unit: &str| Axis::ALL.iter().any(|axis| recording.axis_column("sensor", *axis, unit).is_some());
    if in_unit("v") && in_unit("nt") {
        return Err(missing("the sensors of a recording all in V, or all in nT".into()));
    }
    for &sensor in sensors {
        let Some((name, column)) = sensor_column(recording, sensor) else {
            return Err(missing(format!(
                "also sensor_{sensor}_v (or sensor_{sensor}_nt), the readings of sensor {sensor}; where the instrument has no such sensor, list those it has in instrument.sensors"
            )));
        };
        if column.iter().all(|reading| reading.is_nan()) {
            let found = format!("{}, all of them null", counted(column.len(), "reading"));
            let expected =
                "at least one reading; remove the recording, or the sensor from instrument.sensors";
            return Err(Error::document(format!("{path}.columns.{name}"), found, expected));
        }
    }
    Ok(())
}

/// The constants of the chain; every coil that has a column and every sensor must have its own.
pub fn constants(
    document: &Document,
    recording: &Recording,
    context: &Context<'_>,
    path: &str,
    all: &mut Observations,
) -> Result<Basic> {
    let calibration = document.calibration.as_ref();
    for axis in Axis::ALL {
        let driven = context.current_a.iter().any(|current| current[axis.index()] != 0.0);
        let coil = calibration.and_then(|calibration| calibration.coil(axis));
        let known = coil.and_then(|coil| coil.constant_nt_per_a.as_ref()).map(common::Quantity::value);
        if driven && known.is_none_or(|constant| constant == 0.0) {
            let known = if known.is_some() { "zero" } else { "nothing" };
            let key = format!("calibration.coils.{axis}.constant_nt_per_a");
            let expected = "the coil constant in nT/A; run coilcal first, or write it there";
            return Err(Error::document(key, format!("{known}, though {path} drives coil {axis}"), expected));
        }
    }
    for &sensor in &all.sensors {
        let known = calibration.and_then(|calibration| calibration.sensor(sensor));
        let calibrated = known.and_then(|known| physics::sensitivity(known, context.unit));
        if context.unit == Unit::Nanotesla || calibrated.is_some() {
            continue;
        }
        let nominal = document.instrument.as_ref().and_then(|of| of.nominal_sensitivity_nt_per_v);
        let Some(nominal) = nominal else {
            let key = format!("calibration.sensors.{sensor}.sensitivity_nt_per_v");
            let found = format!("nothing, though recording \"{}\" reads sensor {sensor} in V", recording.id);
            let expected = "the sensitivity in nT/V; run sensorcal first, or write it there";
            return Err(Error::document(key, found, expected));
        };
        let said = Code::NominalSensitivity.about(sensor).said(format!(
            "sensor {sensor} is not calibrated; its nominal sensitivity of {nominal} nT/V was taken as exact"
        ));
        if !all.findings.contains(&said) {
            all.findings.push(said);
        }
    }
    Ok(Basic::of(document, context.unit))
}

/// Readings and drive must be of one size: another unit shows as a factor.
pub fn scale(recordings: &[(usize, &Recording)], all: &Observations) -> Result<()> {
    let drive = all.readings.iter().map(|reading| reading.drive_nt.norm()).fold(0.0, f64::max);
    for &sensor in &all.sensors {
        let own = || all.readings.iter().filter(|reading| reading.sensor == sensor);
        let largest = own().map(|reading| reading.value_nt.abs()).fold(0.0, f64::max);
        // Readings may be mostly noise, where that is declared.
        let noise = NOISE_WITHIN * own().map(|reading| reading.std_nt).fold(0.0, f64::max);
        let ratio = largest / drive;
        // One sensor with one coil may lie across each other in every orientation.
        let complete = all.sensors.len() == 3 && all.coils.len() == 3;
        let least = if complete { 1.0 / UNIT_FACTOR } else { LEAST_OF_A_PART };
        if largest - noise > UNIT_FACTOR * drive || largest + noise < least * drive {
            let (index, recording) = recordings[0];
            let name = sensor_column(recording, sensor).map_or_else(String::new, |(name, _)| name);
            let units = [(1e-9, "T"), (1e-6, "mT"), (1e-5, "G"), (1e-3, "µT"), (1e-2, "mG")];
            let guess = units.iter().find(|(factor, _)| (ratio / factor).ln().abs() < 0.7);
            let guess = guess.map_or_else(String::new, |(_, unit)| format!("; they look like {unit}"));
            let (most, made) = (significant(largest, 4), significant(drive, 4));
            let scale = significant(ratio, 2);
            let unit = if name.ends_with("_v") { "V" } else { "nT" };
            let found = format!(
                "readings of at most {most} nT where the coils produce {made} nT, a scale of {scale}"
            );
            let expected = format!(
                "readings in {unit} and constants in nT, a scale near 1{guess}. Convert the column, or correct the sensitivity or the coil constants"
            );
            return Err(Error::document(format!("recordings[{index}].columns.{name}"), found, expected));
        }
    }
    Ok(())
}
