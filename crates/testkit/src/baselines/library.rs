//! Simple regressors of one sensor's residual, and the effects they stand for.

use super::{Regression, Series};

const AXES: [&str; 3] = ["x", "y", "z"];

/// What a regressor stands for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Term {
    /// Where one sensor alone shows it; None: it counts for all.
    pub of_one: Option<String>,
    /// Where several sensors show it.
    pub of_all: String,
}

struct Library {
    axis: usize,
    columns: Vec<Vec<f64>>,
    terms: Vec<Term>,
}

impl Library {
    fn own(&mut self, effect: &str, column: Vec<f64>) {
        let name = format!("{effect} {}", AXES[self.axis]);
        self.columns.push(column);
        self.terms.push(Term { of_one: Some(name.clone()), of_all: name });
    }

    fn common(&mut self, one: Option<&str>, all: &str, column: Vec<f64>) {
        let of_one = one.map(|one| format!("{one} {}", AXES[self.axis]));
        self.columns.push(column);
        self.terms.push(Term { of_one, of_all: all.into() });
    }
}

/// The residual of a sensor, with an offset and the three readings always in, and what may be chosen: powers and products of the
/// fields, temperatures and their squares, alone and times the fields, time, the field's rate, and every other column.
pub(super) fn of_sensor(recordings: &[Series], axis: usize) -> (Regression, Vec<Term>) {
    let stacked = |of: &dyn Fn(&Series) -> Vec<f64>| -> Vec<f64> { recordings.iter().flat_map(of).collect() };
    let names: Vec<&String> = recordings[0].columns.keys().collect();
    let find = |name: &str| recordings[0].columns.contains_key(name);
    let column = |name: &str| stacked(&|series: &Series| series.columns[name].clone());
    let kind = if find("test_x_nt") { "test" } else { "sensor" };
    let reading = |axis: usize| format!("{kind}_{}_nt", AXES[axis]);
    let predicted = |axis: usize| stacked(&|series: &Series| series.predicted[axis].clone());
    let residual: Vec<f64> = column(&reading(axis)).iter().zip(predicted(axis)).map(|(a, b)| a - b).collect();
    let fields: Vec<Vec<f64>> = (0..3).map(|k| scaled(predicted(k))).collect();
    let (own, first, second) = (&fields[axis], &fields[(axis + 1) % 3], &fields[(axis + 2) % 3]);
    let time = scaled(column("time_s"));
    let rate = scaled(stacked(&|series: &Series| slope(&series.columns["time_s"], &series.predicted[axis])));

    let mut library = Library { axis, columns: Vec::new(), terms: Vec::new() };
    library.own("quadratic_nonlinearity", product(own, own));
    library.own("cubic_nonlinearity", product(&product(own, own), own));
    for across in [product(first, first), product(second, second), product(first, second)] {
        library.own("cross_field", across);
    }
    for across in [product(own, first), product(own, second)] {
        library.own("cross_field_sensitivity", across);
    }
    for (name, offset, sensitivity) in [
        ("sensor_temperature_c", Some("offset_temperature"), "sensitivity_temperature"),
        (
            "electronics_temperature_c",
            Some("offset_electronics_temperature"),
            "sensitivity_electronics_temperature",
        ),
        ("coil_temperature_c", None, "coil_temperature"),
    ] {
        if !find(name) {
            continue;
        }
        let warm = scaled(column(name));
        if let Some(offset) = offset {
            library.own(offset, warm.clone());
            library.own(offset, product(&warm, &warm));
        }
        library.own(sensitivity, product(own, &warm));
        library.own(sensitivity, product(own, &product(&warm, &warm)));
        if name == "sensor_temperature_c" {
            for across in [first, second] {
                let column = product(across, &warm);
                if kind == "test" {
                    library.common(None, "pillar_tilt", column)
                } else {
                    library.own("axis_temperature", column)
                }
            }
        }
    }
    library.own("ageing", time.clone());
    library.own("sensitivity_ageing", product(own, &time));
    library.common(
        Some("delay"),
        if kind == "test" { "induction_difference" } else { "clock_offset" },
        rate.clone(),
    );
    library.common(None, "clock_rate", product(&rate, &time));
    for name in names {
        let known = ["time_s", "sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c"];
        let readings = (0..3).any(|k| *name == reading(k))
            || name.starts_with("reference_")
            || name.starts_with("coil_");
        if known.contains(&name.as_str()) || readings {
            continue;
        }
        let values = scaled(column(name));
        match name.as_str() {
            "tilt_x_rad" | "tilt_y_rad" => {
                for field in &fields {
                    library.common(None, "measured_tilt", product(field, &values));
                }
            }
            "wheel_hz" => library.common(None, "reaction_wheel wheel_hz", values),
            "sunlit" | "sun_azimuth_rad" | "sun_elevation_rad" => {
                library.common(None, "sun_thermoelectric", values)
            }
            outside if outside.starts_with("outside_") => library.common(None, "nulling_leakage", values),
            other => library.common(None, &format!("stray_current {other}"), values),
        }
    }
    let always = [vec![1.0; residual.len()]].into_iter().chain(fields.iter().cloned()).collect();
    (Regression::new(residual, always, library.columns), library.terms)
}

/// About the mean, the largest one.
fn scaled(mut values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let largest = values.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
    if largest > 0.0 {
        values.iter_mut().for_each(|value| *value = (*value - mean) / largest);
    }
    values
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}

/// Differences over both neighbours.
fn slope(time: &[f64], values: &[f64]) -> Vec<f64> {
    (0..time.len())
        .map(|row| {
            let (from, to) = (row.saturating_sub(1), (row + 1).min(time.len() - 1));
            (values[to] - values[from]) / (time[to] - time[from])
        })
        .collect()
}
