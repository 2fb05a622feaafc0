//! What temperatures do to sensitivity and offset: the coefficients.

use common::{Document, TemperatureOfPart};

use super::effects::{self, findings};
use super::{departures, temperature_loops};
use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let calibration = document.calibration.as_ref()?;
    let sensors = calibration.sensors.as_ref()?;
    let mut section = Section::new("temperature", "Temperature");
    let mut slopes = Table::new(
        "Coefficients at the reference temperature, from the whole run",
        [
            ("sensor", ""),
            ("temperature of", ""),
            ("k", "ppm/K"),
            ("k", "ppm/K²"),
            ("curvature of k, p", ""),
            ("O", "nT/K"),
            ("O", "nT/K²"),
            ("curvature of O, p", ""),
            ("from", "°C"),
            ("to", "°C"),
        ],
    );
    let mut three_point = Table::new(
        "Slopes through the three central temperatures",
        [("sensor", ""), ("temperature of", ""), ("k", "ppm/K"), ("O", "nT/K")],
    );
    let mut turning = Table::new(
        "Temperatures at which k or O is stationary",
        [
            ("sensor", ""),
            ("temperature of", ""),
            ("what", ""),
            ("at", "°C"),
            ("differences between the sensors, p", ""),
        ],
    );
    let mut lags = Table::new(
        "Lag behind the temperature",
        [("sensor", ""), ("temperature of", ""), ("lag", "s"), ("what the readings say", "")],
    );
    let mut looked_for = departures::table("sensor");
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(fit) = &sensor.temperature else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &fit.findings, &effects::conditions::TEMPERATURE, fit));
        for (what, part) in [("sensor", &fit.sensor), ("electronics", &fit.electronics)] {
            let Some(part) = part else { continue };
            slopes.row(row(&name, what, part));
            three_point.row([
                name.as_str().into(),
                what.into(),
                part.three_point.get("sensitivity_ppm_per_k").into(),
                part.three_point.get("offset_nt_per_k").into(),
            ]);
            lags.row([
                name.as_str().into(),
                what.into(),
                part.lag_s.as_ref().into(),
                part.lag.as_str().into(),
            ]);
            for (quantity, temperature) in &part.extrema_c {
                turning.row([
                    name.as_str().into(),
                    what.into(),
                    quantity.as_str().into(),
                    temperature.into(),
                    Cell::Empty,
                ]);
            }
        }
        departures::add(&mut looked_for, &name, &fit.departures);
        plots.push(temperature_loops::plots(axis, fit));
    }
    for common in &calibration.common_extrema {
        turning.row([
            "all".into(),
            common.part.as_str().into(),
            common.quantity.as_str().into(),
            (&common.temperature_c).into(),
            Cell::Probability(common.p_value),
        ]);
    }
    section.table(slopes);
    section.plots_side_by_side(plots);
    section.table(three_point);
    section.table(turning);
    section.table(lags);
    section.table(looked_for);
    (!section.items.is_empty()).then_some(section)
}

fn row(name: &str, what: &str, part: &TemperatureOfPart) -> [Cell; 10] {
    let p = |p: Option<f64>| p.map_or(Cell::Empty, Cell::Probability);
    [
        name.into(),
        what.into(),
        (&part.sensitivity_ppm_per_k).into(),
        part.sensitivity_ppm_per_k2.as_ref().into(),
        p(part.sensitivity_curvature_p),
        (&part.offset_nt_per_k).into(),
        part.offset_nt_per_k2.as_ref().into(),
        p(part.offset_curvature_p),
        part.range_c[0].into(),
        part.range_c[1].into(),
    ]
}
