//! Sensitivity and offset of a run against the temperature that moved in it.

use common::{Axis, Quantity, TemperatureFit, TemperatureLevels, TemperatureOfPart};

use crate::number;
use crate::plot::{Dimension, Mark, Plot, Series};

/// k and O of each run against the temperature that moved in it, as they are and less their fitted curve.
///
/// With x = c ΔT + c₂ ΔT² for the sensitivity and o ΔT + o₂ ΔT² for the offset, ΔT from the reference, a
/// field is read as B (1 + x) + o ΔT + o₂ ΔT²; so k (1 + x) and O + o ΔT + o₂ ΔT² would not move.
pub fn plots(axis: Axis, fit: &TemperatureFit) -> Vec<Plot> {
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
        for (id, title, unit, y, std) in [
            ("sensitivity", "sensitivity", "ppm", ppm(changed), &k_std),
            ("sensitivity-left", "sensitivity less its curve", "ppm", ppm(left), &k_std),
            ("offset", "offset", "nT", offset, &offset_std),
            ("offset-left", "offset less its curve", "nT", offset_left, &offset_std),
        ] {
            let y_label = if unit == "ppm" { "k from the first" } else { "offset" };
            let plot = Plot::new(
                format!("temperature-{axis}-{}-{id}", number + 1),
                format!("Sensor {axis}: {title}, {what}"),
                Dimension::linear(format!("temperature of the {what}"), "°C"),
                Dimension::linear(y_label, unit),
            );
            let note = format!("{recording}; dashed: in the order taken.");
            plots.push(branches(plot.note(note), &branch, [&temperature, &y, std]));
        }
    }
    plots
}

fn value(quantity: &Option<Quantity>) -> Option<f64> {
    quantity.as_ref().map(Quantity::value)
}

/// The thermometer that moved more, with its column.
fn moved<'a>(levels: &'a TemperatureLevels, rows: &[usize]) -> (&'static str, &'a [f64]) {
    let span = |column: &[f64]| {
        let values = rows.iter().filter_map(|row| column.get(*row).copied());
        number::ends(values).map_or(0.0, |[low, high]| high - low)
    };
    if span(&levels.electronics_temperature_c) > span(&levels.sensor_temperature_c) {
        ("electronics", &levels.electronics_temperature_c)
    } else {
        ("sensor", &levels.sensor_temperature_c)
    }
}

/// Rising and falling temperature as series, over the line in the order of the run.
fn branches(mut plot: Plot, branch: &[i8], [x, y, std]: [&[f64]; 3]) -> Plot {
    plot.push(Series::new("the run", Mark::Dashes, 5, x, y));
    for (name, style, wanted) in
        [("first", 3, 0), ("temperature had risen", 1, 1), ("temperature had fallen", 0, -1)]
    {
        let of = |column: &[f64]| -> Vec<f64> {
            column
                .iter()
                .zip(branch)
                .filter(|(_, branch)| **branch == wanted)
                .map(|(value, _)| *value)
                .collect()
        };
        let (x, y, std) = (of(x), of(y), of(std));
        plot.push(Series::new(name, Mark::Points, style, &x, &y).with_std(&std));
    }
    plot
}
