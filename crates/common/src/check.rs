//! What the types of a calibration do not say and every number behind them rests on: directions of length
//! one, sensitivities that are not zero, covariances that can be.

use faer::{Mat, Scale};
use serde::Serialize;
use std::collections::HashSet;

use crate::number::{bare, counted};
use crate::uncertainty::{coil_constant, coil_offset, sensitivity, sensor_offset};
use crate::{
    AxesDirections, Axis, Calibration, Error, Facility, Instrument, NoiseOfSensors, Quantity, range,
};

/// What the length of a direction may differ from one: published matrices have four digits.
const LENGTH: f64 = 1e-3;
/// Correlations below this are rounding: published covariances have six digits or more.
const ROUNDING: f64 = 1e-6;

/// Constants and reference temperatures are such as instruments have.
pub(crate) fn constants(calibration: &Calibration) -> Result<(), Error> {
    let within = |path: String, quantity: &Option<Quantity>| {
        quantity.iter().try_for_each(|quantity| range::number(path.clone(), quantity.value()))
    };
    for axis in Axis::ALL {
        if let Some(coil) = calibration.coil(axis) {
            within(coil_constant(axis), &coil.constant_nt_per_a)?;
            within(coil_offset(axis), &coil.offset_nt)?;
        }
        if let Some(sensor) = calibration.sensor(axis) {
            within(sensitivity(axis, "v"), &sensor.sensitivity_nt_per_v)?;
            within(sensitivity(axis, "nt"), &sensor.sensitivity_nt_per_nt)?;
            within(sensor_offset(axis), &sensor.offset_nt)?;
        }
    }
    let Some(at) = &calibration.reference_conditions else { return Ok(()) };
    [
        ("sensor", at.sensor_temperature_c),
        ("electronics", at.electronics_temperature_c),
        ("coil", at.coil_temperature_c),
    ]
    .into_iter()
    .try_for_each(|(part, temperature)| {
        let path = format!("calibration.reference_conditions.{part}_temperature_c");
        temperature.map_or(Ok(()), |temperature| range::number(path, temperature))
    })
}

/// What a facility declares is such as there is; keys that are not its own may be anything.
pub(crate) fn facility(facility: &Facility) -> Result<(), Error> {
    let mut own = facility.clone();
    own.extra.clear();
    own.voltmeter.iter_mut().for_each(|voltmeter| voltmeter.extra.clear());
    own.noise.iter_mut().for_each(|noise| noise.extra.clear());
    if let Some(coils) = &mut own.coils {
        coils.extra.clear();
        Axis::ALL.iter().for_each(|axis| coils.entry(*axis).iter_mut().for_each(|coil| coil.extra.clear()));
    }
    declared("facility", &own)
}

/// What an instrument declares is such as there is; keys that are not its own may be anything.
pub(crate) fn instrument(instrument: &Instrument) -> Result<(), Error> {
    let mut own = instrument.clone();
    own.extra.clear();
    own.positions_m.iter_mut().for_each(|positions| positions.extra.clear());
    match &mut own.noise {
        Some(NoiseOfSensors::Same(noise)) => noise.extra.clear(),
        Some(NoiseOfSensors::Each(each)) => {
            each.extra.clear();
            Axis::ALL
                .iter()
                .for_each(|axis| each.entry(*axis).iter_mut().for_each(|noise| noise.extra.clear()));
        }
        None => {}
    }
    declared("instrument", &own)
}

fn declared(path: &str, part: &impl Serialize) -> Result<(), Error> {
    serde_json::to_value(part).map_or(Ok(()), |part| range::numbers(path, path, &part))
}

/// Holds a calibration to all of them.
pub(crate) fn calibration(calibration: &Calibration) -> Result<(), Error> {
    constants(calibration)?;
    for axis in Axis::ALL {
        if let Some(coil) = calibration.coil(axis) {
            let path = format!("calibration.coils.{axis}");
            let keys = |key: &str| ["constant_nt_per_a", "offset_nt"].contains(&key);
            covariance(&path, coil.covariance.as_deref(), coil.covariance_order.as_deref(), keys)?;
        }
        let Some(sensor) = calibration.sensor(axis) else { continue };
        let path = format!("calibration.sensors.{axis}");
        for (key, k) in [
            ("sensitivity_nt_per_v", &sensor.sensitivity_nt_per_v),
            ("sensitivity_nt_per_nt", &sensor.sensitivity_nt_per_nt),
        ] {
            if k.as_ref().is_some_and(|k: &Quantity| k.value() == 0.0) {
                return Err(Error::document(
                    format!("{path}.{key}"),
                    "0",
                    "a sensitivity, which is not zero; leave the key out where it is not known",
                ));
            }
        }
        let keys = |key: &str| ["sensitivity_nt_per_v", "sensitivity_nt_per_nt", "offset_nt"].contains(&key);
        covariance(&path, sensor.covariance.as_deref(), sensor.covariance_order.as_deref(), keys)?;
        let temperature = sensor.temperature.as_ref().map(|fit| (&fit.covariance, &fit.covariance_order));
        let noise = sensor.noise.as_ref().filter(|fit| !fit.covariance.is_empty());
        let noise = noise.map(|fit| (&fit.covariance, &fit.covariance_order));
        let across = sensor.cross_field.as_ref().map(|fit| (&fit.covariance, &fit.covariance_order));
        for (part, found) in [("temperature", temperature), ("noise", noise), ("cross_field", across)] {
            let Some((matrix, order)) = found else { continue };
            covariance(&format!("{path}.{part}"), Some(matrix), Some(order), |_| true)?;
        }
    }
    if let Some(axes) = &calibration.axes {
        for (part, found) in
            [("sensors", &axes.sensors), ("coils", &axes.coils), ("known_coils", &axes.known_coils)]
        {
            found.iter().try_for_each(|found| directions(&format!("calibration.axes.{part}"), found))?;
        }
    }
    if let Some(pair) = &calibration.differential {
        let path = "calibration.differential";
        covariance(path, pair.covariance.as_deref(), pair.covariance_order.as_deref(), is_element)?;
    }
    Ok(())
}

fn directions(path: &str, found: &AxesDirections) -> Result<(), Error> {
    if let Some(rows) = &found.matrix {
        for column in 0..3 {
            length(&format!("{path}.matrix"), rows.map(|row| row[column]), "a column")?;
        }
    }
    for (axis, direction) in found.directions.iter().flat_map(|directions| directions.iter()) {
        length(&format!("{path}.directions.{axis}"), *direction, "a direction")?;
    }
    covariance(path, found.covariance.as_deref(), found.covariance_order.as_deref(), is_element)
}

fn length(path: &str, direction: [f64; 3], what: &str) -> Result<(), Error> {
    let length = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
    if (length - 1.0).abs() <= LENGTH {
        return Ok(());
    }
    let expected = "unit vectors (rows and columns may be mixed up, or sensitivities multiplied in)";
    Err(Error::document(path, format!("{what} of length {}", bare(length)), expected))
}

/// `matrix[row][column]`.
fn is_element(key: &str) -> bool {
    let place = |text: &str| matches!(text, "0" | "1" | "2");
    let inside = key.strip_prefix("matrix[").and_then(|rest| rest.strip_suffix(']'));
    inside.and_then(|inside| inside.split_once("][")).is_some_and(|(row, column)| place(row) && place(column))
}

/// A covariance is square, over keys that there are, symmetric, and no variance of any combination is
/// negative.
fn covariance(
    path: &str,
    covariance: Option<&[Vec<f64>]>,
    order: Option<&[String]>,
    is_key: impl Fn(&str) -> bool,
) -> Result<(), Error> {
    let refuse = |key: &str, found: String, expected: &str| {
        Err(Error::document(format!("{path}.{key}"), found, expected))
    };
    let Some(covariance) = covariance else { return Ok(()) };
    let Some(order) = order else {
        return refuse("covariance_order", "no such key".into(), "the keys that `covariance` runs over");
    };
    let mut seen = HashSet::new();
    if let Some(key) = order.iter().find(|key| !is_key(key) || !seen.insert(*key)) {
        let expected = "each key beside it that the covariance runs over, once";
        return refuse("covariance_order", format!("\"{key}\""), expected);
    }
    let size = order.len();
    if covariance.len() != size || covariance.iter().any(|row| row.len() != size) {
        let columns = covariance.iter().map(Vec::len).max().unwrap_or(0);
        let found = format!("{} of up to {columns} numbers", counted(covariance.len(), "row"));
        let expected = format!("{size} rows of {size}, as its `covariance_order` has names");
        return refuse("covariance", found, &expected);
    }
    if let Some(key) = (0..size).find(|k| covariance[*k][*k] < 0.0) {
        let found = format!("the variance {} of {}", covariance[key][key], order[key]);
        return refuse("covariance", found, "variances that are not negative");
    }
    // In units of each standard uncertainty, so that what is rounding does not depend on units.
    let std: Vec<f64> = (0..size).map(|k| covariance[k][k].sqrt()).collect();
    let unit = |k: usize| if std[k] > 0.0 { std[k] } else { 1.0 };
    let correlation = Mat::from_fn(size, size, |i, j| covariance[i][j] / (unit(i) * unit(j)));
    for (i, j) in (0..size).flat_map(|i| (0..i).map(move |j| (i, j))) {
        if (correlation[(i, j)] - correlation[(j, i)]).abs() > ROUNDING {
            let found =
                format!("{} and {} for {} and {}", covariance[i][j], covariance[j][i], order[i], order[j]);
            return refuse("covariance", found, "a symmetric matrix");
        }
    }
    if !is_possible(correlation) {
        let found = "a matrix by which some combination of its keys has a negative variance".into();
        return refuse("covariance", found, "a covariance, which is positive semidefinite");
    }
    Ok(())
}

/// Whether a correlation matrix has no negative eigenvalue, by elimination: each pivot is what is left of a
/// variance.
fn is_possible(mut left: Mat<f64>) -> bool {
    for k in 0..left.nrows() {
        let row = left.row(k).to_owned();
        let pivot = row[k].max(0.0);
        if row[k] < -ROUNDING {
            return false;
        }
        for j in k + 1..row.ncols() {
            if row[j] * row[j] > (pivot + ROUNDING) * (left[(j, j)].max(0.0) + ROUNDING) {
                return false;
            }
        }
        if pivot > ROUNDING {
            left -= row.transpose() * &row * Scale(1.0 / pivot);
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use crate::Document;
    use faer::{Mat, mat};

    fn refused(calibration: &str) -> String {
        let text = format!("{{\"fluxcal\": 1, \"calibration\": {calibration}}}");
        Document::parse(&text).expect_err("refused").to_string()
    }

    #[test]
    fn directions_and_constants_can_be() {
        for (calibration, expected) in [
            (
                r#"{"axes": {"sensors": {"matrix": [[1.01, 0, 0], [0, 1, 0], [0, 0, 1]]}}}"#,
                "axes.sensors.matrix: found a column of length 1.01;",
            ),
            (
                r#"{"axes": {"coils": {"directions": {"y": [0, 0, 0]}}}}"#,
                "axes.coils.directions.y: found a direction of length 0;",
            ),
            (
                r#"{"coils": {"y": {"constant_nt_per_a": {"value": -1e31, "std": 1}}}}"#,
                "coils.y.constant_nt_per_a: found -1e31; expected a number between −1·10⁸ and 1·10⁸; is it in another unit?",
            ),
            (
                r#"{"reference_conditions": {"coil_temperature_c": -300}}"#,
                "reference_conditions.coil_temperature_c: found -300;",
            ),
            (
                r#"{"sensors": {"z": {"sensitivity_nt_per_v": 0}}}"#,
                "sensors.z.sensitivity_nt_per_v: found 0;",
            ),
        ] {
            let said = refused(calibration);
            assert!(said.starts_with(&format!("calibration.{expected}")), "{said}");
        }
    }

    #[test]
    fn what_is_declared_can_be_and_other_keys_may_be_anything() {
        let document = |rest: &str| Document::parse(&format!("{{\"fluxcal\": 1, {rest}}}"));
        for (rest, said) in [
            (
                r#""facility": {"coils": {"y": {"max_nt": 1e12}}}"#,
                "facility.coils.y.max_nt: found 1000000000000;",
            ),
            (
                r#""facility": {"voltmeter": {"absolute_v": 1e9}}"#,
                "facility.voltmeter.absolute_v: found 1000000000;",
            ),
            (r#""instrument": {"noise": {"z": {"white_rms_nt": 1e31}}}"#, "instrument.noise.z.white_rms_nt:"),
        ] {
            let found = document(rest).expect_err("refused").to_string();
            assert!(found.starts_with(said), "{found}");
        }
        let own = r#""order_a": 20231234, "drift_ppm_per_c": -300"#;
        let of_all = format!(
            r#""facility": {{{own}, "coils": {{{own}, "x": {{{own}}}}}, "voltmeter": {{{own}}}, "noise": {{{own}}}}},
               "instrument": {{{own}, "positions_m": {{{own}}}, "noise": {{"x": {{{own}}}}}}}"#
        );
        let kept = document(&of_all).expect("keys of the user's own");
        assert_eq!(kept.instrument.expect("kept").extra.len(), 2);
    }

    #[test]
    fn covariances_can_be() {
        let sensor = |order: &str, covariance: &str| {
            refused(&format!(
                r#"{{"sensors": {{"x": {{"covariance_order": {order}, "covariance": {covariance}}}}}}}"#
            ))
        };
        let two = r#"["sensitivity_nt_per_v", "offset_nt"]"#;
        for (order, covariance, said) in [
            (two, "[[1, 2], [2, 1]]", "a negative variance"),
            (two, "[[-1, 0], [0, 1]]", "the variance -1 of sensitivity_nt_per_v"),
            (two, "[[1, 0.5], [0.4, 1]]", "0.4 and 0.5 for offset_nt and sensitivity_nt_per_v"),
            (two, "[[1, 0]]", "1 row of up to 2 numbers"),
            (two, "[[0, 1], [1, 1]]", "a negative variance"),
            (r#"["offset_nt", "gain"]"#, "[[1, 0], [0, 1]]", "covariance_order: found \"gain\""),
            (r#"["offset_nt", "offset_nt"]"#, "[[1, 0], [0, 1]]", "covariance_order: found \"offset_nt\""),
        ] {
            let found = sensor(order, covariance);
            assert!(found.contains(said), "{found}");
        }
    }

    #[test]
    fn singular_covariances_are_possible() {
        // Of three quantities with one error in common nothing is negative, though two eigenvalues are zero.
        assert!(super::is_possible(Mat::ones(3, 3)));
        assert!(super::is_possible(mat![[1.0, -1.0], [-1.0, 1.0]]));
        // Each pair can be; the three together cannot.
        let three = mat![[1.0, 0.9, 0.9], [0.9, 1.0, -0.9], [0.9, -0.9, 1.0]];
        assert!(!super::is_possible(three));
    }
}
