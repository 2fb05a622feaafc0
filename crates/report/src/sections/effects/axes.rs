//! Findings of axescal and scalarcal.

use common::{AxesCalibration, AxesDirections, Axis, DoubtfulReading, ScalarCalibration, ScalarParameter};

use super::{LEFT_OUT, NOT_SHOWN, Rule, UNCERTAINTY, before, largest};
use crate::Effect;

const ARCSEC_PER_RAD: f64 = 206_264.806;

/// What findings on the directions do.
pub const RULES: [Rule<AxesCalibration>; 13] = [
    ("standard uncertainties from the value that the document states", |_, words| {
        Effect::std(before(words, " standard uncertainties"))
    }),
    ("times the theodolites' uncertainty", |_, words| {
        Effect::std(before(words, " times the theodolites' uncertainty"))
    }),
    ("the readings contradict the known directions of the coils", |axes, _| Effect::arcsec(turned(axes))),
    ("columns or cables may be swapped", |axes, words| {
        Effect::arcsec(off_nominal(axes.sensors.as_ref(), "sensor", words))
    }),
    (" reads with the opposite sign", |axes, words| {
        Effect::arcsec(off_nominal(axes.sensors.as_ref(), "sensor", words))
    }),
    (" has the opposite sign", |axes, words| Effect::arcsec(off_nominal(axes.coils.as_ref(), "coil", words))),
    ("subtracted from the readings, at most ", |_, words| Effect::nt(before(words, " nT: "))),
    ("given no weight", |axes, _| Effect::nt(without_weight(axes))),
    ("times as much as declared", |_, _| UNCERTAINTY),
    ("one value for all is estimated from the residuals", |_, _| UNCERTAINTY),
    ("cannot be separated by zero drives", |_, _| NOT_SHOWN),
    ("too little for a direction", |_, _| NOT_SHOWN),
    (" is not applied in ", |_, _| LEFT_OUT),
];

/// What a reading that does not belong to the rest moves the prediction of itself by: its share in it times
/// its distance from what the others predict.
pub fn doubtful(axes: &AxesCalibration, one: &DoubtfulReading) -> Effect {
    let readings = axes.readings.iter();
    let leverage = readings.flat_map(|all| {
        (0..all.leverage.len()).filter_map(|row| {
            let same = all.recording.get(row)? == &one.recording
                && all.row.get(row)? == &one.row
                && all.sensor.get(row)? == &one.sensor
                && all.coil.get(row)? == &one.coil;
            same.then(|| all.leverage[row])
        })
    });
    Effect::nt(leverage.map(|share| share * one.leave_one_out_nt).next())
}

/// The largest of what readings without a weight would move the predictions of themselves by, had they one.
fn without_weight(axes: &AxesCalibration) -> Option<f64> {
    let all = axes.readings.as_ref()?;
    let moved = all.leverage.iter().zip(&all.leave_one_out_nt).zip(all.weight.as_ref()?);
    largest(moved.filter(|(_, weight)| **weight < 0.5).map(|((share, off), _)| share * off))
}

/// The largest turn of a coil from where it was known to be.
fn turned(axes: &AxesCalibration) -> Option<f64> {
    let (found, known) = (axes.coils.as_ref()?, axes.known_coils.as_ref()?);
    largest(Axis::ALL.into_iter().filter_map(|axis| angle(found.direction(axis)?, known.direction(axis)?)))
}

/// Between two unit vectors, arcsec.
fn angle(a: [f64; 3], b: [f64; 3]) -> Option<f64> {
    let chord = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    Some(ARCSEC_PER_RAD * 2.0 * (chord / 2.0).min(1.0).asin())
}

/// How far the axis that a finding names is from where it should be.
fn off_nominal(directions: Option<&AxesDirections>, of: &str, words: &str) -> Option<f64> {
    let directions = directions?;
    let axis = Axis::ALL.into_iter().find(|axis| words.contains(&format!("{of} {axis} ")))?;
    let nominal = Axis::ALL.map(|other| if other == axis { 1.0 } else { 0.0 });
    angle(directions.direction(axis)?, nominal)
}

/// What findings on a calibration by magnitude do.
pub const SCALAR: [Rule<ScalarCalibration>; 8] = [
    ("the reference reads ", |scalar, _| {
        Effect::nt(scalar.reference_offset.as_ref().map(|reference| reference.offset_nt.value()))
    }),
    ("the readings contradict the prior calibration of the sensors", |scalar, _| contradicted(scalar)),
    ("the calibration is not constant in time", |scalar, _| changed(scalar)),
    ("outliers (p", |_, words| Effect::nt(before(words, " nT in "))),
    ("the magnitude of the field is unknown", |_, _| NOT_SHOWN),
    ("make the uncertainties too small", |_, _| UNCERTAINTY),
    ("include the iron of the body", |_, _| NOT_SHOWN),
    (" left out: others have one", |_, _| LEFT_OUT),
];

/// What the new calibration changes at the readings, rms; without it the misfit in standard uncertainties.
fn contradicted(scalar: &ScalarCalibration) -> Effect {
    let rms = scalar.rms_before_nt.map(|before| (before.powi(2) - scalar.rms_nt.powi(2)).max(0.0).sqrt());
    let pull = scalar.beforehand.as_ref().map(|test| (test.chi_squared / test.degrees_of_freedom).sqrt());
    rms.map_or(Effect::std(pull), Effect::nt)
}

/// The parameter of a part of the time that is farthest from that of all for its uncertainty.
fn changed(scalar: &ScalarCalibration) -> Effect {
    let parts = scalar.stability.iter().flat_map(|stability| &stability.windows);
    let each = parts.flat_map(|part| {
        let values = part.values.iter().zip(&part.std).zip(&scalar.parameters);
        values.map(|((value, std), whole)| (whole, value - whole.value, ((value - whole.value) / std).abs()))
    });
    let known = each.filter(|(.., pull)| pull.is_finite());
    let most = known.max_by(|a, b| a.2.total_cmp(&b.2));
    most.map_or(Effect::NOT_HELD, |(parameter, change, pull)| in_field(parameter, change, pull))
}

/// A change of a parameter by what it does; where its unit does not tell, in standard uncertainties.
fn in_field(parameter: &ScalarParameter, change: f64, pull: f64) -> Effect {
    match parameter.unit.as_str() {
        "nT" => Effect::nt(change),
        "arcsec" => Effect::arcsec(change),
        "nT/V" | "nT/nT" => Effect::nt(50_000.0 * change / parameter.value),
        _ => Effect::std(pull),
    }
}
