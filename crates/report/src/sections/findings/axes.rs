//! Findings of axescal and scalarcal.

use common::{
    AxesCalibration, AxesDirections, Axis, Code, DoubtfulReading, ScalarCalibration, ScalarParameter,
};

use super::largest;
use crate::Effect;

const ARCSEC_PER_RAD: f64 = 206_264.806;

/// What findings on the directions do.
pub fn directions(axes: &AxesCalibration, code: Code, about: &str) -> Effect {
    match code {
        Code::PriorContradicted | Code::OrientationContradicted => Effect::std(about.parse().ok()),
        Code::KnownCoilsContradicted => Effect::arcsec(turned(axes)),
        Code::Swapped | Code::SensorReversed => Effect::arcsec(off_nominal(axes.sensors.as_ref(), about)),
        Code::CoilReversed => Effect::arcsec(off_nominal(axes.coils.as_ref(), about)),
        Code::ModelSubtracted => Effect::nt(about.parse().ok()),
        Code::Outliers => Effect::nt(without_weight(axes)),
        _ => Effect::Unstated(code.effect()),
    }
}

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

/// How far an axis is from where it should be.
fn off_nominal(directions: Option<&AxesDirections>, axis: &str) -> Option<f64> {
    let axis = Axis::ALL.into_iter().find(|one| one.letter() == axis)?;
    let nominal = Axis::ALL.map(|other| if other == axis { 1.0 } else { 0.0 });
    angle(directions?.direction(axis)?, nominal)
}

/// What findings on a calibration by magnitude do.
pub fn scalar(scalar: &ScalarCalibration, code: Code, about: &str) -> Effect {
    match code {
        Code::ReferenceOffset => {
            Effect::nt(scalar.reference_offset.as_ref().map(|reference| reference.offset_nt.value()))
        }
        Code::PriorContradicted => contradicted(scalar),
        Code::NotConstant => changed(scalar),
        Code::Outliers => Effect::nt(about.parse().ok()),
        _ => Effect::Unstated(code.effect()),
    }
}

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
