//! The sensors calibrated by the magnitude of the field.

use common::{Document, FieldDirections, Quantity, ScalarCalibration, ScalarStability};

use super::effects::{self, findings};
use crate::plot::{Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

/// Offsets stand behind the three sensitivities.
const OFFSETS: usize = 3;
const SENSORS: [&str; 3] = ["x", "y", "z"];

pub fn section(document: &Document) -> Option<Section> {
    let scalar = document.calibration.as_ref()?.scalar.as_ref()?;
    let mut section = Section::new("scalar", "Sensors by the magnitude of the field");
    let before = |rms| format!(", with the calibration as it was stated {} nT", number::figures(rms, 3));
    section.say(format!(
        "{} rows against {}: the residual |B| − F has an rms of {} nT{}.",
        scalar.rows,
        scalar.reference,
        number::figures(scalar.rms_nt, 3),
        scalar.rms_before_nt.map(before).unwrap_or_default()
    ));
    section.warnings.extend(findings("", &scalar.findings, &effects::axes::SCALAR, scalar));
    let parameters = scalar.parameters.iter().map(|one| {
        let alone = one.std_alone.map_or(Cell::from("not determined"), |std| Cell::Figures(std, 2));
        let value = Cell::from(&Quantity::new(one.value, one.std));
        (&one.name, value, &one.unit, alone, Cell::figures(one.std_with_known, 2))
    });
    let headers = "parameter | value | unit | from the readings alone | with prior knowledge";
    section.rows("Parameters", headers, parameters);
    if let Some(weakest) = &scalar.weakest {
        section.say(format!("Least determined: {}. To determine it, {}.", weakest.words, weakest.remedy));
    }
    if let Some(vector) = &scalar.vector {
        section.say(format!(
            "With the direction of the field at {} moments: the residual has an rms of {} nT along it and of {} nT across it; the difference is an \
             error of the attitude of {}″.{}",
            vector.moments,
            number::figures(vector.rms_along_nt, 3),
            number::figures(vector.rms_across_nt, 3),
            number::figures(vector.attitude_std_arcsec, 2),
            if vector.across_only { " Only the residual across the field is used." } else { "" }
        ));
    }
    if let Some(body) = &scalar.body {
        let mut table = Table::new("Iron of the body, in SEN", "part | value | unit");
        for (axis, quantity) in body.hard_iron_nt.iter() {
            table.row((format!("hard iron, {axis}"), quantity, "nT"));
        }
        for (name, quantity) in &body.soft_iron_ppm {
            table.row((format!("soft iron, {name}"), quantity, "ppm of the field"));
        }
        section.table(table);
    }
    if let Some(directions) = &scalar.directions {
        section.plot(hemisphere(directions, 1.0));
        section.plot(hemisphere(directions, -1.0));
        section.plot(by_component(directions));
    }
    if let Some(stability) = scalar.stability.as_ref().filter(|stability| stability.windows.len() > 1) {
        section.plot(offsets(scalar, stability));
    }
    Some(section)
}

/// Directions of the field on one side of the plane of x and y, in Lambert's equal-area projection about ±z.
fn hemisphere(directions: &FieldDirections, side: f64) -> Plot {
    let name = if side > 0.0 { "above" } else { "below" };
    let place = |unit: &[f64; 3]| {
        let across = unit[0].hypot(unit[1]);
        let radius = (2.0 * (1.0 - unit[2].abs())).max(0.0).sqrt();
        if across > 0.0 { (radius * unit[0] / across, radius * unit[1] / across) } else { (0.0, 0.0) }
    };
    let mine = directions.unit.iter().filter(|unit| unit[2] * side >= 0.0);
    let (x, y): (Vec<f64>, Vec<f64>) = mine.map(place).unzip();
    let edge: Vec<f64> = (0..=72).map(|k| f64::from(k) * 5.0_f64.to_radians()).collect();
    let circle =
        |of: fn(f64) -> f64| edge.iter().map(|angle| 2.0_f64.sqrt() * of(*angle)).collect::<Vec<f64>>();
    let [right, up] = [f64::cos, f64::sin].map(circle);
    Plot::new(format!("scalar-directions-{name}"), format!("Directions of the field in SEN, z {name}"))
        .axes("x", "y")
        .map()
        .note("Lambert's equal-area projection: the pole is in the middle, the plane of x and y lies at √2.")
        .with(Series::points("field", 0, &x, &y))
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
