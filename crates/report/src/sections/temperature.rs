//! Sensitivity and offset against temperature: coefficients, and the loops of the runs.

use common::{Axis, Document, TemperatureFit, TemperatureLevels, TemperatureOfPart};

use super::common_words::led;
use super::departures;
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

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
        "Temperatures at which k or O stands still",
        [
            ("sensor", ""),
            ("temperature of", ""),
            ("what", ""),
            ("at", "°C"),
            ("differences between the sensors, p", ""),
        ],
    );
    let mut looked_for = departures::table("sensor");
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(fit) = &sensor.temperature else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(led(&name, &fit.findings));
        for (what, part) in [("sensor", &fit.sensor), ("electronics", &fit.electronics)] {
            let Some(part) = part else { continue };
            slopes.row(row(&name, what, part));
            three_point.row([
                name.as_str().into(),
                what.into(),
                part.three_point.get("sensitivity_ppm_per_k").into(),
                part.three_point.get("offset_nt_per_k").into(),
            ]);
            let lag = part
                .lag_s
                .as_ref()
                .map(|lag| format!(" ({} s)", number::cell(&lag.into())))
                .unwrap_or_default();
            if !part.lag.is_empty() {
                section.words.push(format!("Lag of {name} behind its {what}: {}{lag}.", part.lag));
            }
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
        plots.extend(loops(axis, fit));
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
    plots.into_iter().for_each(|plot| section.plot(plot));
    section.table(three_point);
    section.table(turning);
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

/// k and O of each run against the temperature that moved in it.
fn loops(axis: Axis, fit: &TemperatureFit) -> Vec<Plot> {
    let levels = &fit.levels;
    let mut plots = Vec::new();
    for (number, recording) in fit.recordings.iter().enumerate() {
        let rows: Vec<usize> =
            (0..levels.recording.len()).filter(|row| levels.recording[*row] == number).collect();
        let Some(first) = rows.first() else { continue };
        let (what, temperature) = moved(levels, &rows);
        let of = |column: &[f64]| -> Vec<f64> {
            rows.iter().filter_map(|row| column.get(*row).copied()).collect()
        };
        let temperature = of(temperature);
        let branch: Vec<i8> = rows.iter().map(|row| levels.branch[*row]).collect();
        let k0 = levels.sensitivity[*first];
        let ppm = |value: f64| 1e6 * (value / k0 - 1.0);
        let k: Vec<f64> = of(&levels.sensitivity).into_iter().map(ppm).collect();
        let k_std: Vec<f64> = of(&levels.sensitivity_std).into_iter().map(|std| 1e6 * std / k0).collect();
        let id = |quantity: &str| format!("temperature-{axis}-{}-{quantity}", number + 1);
        let x = || Dimension::linear(format!("temperature of the {what}"), "°C");
        plots.push(branches(
            Plot::new(
                id("sensitivity"),
                format!("Sensor {axis}: sensitivity, {recording}"),
                x(),
                Dimension::linear("k from the first", "ppm"),
            ),
            axis,
            &branch,
            [&temperature, &k, &k_std],
        ));
        plots.push(branches(
            Plot::new(
                id("offset"),
                format!("Sensor {axis}: offset, {recording}"),
                x(),
                Dimension::linear("offset", "nT"),
            ),
            axis,
            &branch,
            [&temperature, &of(&levels.offset_nt), &of(&levels.offset_std_nt)],
        ));
    }
    plots
}

/// The thermometer that moved more, with its column.
fn moved<'a>(levels: &'a TemperatureLevels, rows: &[usize]) -> (&'static str, &'a [f64]) {
    let span = |column: &[f64]| {
        let values = rows.iter().filter_map(|row| column.get(*row)).filter(|value| value.is_finite());
        let ends = values.map(|value| [*value, *value]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        ends.map_or(0.0, |[low, high]| high - low)
    };
    if span(&levels.electronics_temperature_c) > span(&levels.sensor_temperature_c) {
        ("electronics", &levels.electronics_temperature_c)
    } else {
        ("sensor", &levels.sensor_temperature_c)
    }
}

/// Rising and falling temperature as series, over the line in the order of the run.
fn branches(mut plot: Plot, axis: Axis, branch: &[i8], [x, y, std]: [&[f64]; 3]) -> Plot {
    plot.push(Series::new("in the order taken", Mark::Dashes, 5, x, y));
    for (name, style, wanted) in [
        ("first", 3, 0),
        ("temperature had risen", axis.index(), 1),
        ("temperature had fallen", (axis.index() + 1) % 3, -1),
    ] {
        let of = |column: &[f64]| -> Vec<f64> {
            column
                .iter()
                .zip(branch)
                .filter(|(_, branch)| **branch == wanted)
                .map(|(value, _)| *value)
                .collect()
        };
        let (x, y, std) = (of(x), of(y), of(std));
        if !x.is_empty() {
            plot.push(Series::new(name, Mark::Points, style, &x, &y).with_std(&std));
        }
    }
    plot
}
