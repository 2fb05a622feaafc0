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
    let level = |name: &str, style: usize, holds: fn(f64) -> bool| {
        let all = directions.unit.iter().zip(&directions.residual_nt);
        let own = all.filter(|(unit, residual)| unit[2] * side >= 0.0 && holds(**residual / rms));
        let (x, y): (Vec<f64>, Vec<f64>) = own.map(|(unit, _)| place(unit)).unzip();
        Series::points(name, style, &x, &y)
    };
    let edge = (0..=72).map(|k| (f64::from(k) * 5.0_f64.to_radians()).sin_cos());
    let (up, right): (Vec<f64>, Vec<f64>) =
        edge.map(|(sin, cos)| (2.0_f64.sqrt() * sin, 2.0_f64.sqrt() * cos)).unzip();
    let title = format!("Residual on the directions of the field in SEN, z {name}");
    let plot = Plot::new(format!("scalar-directions-{name}"), title)
        .axes("x", "y")
        .note("Lambert's equal-area projection: the pole is in the middle, the plane of x and y lies at √2. An error of directions or sensitivities shows as regions of one sign.")
        .with(level("|B| − F within its rms", 3, |of_rms| of_rms.abs() <= 1.0))
        .with(level("above", 1, |of_rms| of_rms > 1.0))
        .with(level("below", 0, |of_rms| of_rms < -1.0))
        .with(Series::new("plane of x and y", Mark::Line, 4, &right, &up));
    Plot { map: true, ..plot }
}

/// The residual against each component of the direction: what bends with one is not in the model.
fn by_component(directions: &FieldDirections) -> Plot {
    let plot = Plot::new("scalar-residual", "Residual against the direction of the field")
        .axes("component of the unit vector in SEN", "|B| − F [nT]");
    SENSORS.iter().enumerate().fold(plot, |plot, (axis, name)| {
        let component: Vec<f64> = directions.unit.iter().map(|unit| unit[axis]).collect();
        plot.with(Series::points(*name, axis, &component, &directions.residual_nt))
    })
}

/// Offsets in parts of the recording, less those of the whole.
fn offsets(scalar: &ScalarCalibration, stability: &ScalarStability) -> Plot {
    let plot = Plot::new("scalar-stability", "Offsets in parts of the recording, less those of the whole")
        .axes("middle of the part [s]", "offset [nT]");
    SENSORS.iter().enumerate().fold(plot, |plot, (axis, name)| {
        let place = OFFSETS + axis;
        let all = scalar.parameters.get(place).map_or(0.0, |parameter| parameter.value);
        let whole = || stability.windows.iter().filter(|window| place < window.values.len());
        let x: Vec<f64> = whole().map(|window| 0.5 * (window.from_s + window.to_s)).collect();
        let y: Vec<f64> = whole().map(|window| window.values[place] - all).collect();
        let std: Vec<f64> = whole().map(|window| window.std[place]).collect();
        plot.with(Series::points(*name, axis, &x, &y).with_std(&std))
    })
}
