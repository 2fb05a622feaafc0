//! What temperatures do to sensitivity and offset.

use common::{Axis, Calibration, PerAxis, Quantity, TemperatureFit, TemperatureLevels, TemperatureOfPart};

use super::{Plots, side_by_side};
use crate::number;
use crate::plot::{Mark, Plot, Series};

pub fn plots(plots: &mut Plots, calibration: &Calibration) {
    let sensors = calibration.sensors.iter().flat_map(PerAxis::iter);
    let warm = sensors.filter_map(|(axis, sensor)| Some(loops(axis, sensor.temperature.as_deref()?)));
    plots.insert("temperature".into(), side_by_side(warm.collect()));
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
        let curve = |slope: fn(&TemperatureOfPart) -> [Option<&Quantity>; 2]| -> Vec<f64> {
            let [linear, square] =
                part.map_or([None; 2], |part| slope(part).map(|one| one.map(Quantity::value)));
            let change = |t: &f64| {
                let warmer = t - reference?;
                Some(linear? * warmer + square.unwrap_or(0.0) * warmer * warmer)
            };
            temperature.iter().map(|t| change(t).unwrap_or(f64::NAN)).collect()
        };
        let k0 = levels.sensitivity[*first];
        let ppm = |values: Vec<f64>| -> Vec<f64> { values.iter().map(|value| 1e6 * value / k0).collect() };
        let k = of(&levels.sensitivity);
        let x = curve(|part| [Some(&part.sensitivity_ppm_per_k), part.sensitivity_ppm_per_k2.as_ref()]);
        let changed = k.iter().map(|k| k - k0).collect();
        let left = k.iter().zip(x).map(|(k, x)| k * (1.0 + 1e-6 * x) - k0).collect();
        let k_std = ppm(of(&levels.sensitivity_std));
        let offset = of(&levels.offset_nt);
        let y = curve(|part| [Some(&part.offset_nt_per_k), part.offset_nt_per_k2.as_ref()]);
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
