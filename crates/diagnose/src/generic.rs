//! Smooth functions of what was recorded, and columns that no effect knows: they find structure and describe it.

use common::Axis;
use physics::memory::{Before, Signal};
use std::collections::BTreeSet;

use crate::Error;
use crate::candidates::What;
use crate::covariates::{ALONG, across, fields};
use crate::model::{Model, State};
use crate::observed::{Channel, Reader, Run};

/// Half waves over the span of time.
const WAVES: usize = 16;
/// Highest power of a covariate.
const POWERS: usize = 8;
/// Thresholds that are tried of a covariate.
const THRESHOLDS: usize = 15;
/// Lags of a dependence, as shares of the recording's length.
const LAGS: [f64; 5] = [0.0, 0.003, 0.01, 0.03, 0.1];

/// Fewest rows of a recording without times along whose rows smooth functions are taken.
const ROWS: usize = 4 * WAVES;
/// Columns that effects or procedures know, of which smooth functions are taken too.
const KNOWN: [&str; 8] = [
    "sensor_temperature_c",
    "electronics_temperature_c",
    "coil_temperature_c",
    "sun_azimuth_rad",
    "sun_azimuth_deg",
    "sun_elevation_rad",
    "sun_elevation_deg",
    "position_m",
];

/// A candidate with the columns of its shapes.
type Generic = (What, Vec<(Option<f64>, Vec<Vec<f64>>)>);

/// Columns that no effect and no chain knows.
pub fn housekeeping(model: &Model<'_>) -> Vec<String> {
    let known = |name: &str| {
        let quantities = [
            "coil_",
            "sensor_",
            "reference_",
            "test_",
            "outside_",
            "ambient_",
            "attitude_",
            "tilt_",
            "sun",
            "eclipse",
            "field_",
        ];
        quantities.iter().any(|prefix| name.starts_with(prefix))
            || ["time_s", "position", "position_m", "electronics_temperature_c"].contains(&name)
    };
    let names = model.observed.runs.iter().flat_map(|run| run.recording.columns.keys());
    let unknown: BTreeSet<&String> = names.filter(|name| !known(name)).collect();
    unknown.into_iter().cloned().collect()
}

/// All of them.
pub fn all(model: &Model<'_>, state: &State) -> Result<Vec<Generic>, Error> {
    let mut all = Vec::new();
    let span = model.observed.span();
    let fields = fields(model, state)?;
    for axis in Axis::ALL.into_iter().filter(|axis| model.reads(*axis)) {
        if let Some((from, length)) = span {
            let waves = (1..=WAVES)
                .map(|k| {
                    stack(model, axis, |run, channel| {
                        let at = |row: &usize| {
                            let time = run.time_s?[*row] + run.setting.context.clock_s;
                            Some((std::f64::consts::PI * k as f64 * (time - from) / length).cos())
                        };
                        channel.rows.iter().map(|row| at(row).unwrap_or(0.0)).collect()
                    })
                })
                .collect();
            all.push((What::Smooth { covariate: "time_s".into(), axis }, vec![(None, waves)]));
        }
        let untimed = |run: &Run<'_>| run.time_s.is_none() && run.setting.context.rows >= ROWS;
        if model.observed.runs.iter().any(untimed) {
            let waves = (1..=WAVES)
                .map(|k| {
                    stack(model, axis, |run, channel| {
                        let turn = std::f64::consts::PI * k as f64 / run.setting.context.rows as f64;
                        let at =
                            |row: &usize| if untimed(run) { (turn * (*row as f64 + 0.5)).cos() } else { 0.0 };
                        channel.rows.iter().map(at).collect()
                    })
                })
                .collect();
            all.push((What::Smooth { covariate: "row".into(), axis }, vec![(None, waves)]));
        }
        for (number, other) in Axis::ALL.into_iter().enumerate() {
            let values = |run: usize| fields[run].iter().map(|field| field[number]).collect::<Vec<f64>>();
            let name = if other == axis { ALONG.to_string() } else { across(other) };
            all.extend(powers(model, axis, name, |run| Some(values(run))));
        }
        for name in KNOWN {
            let column =
                |run: usize| model.observed.runs[run].setting.context.optional(name).map(|c| c.to_vec());
            all.extend(powers(model, axis, name.into(), column));
            all.extend(thresholds(model, axis, name.into(), column));
        }
        for name in housekeeping(model) {
            let lags: &[f64] = if name.ends_with("_a") { &LAGS[1..] } else { &LAGS };
            let mut trials = Vec::new();
            for share in lags {
                let lag_s = share * span.map_or(0.0, |(_, length)| length);
                let column = following(model, axis, &name, lag_s);
                trials.push((Some(lag_s), vec![column]));
                if span.is_none() {
                    break;
                }
            }
            let column =
                |run: usize| model.observed.runs[run].setting.context.optional(&name).map(|c| c.to_vec());
            all.extend(powers(model, axis, name.clone(), column));
            all.extend(thresholds(model, axis, name.clone(), column));
            all.push((What::Dependence { column: name, axis }, trials));
        }
    }
    Ok(all)
}

/// A recorded column through a first-order lag, in the channels of one sensor.
pub fn following(model: &Model<'_>, axis: Axis, name: &str, lag_s: f64) -> Vec<f64> {
    stack(model, axis, |run, channel| follows(run, channel, name, lag_s))
}

/// A column through a first-order lag, at a channel's rows; zero where it is not recorded.
fn follows(run: &Run<'_>, channel: &Channel, name: &str, lag_s: f64) -> Vec<f64> {
    let Some(values) = run.setting.context.optional(name) else { return vec![0.0; channel.rows.len()] };
    let lagged = match run.time_s {
        Some(time) if lag_s > 0.0 => Signal::new(time, values.to_vec()).lagged(lag_s, Before::Equilibrium),
        _ => values.to_vec(),
    };
    channel.rows.iter().map(|row| if lagged[*row].is_finite() { lagged[*row] } else { 0.0 }).collect()
}

/// Powers of a covariate from the first, in an orthogonal form, about its middle.
fn powers(
    model: &Model<'_>,
    axis: Axis,
    covariate: String,
    values: impl Fn(usize) -> Option<Vec<f64>>,
) -> Option<Generic> {
    let series: Vec<Option<Vec<f64>>> = (0..model.observed.runs.len()).map(values).collect();
    let known = || series.iter().flatten().flatten().filter(|value| value.is_finite());
    let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if high.partial_cmp(&low) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let columns = (1..=POWERS)
        .map(|k| {
            stack(model, axis, |_, channel| {
                let Some(values) = &series[channel.run] else { return vec![0.0; channel.rows.len()] };
                let at = |row: &usize| {
                    let x = (2.0 * values[*row] - low - high) / (high - low);
                    if x.is_finite() { (k as f64 * x.clamp(-1.0, 1.0).acos()).cos() } else { 0.0 }
                };
                channel.rows.iter().map(at).collect()
            })
        })
        .collect();
    Some((What::Smooth { covariate, axis }, vec![(None, columns)]))
}

/// Two levels, one below a threshold of a covariate and one above, the threshold at each of some quantiles.
fn thresholds(
    model: &Model<'_>,
    axis: Axis,
    covariate: String,
    values: impl Fn(usize) -> Option<Vec<f64>>,
) -> Option<Generic> {
    let series: Vec<Option<Vec<f64>>> = (0..model.observed.runs.len()).map(values).collect();
    let mut sorted: Vec<f64> = series.iter().flatten().flatten().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let mut at: Vec<f64> = (1..=THRESHOLDS)
        .filter_map(|k| sorted.get(k * sorted.len() / (THRESHOLDS + 1)).copied())
        .filter(|threshold| sorted.first().is_some_and(|least| threshold > least))
        .collect();
    at.dedup();
    let column = |threshold: f64| {
        stack(model, axis, |_, channel| {
            let Some(values) = &series[channel.run] else { return vec![0.0; channel.rows.len()] };
            channel.rows.iter().map(|row| f64::from(u8::from(values[*row] >= threshold))).collect()
        })
    };
    let trials: Vec<_> = at.into_iter().map(|threshold| (Some(threshold), vec![column(threshold)])).collect();
    (!trials.is_empty()).then_some((What::Smooth { covariate, axis }, trials))
}

/// A column that is something in the channels of one sensor, its projection in magnitudes, and zero in all others.
fn stack(model: &Model<'_>, axis: Axis, values: impl Fn(&Run<'_>, &Channel) -> Vec<f64>) -> Vec<f64> {
    let observed = &model.observed;
    let mut column = Vec::with_capacity(observed.rows);
    for channel in &observed.channels {
        match channel.reader {
            Reader::Sensor(own) if own == axis => column.extend(values(&observed.runs[channel.run], channel)),
            Reader::Magnitude => {
                let values = values(&observed.runs[channel.run], channel);
                column.extend(
                    values.iter().enumerate().map(|(k, value)| value * channel.shares[k][axis.index()]),
                );
            }
            _ => column.extend(std::iter::repeat_n(0.0, channel.rows.len())),
        }
    }
    column
}
