//! Findings of axescal.

use common::{AxesCalibration, AxesDirections, Axis, DoubtfulReading};

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

#[cfg(test)]
mod tests {
    use super::super::tests::said_by;
    use super::*;

    #[test]
    fn phrases() {
        said_by("axescal", &RULES);
    }
}
