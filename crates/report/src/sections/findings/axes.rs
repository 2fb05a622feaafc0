//! Findings of axescal and scalarcal.

use common::{AxesCalibration, AxesDirections, Axis, Code, DoubtfulReading, ScalarCalibration};

use super::largest;
use crate::Effect;

const ARCSEC_PER_RAD: f64 = 206_264.806;

pub fn directions(axes: &AxesCalibration, code: Code, about: &str) -> Option<Effect> {
    Some(match code {
        Code::PriorContradicted | Code::OrientationContradicted => Effect::std(about.parse().ok()),
        // The largest turn of a coil from where it was known to be.
        Code::KnownCoilsContradicted => {
            let (found, known) = (axes.coils.as_ref()?, axes.known_coils.as_ref()?);
            let turned = |axis| Some(angle(found.direction(axis)?, known.direction(axis)?));
            Effect::arcsec(largest(Axis::ALL.into_iter().filter_map(turned)))
        }
        Code::Swapped | Code::SensorReversed => Effect::arcsec(off_nominal(axes.sensors.as_ref()?, about)),
        Code::CoilReversed => Effect::arcsec(off_nominal(axes.coils.as_ref()?, about)),
        Code::ModelSubtracted => Effect::nt(about.parse().ok()),
        // The largest of what readings without a weight would move the predictions of themselves by, had they
        // one.
        Code::Outliers => {
            let all = axes.readings.as_ref()?;
            let moved = all.leverage.iter().zip(&all.leave_one_out_nt).zip(all.weight.as_ref()?);
            let moved = moved.filter(|(_, weight)| **weight < 0.5);
            Effect::nt(largest(moved.map(|((share, off), _)| share * off)))
        }
        _ => Effect::Unstated(code.effect()),
    })
}

/// What a reading that does not belong to the rest moves the prediction of itself by: its share in it times
/// its distance from what the others predict.
pub fn doubtful(axes: &AxesCalibration, one: &DoubtfulReading) -> Option<Effect> {
    let all = axes.readings.as_ref()?;
    let is_it = |row: &usize| {
        all.recording.get(*row) == Some(&one.recording)
            && all.row.get(*row) == Some(&one.row)
            && all.sensor.get(*row) == Some(&one.sensor)
            && all.coil.get(*row) == Some(&one.coil)
    };
    let row = (0..all.leverage.len()).find(is_it)?;
    Some(Effect::nt(all.leverage[row] * one.leave_one_out_nt))
}

/// Between two unit vectors, arcsec.
fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let chord = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    ARCSEC_PER_RAD * 2.0 * (chord / 2.0).min(1.0).asin()
}

/// How far an axis is from where it should be.
fn off_nominal(directions: &AxesDirections, axis: &str) -> Option<f64> {
    let axis = Axis::ALL.into_iter().find(|one| one.letter() == axis)?;
    let nominal = Axis::ALL.map(|other| if other == axis { 1.0 } else { 0.0 });
    Some(angle(directions.direction(axis)?, nominal))
}

pub fn scalar(scalar: &ScalarCalibration, code: Code, about: &str) -> Option<Effect> {
    Some(match code {
        Code::ReferenceOffset => Effect::nt(scalar.reference_offset.as_ref()?.offset_nt.value()),
        // What the new calibration changes at the readings, rms; without it the misfit in standard uncertainties.
        Code::PriorContradicted => match scalar.rms_before_nt {
            Some(before) => Effect::nt((before.powi(2) - scalar.rms_nt.powi(2)).max(0.0).sqrt()),
            None => {
                let test = scalar.beforehand.as_ref()?;
                Effect::std((test.chi_squared / test.degrees_of_freedom).sqrt())
            }
        },
        // The parameter of a part of the time that is farthest from that of all for its uncertainty, by what it
        // does in the field; where its unit does not tell, in standard uncertainties.
        Code::NotConstant => {
            let parts = scalar.stability.iter().flat_map(|stability| &stability.windows);
            let each = parts.flat_map(|part| {
                let values = part.values.iter().zip(&part.std).zip(&scalar.parameters);
                values.map(|((value, std), whole)| {
                    (whole, value - whole.value, ((value - whole.value) / std).abs())
                })
            });
            let known = each.filter(|(.., pull)| pull.is_finite());
            let (parameter, change, pull) = known.max_by(|a, b| a.2.total_cmp(&b.2))?;
            match parameter.unit.as_str() {
                "nT" => Effect::nt(change),
                "arcsec" => Effect::arcsec(change),
                "nT/V" | "nT/nT" => Effect::nt(50_000.0 * change / parameter.value),
                _ => Effect::std(pull),
            }
        }
        Code::Outliers => Effect::nt(about.parse().ok()),
        _ => Effect::Unstated(code.effect()),
    })
}
