//! Smooth functions of what was recorded: they find structure and describe it.

use common::Axis;
use nalgebra::Vector3;
use physics::Kind;
use physics::memory::{Before, Signal};
use rayon::prelude::*;
use std::collections::BTreeSet;

use crate::Error;
use crate::channel::{Channel, Reader, Run};
use crate::covariates::{ALONG, LOAD, PAST, RATE, TIMES, WITH_TIME, across, fields, values};
use crate::model::{Model, State};
use crate::stacked::Stacked;
use crate::waves::{half_waves, polynomial, range};
use crate::what::What;

/// Half waves over the span of time.
const WAVES: usize = 16;
/// Highest power of a covariate.
const POWERS: usize = 8;
/// Thresholds that are tried of a covariate.
const THRESHOLDS: usize = 15;
/// Moments that divide the span of time.
const MOMENTS: usize = 32;
/// How far back the past goes, in rows.
const PAST_ROWS: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
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

/// A series in each recording that has it.
pub type Series = [Option<Vec<f64>>];

/// A candidate with the columns of its shapes.
type Generic = (What, Vec<(Option<f64>, Vec<Stacked>)>);

/// All of them, or those of some names.
pub fn all(
    model: &Model<'_>,
    state: &State,
    names: Option<&BTreeSet<String>>,
) -> Result<Vec<Generic>, Error> {
    let fields = fields(model, state)?;
    let axes: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| model.reads(*axis)).collect();
    let found: Vec<Vec<Generic>> =
        axes.into_par_iter().map(|axis| of_sensor(model, axis, &fields, names)).collect();
    Ok(found.concat())
}

/// Those of one sensor.
fn of_sensor(
    model: &Model<'_>,
    axis: Axis,
    fields: &[Vec<Vector3<f64>>],
    names: Option<&BTreeSet<String>>,
) -> Vec<Generic> {
    let name = |covariate: &str| What::Smooth { covariate: covariate.into(), axis }.name();
    let is_kept = |covariate: &str| names.is_none_or(|names| names.contains(&name(covariate)));
    // What is kept, and the factors of products that are.
    let factors: BTreeSet<String> =
        names.into_iter().flatten().flat_map(|one| one.split(TIMES).map(str::to_string)).collect();
    let is_needed = |covariate: &str| {
        is_kept(covariate) || factors.contains(covariate) || factors.contains(&name(covariate))
    };
    let mut all: Vec<Generic> = Vec::new();
    let span = model.observed.span();
    if let Some(span) = span.filter(|_| is_needed("time_s")) {
        let waves = (1..=WAVES)
            .map(|k| {
                stack(model, axis, |run, channel| {
                    let at = |row: &usize| half_waves(k, run, *row, span).unwrap_or(0.0);
                    channel.rows.iter().map(at).collect()
                })
            })
            .collect();
        all.push((What::Smooth { covariate: "time_s".into(), axis }, vec![(None, waves)]));
    }
    let untimed = |run: &Run<'_>| run.time_s.is_none() && run.setting.context.rows >= ROWS;
    if is_needed("row") && model.observed.runs.iter().any(untimed) {
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
    let field = |other: Axis| if other == axis { ALONG.to_string() } else { across(other) };
    for (number, other) in Axis::ALL.into_iter().enumerate().filter(|(_, other)| is_needed(&field(*other))) {
        let values = |run: usize| fields[run].iter().map(|field| field[number]).collect::<Vec<f64>>();
        all.extend(powers(model, axis, field(other), |run| Some(values(run))));
    }
    if is_needed(&format!("{ALONG}{WITH_TIME}")) {
        all.extend(with_time(model, axis, fields, span));
    }
    for other in Axis::ALL.into_iter().filter(|other| is_needed(&format!("{PAST}{}", field(*other)))) {
        all.extend(history(model, axis, other, fields));
    }
    let recorded = model.observed.columns().into_iter().filter(|name| Kind::Empirical.takes(name));
    for covariate in KNOWN.map(str::to_string).into_iter().chain(recorded) {
        let name = covariate.as_str();
        let column = |run: usize| model.observed.runs[run].setting.context.optional(name).map(|c| c.to_vec());
        if is_needed(name) {
            all.extend(powers(model, axis, name.into(), column));
            all.extend(thresholds(model, axis, name.into(), column));
        }
        if KNOWN.contains(&name) && name.contains("temperature") && is_needed(&format!("{RATE}{name}")) {
            all.extend(rate(model, axis, name));
        }
    }
    if is_needed(LOAD) {
        all.extend(powers(model, axis, LOAD.into(), |run| values(model, fields, run, Some(axis), LOAD)));
    }
    let pairs = products(&all, &is_kept);
    all.extend(pairs);
    all.retain(|(what, _)| matches!(what, What::Smooth { covariate, .. } if is_kept(covariate)));
    all
}

/// What follows the product of two: that, and each of them.
fn products(all: &[Generic], is_kept: &dyn Fn(&str) -> bool) -> Vec<Generic> {
    let straight = all.iter().filter_map(|(what, trials)| match (what, &trials[..]) {
        (What::Smooth { covariate, axis }, [(None, columns)]) => Some((covariate, *axis, columns.first()?)),
        _ => None,
    });
    let straight: Vec<(&String, Axis, &Stacked)> =
        straight.filter(|(name, ..)| !name.ends_with(WITH_TIME)).collect();
    let pairs = straight
        .iter()
        .enumerate()
        .flat_map(|(k, one)| straight[k + 1..].iter().map(move |other| (one, other)));
    let of =
        |((name, axis, one), (of, _, other)): (&(&String, Axis, &Stacked), &(&String, Axis, &Stacked))| {
            let covariate = format!("{name}{TIMES}{of}");
            if !is_kept(&covariate) {
                return None;
            }
            let product = one.times(|channel| other.part(channel).map(<[f64]>::to_vec));
            let columns = vec![product, (*one).clone(), (*other).clone()];
            Some((What::Smooth { covariate, axis: *axis }, vec![(None, columns)]))
        };
    pairs.filter_map(of).collect()
}

/// The field along a sensor times functions of time, a sensitivity that moves: half waves, and levels before and after
/// a moment.
fn with_time(
    model: &Model<'_>,
    axis: Axis,
    fields: &[Vec<Vector3<f64>>],
    span: Option<(f64, f64)>,
) -> Vec<Generic> {
    let Some(span) = span else { return Vec::new() };
    let times = |of: &dyn Fn(&Run<'_>, usize) -> Option<f64>| {
        stack(model, axis, |run, channel| {
            let at = |row: &usize| Some(of(run, *row)? * fields[channel.run][*row][axis.index()]);
            channel.rows.iter().map(|row| at(row).unwrap_or(0.0)).collect()
        })
    };
    let waves = (1..=POWERS).map(|k| times(&|run, row| half_waves(k, run, row, span))).collect();
    let moments = (1..MOMENTS).map(|k| {
        let moment = span.0 + span.1 * k as f64 / MOMENTS as f64;
        let level = |run: &Run<'_>, row: usize| {
            let time = run.time_s?[row] + run.setting.context.clock_s;
            Some(f64::from(u8::from(time >= moment)))
        };
        (Some(moment), vec![times(&level)])
    });
    let what = What::Smooth { covariate: format!("{ALONG}{WITH_TIME}"), axis };
    vec![(what.clone(), vec![(None, waves)]), (what, moments.collect())]
}

/// What the field along or across a sensor was before: by how much it is off its own past, a first-order lag
/// of some rows, that times the field, its size and its cube.
fn history(model: &Model<'_>, axis: Axis, of: Axis, fields: &[Vec<Vector3<f64>>]) -> Option<Generic> {
    model.observed.runs.iter().find(|run| run.time_s.is_some())?;
    let largest = fields.iter().flatten().map(|field| field[of.index()].abs()).fold(0.0, f64::max);
    if largest.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let field = |run: usize| fields[run].iter().map(|field| field[of.index()] / largest).collect();
    let series: Vec<Option<Vec<f64>>> = (0..fields.len()).map(|run| Some(field(run))).collect();
    let trials = PAST_ROWS.map(|rows| {
        let past = past(model, &series, |time| rows * mean_step_s(time));
        let column = |form: fn(f64, f64) -> f64| off(model, axis, (&series, &past), form);
        let columns: Vec<Stacked> = vec![
            column(|_, off| off),
            column(|b, off| b * off),
            column(|_, off| off.abs()),
            column(|b, off| b * off.abs()),
            column(|_, off| off.powi(3)),
        ];
        (Some(rows), columns)
    });
    Some((
        What::Smooth {
            covariate: format!("{PAST}{}", if of == axis { ALONG.to_string() } else { across(of) }),
            axis,
        },
        trials.to_vec(),
    ))
}

/// How fast a temperature changes: by how much it is off its own past, and that times itself.
fn rate(model: &Model<'_>, axis: Axis, name: &str) -> Option<Generic> {
    let column = |run: &Run<'_>| {
        run.time_s?;
        run.setting.context.optional(name).map(|c| c.to_vec())
    };
    let series: Vec<Option<Vec<f64>>> = model.observed.runs.iter().map(column).collect();
    series.iter().find(|series| series.is_some())?;
    let trials = PAST_ROWS.map(|rows| {
        let past = past(model, &series, |time| rows * mean_step_s(time));
        let column = |form: fn(f64, f64) -> f64| off(model, axis, (&series, &past), form);
        (Some(rows), vec![column(|_, off| off), column(|_, off| off * off)])
    });
    Some((What::Smooth { covariate: format!("{RATE}{name}"), axis }, trials.to_vec()))
}

/// What series were before, by a first-order lag in recordings with times.
pub fn past(model: &Model<'_>, series: &Series, lag_s: impl Fn(&[f64]) -> f64) -> Vec<Option<Vec<f64>>> {
    let of = |(run, series): (&Run<'_>, &Option<Vec<f64>>)| {
        let (time, series) = (run.time_s?, series.as_ref()?);
        Some(Signal::new(time, series.clone()).lagged(lag_s(time), Before::Equilibrium))
    };
    model.observed.runs.iter().zip(series).map(of).collect()
}

/// A form of series and of how much they are off their past, in the channels of one sensor.
fn off(
    model: &Model<'_>,
    axis: Axis,
    (series, past): (&Series, &Series),
    form: fn(f64, f64) -> f64,
) -> Stacked {
    stack(model, axis, |_, channel| {
        let (Some(series), Some(past)) = (&series[channel.run], &past[channel.run]) else {
            return vec![0.0; channel.rows.len()];
        };
        let at = |row: &usize| form(series[*row], series[*row] - past[*row]);
        channel.rows.iter().map(at).map(|v| if v.is_finite() { v } else { 0.0 }).collect()
    })
}

/// Mean time from one row to the next.
pub fn mean_step_s(time: &[f64]) -> f64 {
    (time[time.len() - 1] - time[0]) / (time.len().max(2) - 1) as f64
}

/// Powers of a covariate from the first, in an orthogonal form, about its middle.
fn powers(
    model: &Model<'_>,
    axis: Axis,
    covariate: String,
    values: impl Fn(usize) -> Option<Vec<f64>>,
) -> Option<Generic> {
    let series: Vec<Option<Vec<f64>>> = (0..model.observed.runs.len()).map(values).collect();
    let range = range(series.iter().flatten().flatten())?;
    let columns = (1..=POWERS)
        .map(|k| {
            stack(model, axis, |_, channel| {
                let Some(values) = &series[channel.run] else { return vec![0.0; channel.rows.len()] };
                channel.rows.iter().map(|row| polynomial(k, values[*row], range)).collect()
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

/// A column that is something in the channels of one sensor, its projection in magnitudes, and zero in all
/// others.
fn stack(model: &Model<'_>, axis: Axis, values: impl Fn(&Run<'_>, &Channel) -> Vec<f64>) -> Stacked {
    let observed = &model.observed;
    let part = |channel: &Channel| match channel.reader {
        Reader::Sensor(own) if own == axis => Some(values(&observed.runs[channel.run], channel)),
        Reader::Magnitude => {
            let values = values(&observed.runs[channel.run], channel).into_iter().enumerate();
            Some(values.map(|(k, value)| value * channel.shares[k][axis.index()]).collect())
        }
        _ => None,
    };
    let something = |part: &Vec<f64>| part.iter().any(|value| *value != 0.0);
    Stacked::new(observed.channels.iter().map(|channel| part(channel).filter(something)).collect())
}
