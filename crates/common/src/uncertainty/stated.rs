//! What a document states with an uncertainty, with the covariances that stand beside the values.

use faer::{Mat, mat};

use super::joint::SAME;
use super::paths::{
    VOLTMETER_ABSOLUTE, VOLTMETER_RELATIVE, added_offset, coil_constant, coil_offset, directions, effect,
    gradient, place, residual_field, resistor, sensitivity, sensor_offset,
};
use crate::axes::AxesDirections;
use crate::{Axis, Calibration, Document, Error, Quantity, covariance};

/// Radians of an arcsecond.
const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// Parameters that were stated together.
pub struct Group {
    /// What they are.
    pub name: String,
    /// Where their covariance stands.
    pub path: String,
    /// Their paths.
    pub parameters: Vec<String>,
    /// Their covariance.
    pub covariance: Mat<f64>,
    /// Whether all are of one kind and unit, so that they count as a whole.
    pub alike: bool,
}

/// All groups of a document, those first on which others rest.
pub fn groups(document: &Document) -> Result<Vec<Group>, Error> {
    let mut groups = facility(document);
    if let Some(calibration) = &document.calibration {
        for axis in Axis::ALL {
            groups.extend(coil(calibration, axis));
            groups.extend(sensor(calibration, axis));
        }
        groups.extend(axes(calibration)?);
    }
    groups.extend(model(document));
    Ok(groups)
}

/// A group whose covariance is that of the stated standard uncertainties, with what `entry` says of two of
/// them.
fn group(
    name: String,
    path: String,
    all: Vec<(String, &Quantity)>,
    entry: impl Fn(&str, &str) -> Option<f64>,
) -> Option<Group> {
    let known: Vec<(String, f64)> = all
        .into_iter()
        .filter_map(|(path, quantity)| Some((path, stated_std(quantity).filter(|std| *std != 0.0)?)))
        .collect();
    let value = |a: usize, b: usize| {
        if a == b { known[a].1 * known[a].1 } else { entry(&known[a].0, &known[b].0).unwrap_or(0.0) }
    };
    let covariance = Mat::from_fn(known.len(), known.len(), value);
    let parameters: Vec<String> = known.iter().map(|(path, _)| path.clone()).collect();
    (!parameters.is_empty()).then_some(Group { name, path, parameters, covariance, alike: false })
}

/// The stated standard uncertainty; NaN where it or the value is undetermined.
fn stated_std(quantity: &Quantity) -> Option<f64> {
    if quantity.value().is_finite() { quantity.std() } else { Some(f64::NAN) }
}

/// An entry of a covariance, by the names of its row and column.
fn entry(
    covariance: &Option<Vec<Vec<f64>>>,
    order: &Option<Vec<String>>,
    row: &str,
    column: &str,
) -> Option<f64> {
    let place = |name: &str| order.as_ref()?.iter().position(|key| key == name);
    covariance.as_ref()?.get(place(row)?)?.get(place(column)?).copied()
}

/// The last part of a path.
fn key(path: &str) -> &str {
    path.rsplit('.').next().unwrap_or(path)
}

/// What stands alone: voltmeter, resistors and gradients of the coils, places of the sensors.
fn facility(document: &Document) -> Vec<Group> {
    let mut found = Vec::new();
    let mut add = |path: String, std: Option<f64>| {
        if let Some(std) = std.filter(|std| *std > 0.0) {
            found.push(Group {
                name: path.clone(),
                path: path.clone(),
                parameters: vec![path],
                covariance: mat![[std * std]],
                alike: false,
            });
        }
    };
    let placed = document.instrument.as_ref().filter(|instrument| instrument.positions_m.is_some());
    for sensor in Axis::ALL {
        (0..3).for_each(|k| add(place(sensor, k), placed.and_then(|instrument| instrument.positions_std_m)));
    }
    let Some(facility) = &document.facility else { return found };
    if let Some(voltmeter) = &facility.voltmeter {
        add(VOLTMETER_RELATIVE.into(), voltmeter.relative);
        add(VOLTMETER_ABSOLUTE.into(), voltmeter.absolute_v);
    }
    for (axis, coil) in facility.coils.iter().flat_map(|coils| coils.iter()) {
        let std = coil
            .resistor_relative_uncertainty
            .zip(coil.resistor_ohm)
            .map(|(relative, ohm)| relative * ohm.abs());
        add(resistor(axis), std);
        add(gradient(axis), coil.gradient_nt_per_m_a.as_ref().and_then(Quantity::std));
    }
    found
}

fn coil(calibration: &Calibration, axis: Axis) -> Option<Group> {
    let coil = calibration.coil(axis)?;
    let stated = [(coil_constant(axis), &coil.constant_nt_per_a), (coil_offset(axis), &coil.offset_nt)];
    let all = stated.into_iter().filter_map(|(path, quantity)| Some((path, quantity.as_ref()?))).collect();
    let path = format!("calibration.coils.{axis}");
    group(format!("coil {axis} as stated"), path, all, |a, b| {
        entry(&coil.covariance, &coil.covariance_order, key(a), key(b))
    })
}

fn sensor(calibration: &Calibration, axis: Axis) -> Option<Group> {
    let sensor = calibration.sensor(axis)?;
    let stated = [
        (sensitivity(axis, "v"), &sensor.sensitivity_nt_per_v),
        (sensitivity(axis, "nt"), &sensor.sensitivity_nt_per_nt),
        (sensor_offset(axis), &sensor.offset_nt),
    ];
    let all = stated.into_iter().filter_map(|(path, quantity)| Some((path, quantity.as_ref()?))).collect();
    let path = format!("calibration.sensors.{axis}");
    group(format!("sensor {axis} as stated"), path, all, |a, b| {
        entry(&sensor.covariance, &sensor.covariance_order, key(a), key(b))
    })
}

fn axes(calibration: &Calibration) -> Result<Vec<Group>, Error> {
    let Some(axes) = &calibration.axes else { return Ok(Vec::new()) };
    let mut groups = Vec::new();
    let sensors = axes.sensors.as_ref().map(|of| cosines(of, "sensors")).transpose()?.flatten();
    let coils = axes.coils.as_ref().map(|of| cosines(of, "coils")).transpose()?.flatten();
    match (sensors, coils, &axes.cross_covariance) {
        (Some(mut sensors), Some(coils), Some(cross))
            if cross.len() == 9 && cross.iter().all(|row| row.len() == 9) =>
        {
            // One matrix over all eighteen.
            sensors.covariance = Mat::from_fn(18, 18, |a, b| match (a < 9, b < 9) {
                (true, true) => sensors.covariance[(a, b)],
                (true, false) => cross[a][b - 9],
                (false, true) => cross[b][a - 9],
                (false, false) => coils.covariance[(a - 9, b - 9)],
            });
            sensors.parameters.extend(coils.parameters);
            sensors.name = "directions as stated".into();
            groups.push(sensors);
        }
        (sensors, coils, _) => groups.extend(sensors.into_iter().chain(coils)),
    }
    for axis in Axis::ALL {
        let of =
            |each: &Option<crate::PerAxis<Quantity>>| each.as_ref().and_then(|each| each.get(axis)).cloned();
        for (path, quantity) in
            [(added_offset(axis), of(&axes.offsets_nt)), (residual_field(axis), of(&axes.residual_field_nt))]
        {
            let all = quantity.iter().map(|quantity| (path.clone(), quantity)).collect();
            groups.extend(group(path.clone(), path.clone(), all, |_, _| None));
        }
    }
    Ok(groups)
}

/// The nine cosines of sensors or coils, from their covariance or from `std_arcsec` as that of a turn in any
/// direction.
fn cosines(of: &AxesDirections, name: &str) -> Result<Option<Group>, Error> {
    let Some(matrix) = &of.matrix else { return Ok(None) };
    let parameters = directions(name);
    let path = format!("calibration.axes.{name}.covariance");
    let covariance = match (&of.covariance, &of.covariance_order) {
        (Some(_), Some(_)) => {
            let cosine = |path: &String| path[path.find("matrix").unwrap_or(0)..].to_string();
            let names: Vec<String> = parameters.iter().map(cosine).collect();
            let value = |a: &String, b: &String| {
                entry(&of.covariance, &of.covariance_order, a, b).ok_or_else(|| {
                    let expected = "9x9, over the elements of `matrix` as covariance_order names them";
                    Error::document(path.clone(), format!("no entry for {a} with {b}"), expected)
                })
            };
            let row = |a: &String| names.iter().map(|b| value(a, b)).collect();
            covariance::matrix(&names.iter().map(row).collect::<Result<Vec<Vec<f64>>, _>>()?)
        }
        _ => {
            // σ² (1 − n nᵀ) for each direction n.
            let std = |axis: usize| {
                of.std_arcsec.as_ref().and_then(|std| std.get(Axis::ALL[axis])).unwrap_or(0.0) * ARCSEC
            };
            // On the diagonal 1 − n² is the sum of the squares of the other two, in which nothing cancels.
            let across = |axis: usize, r: usize, s: usize| {
                let square = |k: usize| matrix[k][axis] * matrix[k][axis];
                let along: f64 = (0..3).map(square).sum();
                let across: f64 = (0..3).filter(|k| *k != r).map(square).sum();
                (if r == s { across } else { -matrix[r][axis] * matrix[s][axis] }) / along
            };
            let value = |a: usize, b: usize| {
                if a / 3 == b / 3 { std(a / 3).powi(2) * across(a / 3, a % 3, b % 3) } else { 0.0 }
            };
            Mat::from_fn(9, 9, value)
        }
    };
    let any = (0..9).any(|at| covariance[(at, at)] > 0.0);
    Ok(any.then(|| Group {
        name: format!("directions of the {name} as stated"),
        path,
        parameters,
        covariance,
        alike: true,
    }))
}

/// The parameters of the model's effects: those of one sensor together, with what sensorcal says of them.
fn model(document: &Document) -> Vec<Group> {
    let Some(model) = &document.model else { return Vec::new() };
    let mut groups = Vec::new();
    for (number, one) in model.effects.iter().enumerate() {
        let earlier = |other: &&crate::AdoptedEffect| other.sensor == one.sensor && one.sensor.is_some();
        if model.effects[..number].iter().any(|other| earlier(&other)) {
            continue;
        }
        let mine = |other: &&crate::AdoptedEffect| std::ptr::eq(*other, one) || earlier(other);
        let mut named: Vec<Named> = Vec::new();
        let mut all = Vec::new();
        for other in model.effects.iter().filter(mine) {
            for (parameter, quantity) in &other.parameters {
                let path = effect(other, parameter);
                named.push((path.clone(), format!("{}.{parameter}", fitted_as(&other.effect))));
                all.push((path, quantity));
            }
        }
        let stated: Vec<(String, f64)> =
            all.iter().map(|(path, quantity)| (path.clone(), quantity.std().unwrap_or(0.0))).collect();
        let sensor = one.sensor.and_then(|axis| document.calibration.as_ref()?.sensor(axis));
        let entry = |a: &str, b: &str| together(sensor?, (&named, &stated), a, b);
        let name = match one.sensor {
            Some(axis) => format!("effects of sensor {axis} as stated"),
            None => format!("{} as stated", one.effect),
        };
        groups.extend(group(name, format!("model.effects[{number}]"), all, entry));
    }
    groups
}

/// A parameter's path and its name in sensorcal's lists.
type Named = (String, String);

/// The name of an effect in sensorcal's lists.
fn fitted_as(effect: &str) -> &str {
    match effect {
        "cross_field" => "offset",
        "cross_field_sensitivity" => "sensitivity",
        other => other,
    }
}

/// The covariance of two parameters that sensorcal found together. What was found in another form, or changed
/// since, has the uncertainty that stands beside it, and no more.
fn together(
    sensor: &crate::SensorCalibration,
    (named, stated): (&[Named], &[(String, f64)]),
    a: &str,
    b: &str,
) -> Option<f64> {
    let name = |path: &str| Some(named.iter().find(|(of, _)| of == path)?.1.as_str());
    let std = |path: &str| Some(stated.iter().find(|(of, _)| of == path)?.1);
    let temperature = sensor.temperature.as_ref().map(|fit| (&fit.covariance, &fit.covariance_order));
    let across = sensor.cross_field.as_ref().map(|fit| (&fit.covariance, &fit.covariance_order));
    [temperature, across].into_iter().flatten().find_map(|(covariance, order)| {
        let place = |path: &str| order.iter().position(|key| Some(key.as_str()) == name(path));
        let (i, j) = (place(a)?, place(b)?);
        let same = |at: usize, path: &str| {
            let found = covariance.get(at)?.get(at)?.sqrt();
            ((found / std(path)? - 1.0).abs() < SAME).then_some(())
        };
        same(i, a)?;
        same(j, b)?;
        covariance.get(i)?.get(j).copied()
    })
}
