//! The sensors calibrated by the magnitude of the field.

use common::{Calibration, FieldDirections, ScalarCalibration, ScalarStability};

use super::Plots;
use crate::plot::{Mark, Plot, Series};

/// Offsets stand behind the three sensitivities.
const OFFSETS: usize = 3;
const SENSORS: [&str; 3] = ["x", "y", "z"];

pub fn plots(plots: &mut Plots, calibration: &Calibration) {
    let Some(scalar) = &calibration.scalar else { return };
    let of_directions = scalar.directions.iter().flat_map(|directions| {
        [hemisphere(directions, 1.0), hemisphere(directions, -1.0), by_component(directions)]
    });
    let stability = scalar.stability.as_ref().filter(|stability| stability.windows.len() > 1);
    let of_parts = stability.map(|stability| offsets(scalar, stability));
    plots.insert("scalar".into(), of_directions.chain(of_parts).collect());
}

/// The residual on the directions of the field on one side of the plane of x and y, in Lambert's equal-area
/// projection about ±z.
fn hemisphere(directions: &FieldDirections, side: f64) -> Plot {
    let name = if side > 0.0 { "above" } else { "below" };
    let place = |unit: &[f64; 3]| {
        let across = unit[0].hypot(unit[1]);
        let radius = (2.0 * (1.0 - unit[2].abs())).max(0.0).sqrt();
        if across > 0.0 { (radius * unit[0] / across, radius * unit[1] / across) } else { (0.0, 0.0) }
    };
    let rms = estimate::stats::rms(&directions.residual_nt);
    let mine =
        || directions.unit.iter().zip(&directions.residual_nt).filter(|(unit, _)| unit[2] * side >= 0.0);
    let level = |name: &str, style: usize, holds: fn(f64) -> bool| {
        let own = mine().filter(|(_, residual)| holds(**residual / rms));
        let (x, y): (Vec<f64>, Vec<f64>) = own.map(|(unit, _)| place(unit)).unzip();
        Series::points(name, style, &x, &y)
    };
    let edge: Vec<f64> = (0..=72).map(|k| f64::from(k) * 5.0_f64.to_radians()).collect();
    let circle =
        |of: fn(f64) -> f64| edge.iter().map(|angle| 2.0_f64.sqrt() * of(*angle)).collect::<Vec<f64>>();
    let [right, up] = [f64::cos, f64::sin].map(circle);
    Plot::new(format!("scalar-directions-{name}"), format!("Residual on the directions of the field in SEN, z {name}"))
        .axes("x", "y")
        .map()
        .note("Lambert's equal-area projection: the pole is in the middle, the plane of x and y lies at √2. An error of directions or sensitivities shows as regions of one sign.")
        .with(level("|B| − F within its rms", 3, |of_rms| of_rms.abs() <= 1.0))
        .with(level("above", 1, |of_rms| of_rms > 1.0))
        .with(level("below", 0, |of_rms| of_rms < -1.0))
        .with(Series::new("plane of x and y", Mark::Line, 4, &right, &up))
}

/// The residual against each component of the direction: what bends with one is not in the model.
fn by_component(directions: &FieldDirections) -> Plot {
    let mut plot = Plot::new("scalar-residual", "Residual against the direction of the field")
        .axes("component of the unit vector in SEN", "|B| − F [nT]");
    for (axis, name) in SENSORS.iter().enumerate() {
        let component: Vec<f64> = directions.unit.iter().map(|unit| unit[axis]).collect();
        plot.push(Series::points(*name, axis, &component, &directions.residual_nt));
    }
    plot
}

/// Offsets in parts of the recording, less those of the whole.
fn offsets(scalar: &ScalarCalibration, stability: &ScalarStability) -> Plot {
    let mut plot =
        Plot::new("scalar-stability", "Offsets in parts of the recording, less those of the whole")
            .axes("middle of the part [s]", "offset [nT]");
    for (axis, name) in SENSORS.iter().enumerate() {
        let place = OFFSETS + axis;
        let all = scalar.parameters.get(place).map_or(0.0, |parameter| parameter.value);
        let whole = stability.windows.iter().filter(|window| place < window.values.len());
        let point = whole.map(|window| {
            [0.5 * (window.from_s + window.to_s), window.values[place] - all, window.std[place]]
        });
        plot.push(Series::measured(*name, axis, point));
    }
    plot
}
