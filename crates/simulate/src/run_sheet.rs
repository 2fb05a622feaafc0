//! The same plan for the person or the controller at the facility: one line a setting.

use common::Error;
use nalgebra::Matrix3;

use crate::campaign::prepare;
use crate::plan::Plan;
use crate::schedule::Scheduled;

/// A sequence of settings and the time that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSheet {
    /// As CSV.
    pub csv: String,
    /// Settings.
    pub steps: usize,
    /// From the campaign's beginning to its end, s.
    pub length_s: f64,
    /// Of that, waiting and recording, s.
    pub work_s: f64,
}

const HEAD: &str = "step,time_s,start,recording,orientation,coil_x_a,coil_y_a,coil_z_a,sensor_temperature_c,\
                    electronics_temperature_c,wait_s,readings,length_s,action";

/// The settings of a plan in order.
pub fn run_sheet(plan: &Plan) -> Result<RunSheet, Error> {
    let mut scheduled = prepare(plan)?.scheduled;
    scheduled.sort_by(|a, b| a.begins_s.total_cmp(&b.begins_s));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let failed = |error: csv::Error| Error::Request(format!("the run sheet cannot be written: {error}"));
    writer.write_record(HEAD.split(',')).map_err(failed)?;
    let (mut steps, mut length_s, mut work_s) = (0, 0.0, 0.0);
    for Scheduled { planned, begins_s, .. } in &scheduled {
        let mut time_s = *begins_s;
        let start = planned.recording.start.clone().unwrap_or_default();
        for step in &planned.steps {
            steps += 1;
            let temperature = |k: usize| step.temperatures_c.map_or(String::new(), |t| number(t[k]));
            let mut row =
                vec![steps.to_string(), number(time_s), start.clone(), planned.recording.id.clone()];
            row.push(orientation(&planned.nominal));
            row.extend(step.current_a.iter().map(|current| number(*current)));
            row.extend([temperature(0), temperature(1), number(step.wait_s)]);
            row.extend([step.readings.to_string(), number(step.length_s), step.action.clone()]);
            writer.write_record(row).map_err(failed)?;
            time_s += step.wait_s + step.length_s;
        }
        work_s += time_s - begins_s;
        length_s = f64::max(length_s, time_s);
    }
    let bytes = writer.into_inner().map_err(|error| failed(error.into_error().into()))?;
    let csv = String::from_utf8_lossy(&bytes).into_owned();
    Ok(RunSheet { csv, steps, length_s, work_s })
}

/// To a tenth of a microampere, without an exponent and without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.7}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// The nominal rotation: the GEO axis along which each SEN axis points, or its rows.
fn orientation(rotation: &Matrix3<f64>) -> String {
    let axis = |row: usize| {
        let along = (0..3).find(|column| rotation[(row, *column)].abs() > 1.0 - 1e-9)?;
        let sign = if rotation[(row, along)] > 0.0 { '+' } else { '-' };
        Some(format!("{}:{sign}{}", ["x", "y", "z"][row], ["north", "east", "down"][along]))
    };
    let axes: Option<Vec<String>> = (0..3).map(axis).collect();
    axes.map(|axes| axes.join(" ")).unwrap_or_else(|| {
        let rows: Vec<String> = (0..3)
            .map(|row| (0..3).map(|column| number(rotation[(row, column)])).collect::<Vec<_>>().join(" "))
            .collect();
        rows.join("; ")
    })
}
