//! What temperatures and fields across do to sensitivity and offset.

use common::{Axis, CrossFieldFit, Document, Quantity, TemperatureFit, TemperatureLevels, TemperatureOfPart};
use page::words::key;

use super::effects::{self, findings};
use super::shared::{add_departures, departures};
use crate::number;
use crate::plot::{Mark, Plot, Series};
use crate::{Cell, Section, Table};

pub fn temperature(document: &Document) -> Option<Section> {
    let calibration = document.calibration.as_ref()?;
    let sensors = calibration.sensors.as_ref()?;
    let mut section = Section::new("temperature", "Temperature");
    let mut slopes = Table::new(
        "Coefficients at the reference temperature, from the whole run",
        "sensor | temperature of | k [ppm/K] | k [ppm/K²] | curvature of k, p | O [nT/K] | O [nT/K²] | \
         curvature of O, p | from [°C] | to [°C]",
    );
    let mut three_point = Table::new(
        "Slopes through the three central temperatures",
        "sensor | temperature of | k [ppm/K] | O [nT/K]",
    );
    let mut turning = Table::new(
        "Temperatures at which k or O is stationary",
        "sensor | temperature of | what | at [°C] | differences between the sensors, p",
    );
    let mut lags =
        Table::new("Lag behind the temperature", "sensor | temperature of | lag [s] | what the readings say");
    let mut looked_for = departures("sensor");
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(fit) = &sensor.temperature else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &fit.findings, &effects::sensors::TEMPERATURE, fit));
        for (what, part) in [("sensor", &fit.sensor), ("electronics", &fit.electronics)] {
            let Some(part) = part else { continue };
            let [low, high] = part.range_c;
            slopes.row((
                &name,
                what,
                &part.sensitivity_ppm_per_k,
                &part.sensitivity_ppm_per_k2,
                Cell::probability(part.sensitivity_curvature_p),
                &part.offset_nt_per_k,
                &part.offset_nt_per_k2,
                Cell::probability(part.offset_curvature_p),
                low,
                high,
            ));
            let [k, o] = ["sensitivity_ppm_per_k", "offset_nt_per_k"].map(|key| part.three_point.get(key));
            three_point.row((&name, what, k, o));
            lags.row((&name, what, &part.lag_s, part.lag.as_str()));
            for (quantity, temperature) in &part.extrema_c {
                turning.row((&name, what, quantity, temperature, Cell::Empty));
            }
        }
        add_departures(&mut looked_for, &name, &fit.departures);
        plots.push(loops(axis, fit));
    }
    for common in &calibration.common_extrema {
        let p = Cell::Probability(common.p_value);
        turning.row(("all", &common.part, &common.quantity, &common.temperature_c, p));
    }
    section.table(slopes);
    section.plots_side_by_side(plots);
    section.table(three_point);
    section.table(turning);
    section.table(lags);
    section.table(looked_for);
    (!section.items.is_empty()).then_some(section)
}

/// k and O of each run against the temperature that moved in it, as they are and less their fitted curve.
///
/// With x = c ΔT + c₂ ΔT² for the sensitivity and o ΔT + o₂ ΔT² for the offset, ΔT from the reference, a
/// field is read as B (1 + x) + o ΔT + o₂ ΔT²; so k (1 + x) and O + o ΔT + o₂ ΔT² would not move.
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
        let (part, reference) = match what {
            "sensor" => (fit.sensor.as_ref(), fit.reference_c[0]),
            _ => (fit.electronics.as_ref(), fit.reference_c[1]),
        };
        let curve = |slope: fn(&TemperatureOfPart) -> [Option<f64>; 2]| -> Vec<f64> {
            let [linear, square] = part.map_or([None; 2], slope);
            let change = |t: &f64| {
                let warmer = t - reference?;
                Some(linear? * warmer + square.unwrap_or(0.0) * warmer * warmer)
            };
            temperature.iter().map(|t| change(t).unwrap_or(f64::NAN)).collect()
        };
        let k0 = levels.sensitivity[*first];
        let ppm =
            |values: Vec<f64>| -> Vec<f64> { values.into_iter().map(|value| 1e6 * value / k0).collect() };
        let k = of(&levels.sensitivity);
        let x = curve(|part| [Some(part.sensitivity_ppm_per_k.value()), value(&part.sensitivity_ppm_per_k2)]);
        let changed = k.iter().map(|k| k - k0).collect();
        let left = k.iter().zip(x).map(|(k, x)| k * (1.0 + 1e-6 * x) - k0).collect();
        let k_std = ppm(of(&levels.sensitivity_std));
        let offset = of(&levels.offset_nt);
        let y = curve(|part| [Some(part.offset_nt_per_k.value()), value(&part.offset_nt_per_k2)]);
        let offset_left: Vec<f64> = offset.iter().zip(y).map(|(offset, y)| offset + y).collect();
        let offset_std = of(&levels.offset_std_nt);
        for (id, title, label, y, std) in [
            ("sensitivity", "sensitivity", "k from the first [ppm]", ppm(changed), &k_std),
            ("sensitivity-left", "sensitivity less its curve", "k from the first [ppm]", ppm(left), &k_std),
            ("offset", "offset", "offset [nT]", offset, &offset_std),
            ("offset-left", "offset less its curve", "offset [nT]", offset_left, &offset_std),
        ] {
            let id = format!("temperature-{axis}-{}-{id}", number + 1);
            let plot = Plot::new(id, format!("Sensor {axis}: {title}, {what}"))
                .axes(format!("temperature of the {what} [°C]").as_str(), label)
                .note(format!("{recording}; dashed: in the order taken."));
            plots.push(branches(plot, &branch, [&temperature, &y, std]));
        }
    }
    plots
}

fn value(quantity: &Option<Quantity>) -> Option<f64> {
    quantity.as_ref().map(Quantity::value)
}

/// The thermometer that moved more, with its column.
fn moved<'a>(levels: &'a TemperatureLevels, rows: &[usize]) -> (&'static str, &'a [f64]) {
    let span = |column: &[f64]| number::span(rows.iter().filter_map(|row| column.get(*row).copied()));
    if span(&levels.electronics_temperature_c) > span(&levels.sensor_temperature_c) {
        ("electronics", &levels.electronics_temperature_c)
    } else {
        ("sensor", &levels.sensor_temperature_c)
    }
}

/// Rising and falling temperature as series, over the line in the order of the run.
fn branches(plot: Plot, branch: &[i8], [x, y, std]: [&[f64]; 3]) -> Plot {
    let plot = plot.with(Series::new("the run", Mark::Dashes, 5, x, y));
    let branches = [("first", 3, 0), ("temperature had risen", 1, 1), ("temperature had fallen", 0, -1)];
    branches.into_iter().fold(plot, |plot, (name, style, wanted)| {
        let of = |column: &[f64]| -> Vec<f64> {
            let rows = column.iter().zip(branch).filter(|(_, branch)| **branch == wanted);
            rows.map(|(value, _)| *value).collect()
        };
        plot.with(Series::points(name, style, &of(x), &of(y)).with_std(&of(std)))
    })
}

/// Sensitivity and offset with fields across the sensor.
pub fn cross_field(document: &Document) -> Option<Section> {
    let sensors = document.calibration.as_ref()?.sensors.as_ref()?;
    let mut section = Section::new("cross-field", "Fields transverse to the sensor");
    let mut table = Table::new(
        "Coefficients, at 50000 nT across (and along, for the sensitivity)",
        "sensor | of | coefficient | value [nT]",
    );
    let mut tests = Table::new(
        "Significance, and the effect of the correction on held-out readings",
        "sensor | difference, p | effect, p | rms before [nT] | corrected as applied [nT] | first pass [nT] | \
         second pass [nT] | readings",
    );
    let mut leaning = Table::new(
        "Directions of the sensors towards the coil across",
        "sensor | recording | coil | angle [arcsec]",
    );
    let mut looked_for = departures("sensor");
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(fit) = &sensor.cross_field else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &fit.findings, &effects::sensors::CROSS_FIELD, fit));
        for (of, parameters) in [("offset", &fit.offset), ("sensitivity", &fit.sensitivity)] {
            for (parameter, value) in parameters {
                table.row((&name, of, key(parameter).0, value));
            }
        }
        let held_out = fit.held_out.as_ref();
        tests.row((
            &name,
            Cell::probability(fit.difference.map(|test| test.p_value)),
            Cell::probability(fit.significance.map(|test| test.p_value)),
            Cell::figures(held_out.map(|held_out| held_out.before_nt), 3),
            Cell::figures(held_out.map(|held_out| held_out.after_nt), 3),
            Cell::figures(held_out.and_then(|held_out| held_out.first_pass_nt), 3),
            Cell::figures(held_out.and_then(|held_out| held_out.second_pass_nt), 3),
            held_out.map(|held_out| held_out.readings),
        ));
        for one in &fit.misalignments {
            leaning.row((&name, &one.recording, one.coil.as_str(), &one.angle_arcsec));
        }
        add_departures(&mut looked_for, &name, &fit.departures);
        plots.push(levels_across(axis, fit).into());
    }
    section.table(table);
    section.table(tests);
    section.plots_side_by_side(plots);
    section.table(leaning);
    section.table(looked_for);
    (!section.items.is_empty()).then_some(section)
}

/// k and O against the field across, a series for each recording.
fn levels_across(axis: Axis, fit: &CrossFieldFit) -> [Plot; 2] {
    let levels = &fit.levels;
    let plot = |of: &str, label: &str| {
        Plot::new(format!("cross-field-{axis}-{of}"), format!("Sensor {axis}: {of}"))
            .axes("field across [nT]", label)
    };
    let mut sensitivity = plot("sensitivity", "k from that of the first [ppm]");
    let mut offset = plot("offset", "offset [nT]").note(
        "A straight line is the sensor's direction, which belongs to the axes; the effect is what bends it.",
    );
    let k0 = levels.sensitivity.first().copied().unwrap_or(f64::NAN);
    for (number, recording) in fit.recordings.iter().enumerate() {
        let of = |column: &[f64]| -> Vec<f64> {
            let rows = levels.recording.iter().zip(column).filter(|(of, _)| **of == number);
            rows.map(|(_, value)| *value).collect()
        };
        let across = of(&levels.across_nt);
        let k: Vec<f64> = of(&levels.sensitivity).into_iter().map(|k| 1e6 * (k / k0 - 1.0)).collect();
        let k_std: Vec<f64> = of(&levels.sensitivity_std).into_iter().map(|std| 1e6 * std / k0).collect();
        sensitivity.push(Series::points(recording, number, &across, &k).with_std(&k_std));
        let (o, o_std) = (of(&levels.offset_nt), of(&levels.offset_std_nt));
        offset.push(Series::points(recording, number, &across, &o).with_std(&o_std));
    }
    [sensitivity, offset]
}
