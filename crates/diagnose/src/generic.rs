//! Smooth functions of what was recorded: they find structure and describe it.

use common::Axis;
use nalgebra::Vector3;
use physics::Kind;
use physics::memory::{Before, Signal};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::PI;

use crate::Error;
use crate::channel::{Channel, Reader, Run};
use crate::covariates::{ALONG, LOAD, PAST, RATE, TIMES, WITH_TIME, across, fields, values};
use crate::model::{Model, State};
use crate::proposal::What;
use crate::stacked::Stacked;
use crate::waves::{half_waves, mean_step_s, polynomial, range};

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

pub type Series = [Option<Vec<f64>>];
/// A candidate with the columns of its shapes.
type Generic = (What, Vec<(Option<f64>, Vec<Stacked>)>);
/// A function of a value and of how much that is off its own past.
type Form = fn(f64, f64) -> f64;

/// All of them, or those of some names.
pub fn all(
    model: &Model<'_>,
    state: &State,
    names: Option<&BTreeSet<String>>,
) -> Result<Vec<Generic>, Error> {
    let fields = fields(model, state)?;
    let axes: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| model.reads(*axis)).collect();
    let of = |axis: Axis| Sensor { model, axis, fields: &fields }.all(names);
    let found: Vec<Vec<Generic>> = axes.into_par_iter().map(of).collect();
    Ok(found.concat())
}

/// What series were before, by a first-order lag in recordings with times.
pub fn past(model: &Model<'_>, series: &Series, lag_s: impl Fn(&[f64]) -> f64) -> Vec<Option<Vec<f64>>> {
    let of = |(run, series): (&Run<'_>, &Option<Vec<f64>>)| {
        let (time, series) = (run.time_s?, series.as_ref()?);
        Some(Signal::new(time, series.clone()).lagged(lag_s(time), Before::Equilibrium))
    };
    model.observed.runs.iter().zip(series).map(of).collect()
}

/// One sensor, with the fields in SEN that a state predicts.
struct Sensor<'m, 'a> {
    model: &'m Model<'a>,
    axis: Axis,
    fields: &'m [Vec<Vector3<f64>>],
}

impl Sensor<'_, '_> {
    fn all(&self, names: Option<&BTreeSet<String>>) -> Vec<Generic> {
        let runs = &self.model.observed.runs;
        let name = |covariate: &str| self.what(covariate).name();
        let is_kept = |covariate: &str| names.is_none_or(|names| names.contains(&name(covariate)));
        // What is kept, and the factors of products that are.
        let factors: BTreeSet<String> =
            names.into_iter().flatten().flat_map(|one| one.split(TIMES).map(str::to_string)).collect();
        let is_needed = |covariate: &str| {
            is_kept(covariate) || factors.contains(covariate) || factors.contains(&name(covariate))
        };
        let mut all: Vec<Generic> = Vec::new();
        let span = self.model.observed.span();
        if let Some(span) = span.filter(|_| is_needed("time_s")) {
            all.push(self.waves("time_s", WAVES, |k, run, row| half_waves(k, &runs[run], row, span)));
        }
        let untimed = |run: &Run<'_>| run.time_s.is_none() && run.setting.context.rows >= ROWS;
        if is_needed("row") && runs.iter().any(untimed) {
            all.push(self.waves("row", WAVES, |k, run, row| {
                let turn = PI * k as f64 / runs[run].setting.context.rows as f64;
                untimed(&runs[run]).then(|| (turn * (row as f64 + 0.5)).cos())
            }));
        }
        let fields = Axis::ALL.map(|other| if other == self.axis { ALONG.into() } else { across(other) });
        all.extend(fields.iter().filter(|name| is_needed(name)).filter_map(|name| self.powers(name)));
        if let Some(span) = span.filter(|_| is_needed(&format!("{ALONG}{WITH_TIME}"))) {
            all.extend(self.with_time(span));
        }
        for name in fields.iter().filter(|name| is_needed(&format!("{PAST}{name}"))) {
            all.extend(self.history(name));
        }
        let recorded = self.model.observed.columns().into_iter().filter(|name| Kind::Empirical.takes(name));
        for covariate in KNOWN.map(str::to_string).into_iter().chain(recorded) {
            let name = covariate.as_str();
            if is_needed(name) {
                all.extend(self.powers(name));
                all.extend(self.thresholds(name));
            }
            if KNOWN.contains(&name) && name.contains("temperature") && is_needed(&format!("{RATE}{name}")) {
                all.extend(self.rate(name));
            }
        }
        if is_needed(LOAD) {
            all.extend(self.powers(LOAD));
        }
        let pairs = products(&all, &is_kept);
        all.extend(pairs);
        all.retain(|(what, _)| matches!(what, What::Smooth { covariate, .. } if is_kept(covariate)));
        all
    }

    fn what(&self, covariate: &str) -> What {
        What::Smooth { covariate: covariate.into(), axis: self.axis }
    }

    fn series(&self, name: &str) -> Vec<Option<Vec<f64>>> {
        let of = |run: usize| values(self.model, self.fields, run, Some(self.axis), name);
        (0..self.model.observed.runs.len()).map(of).collect()
    }

    /// Functions of time, order by order.
    fn waves(
        &self,
        covariate: &str,
        orders: usize,
        at: impl Fn(usize, usize, usize) -> Option<f64>,
    ) -> Generic {
        let columns = (1..=orders).map(|k| self.column(|run, row| at(k, run, row))).collect();
        (self.what(covariate), vec![(None, columns)])
    }

    /// The field along the sensor, a sensitivity that moves: times half waves, and levels about a moment.
    fn with_time(&self, span: (f64, f64)) -> [Generic; 2] {
        let runs = &self.model.observed.runs;
        let along = |run: usize, row: usize| self.fields[run][row][self.axis.index()];
        let covariate = format!("{ALONG}{WITH_TIME}");
        let waves = self.waves(&covariate, POWERS, |k, run, row| {
            Some(half_waves(k, &runs[run], row, span)? * along(run, row))
        });
        let moments = (1..MOMENTS).map(|k| {
            let moment = span.0 + span.1 * k as f64 / MOMENTS as f64;
            let level = self.column(|run, row| {
                let time = runs[run].time_s?[row] + runs[run].setting.context.clock_s;
                Some(f64::from(u8::from(time >= moment)) * along(run, row))
            });
            (Some(moment), vec![level])
        });
        [waves, (self.what(&covariate), moments.collect())]
    }

    /// By how much a field is off its own past, that times the field, its size and its cube.
    fn history(&self, name: &str) -> Option<Generic> {
        self.model.observed.runs.iter().find(|run| run.time_s.is_some())?;
        let mut series = self.series(name);
        let largest = series.iter().flatten().flatten().map(|field| field.abs()).fold(0.0, f64::max);
        if largest.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        series.iter_mut().flatten().flatten().for_each(|field| *field /= largest);
        let forms: [Form; 5] = [
            |_, off| off,
            |b, off| b * off,
            |_, off| off.abs(),
            |b, off| b * off.abs(),
            |_, off| off.powi(3),
        ];
        Some(self.off_past(&format!("{PAST}{name}"), &series, &forms))
    }

    /// How fast a temperature changes: by how much it is off its own past, and that times itself.
    fn rate(&self, name: &str) -> Option<Generic> {
        let mut series = self.series(name);
        let runs = self.model.observed.runs.iter().zip(&mut series);
        runs.filter(|(run, _)| run.time_s.is_none()).for_each(|(_, series)| *series = None);
        series.iter().find(|series| series.is_some())?;
        let forms: [Form; 2] = [|_, off| off, |_, off| off * off];
        Some(self.off_past(&format!("{RATE}{name}"), &series, &forms))
    }

    /// Forms of series and of how much they are off their past, a first-order lag of some rows.
    fn off_past(&self, covariate: &str, series: &Series, forms: &[Form]) -> Generic {
        let trials = PAST_ROWS.map(|rows| {
            let past = past(self.model, series, |time| rows * mean_step_s(time));
            let column = |form: &Form| {
                self.column(|run, row| {
                    let (now, before) = (series[run].as_ref()?[row], past[run].as_ref()?[row]);
                    Some(form(now, now - before)).filter(|value| value.is_finite())
                })
            };
            (Some(rows), forms.iter().map(column).collect())
        });
        (self.what(covariate), trials.to_vec())
    }

    /// Powers of a covariate from the first, in an orthogonal form, about its middle.
    fn powers(&self, covariate: &str) -> Option<Generic> {
        let series = self.series(covariate);
        let range = range(series.iter().flatten().flatten())?;
        let power = |k: usize, run: usize, row: usize| Some(polynomial(k, series[run].as_ref()?[row], range));
        Some(self.waves(covariate, POWERS, power))
    }

    /// Two levels, one below a threshold of a covariate and one above, the threshold at each of some quantiles.
    fn thresholds(&self, covariate: &str) -> Option<Generic> {
        let series = self.series(covariate);
        let mut sorted: Vec<f64> = series.iter().flatten().flatten().copied().collect();
        sorted.retain(|value| value.is_finite());
        sorted.sort_by(f64::total_cmp);
        let mut at: Vec<f64> = (1..=THRESHOLDS)
            .filter_map(|k| sorted.get(k * sorted.len() / (THRESHOLDS + 1)).copied())
            .filter(|threshold| sorted.first().is_some_and(|least| threshold > least))
            .collect();
        at.dedup();
        let trial = |at: f64| {
            let level = |run: usize, row: usize| Some(f64::from(u8::from(series[run].as_ref()?[row] >= at)));
            (Some(at), vec![self.column(level)])
        };
        let trials: Vec<_> = at.into_iter().map(trial).collect();
        (!trials.is_empty()).then(|| (self.what(covariate), trials))
    }

    /// A column of a value at each row of each recording, zero where there is none: that in the channels of the sensor,
    /// its projection in magnitudes, and zero in all others.
    fn column(&self, at: impl Fn(usize, usize) -> Option<f64>) -> Stacked {
        let part = |channel: &Channel| -> Option<Vec<f64>> {
            let values = channel.rows.iter().map(|row| at(channel.run, *row).unwrap_or(0.0));
            match channel.reader {
                Reader::Sensor(own) if own == self.axis => Some(values.collect()),
                Reader::Magnitude => {
                    let shares = channel.shares.iter().map(|share| share[self.axis.index()]);
                    Some(values.zip(shares).map(|(value, share)| value * share).collect())
                }
                _ => None,
            }
        };
        let something = |part: &Vec<f64>| part.iter().any(|value| *value != 0.0);
        let channels = self.model.observed.channels.iter();
        Stacked::new(channels.map(|channel| part(channel).filter(something)).collect())
    }
}

/// What follows the product of two: that, and each of them.
fn products(all: &[Generic], is_kept: &dyn Fn(&str) -> bool) -> Vec<Generic> {
    let straight = all.iter().filter_map(|(what, trials)| match (what, &trials[..]) {
        (What::Smooth { covariate, axis }, [(None, columns)]) => Some((covariate, *axis, columns.first()?)),
        _ => None,
    });
    let straight: Vec<(&String, Axis, &Stacked)> =
        straight.filter(|(name, ..)| !name.ends_with(WITH_TIME)).collect();
    let mut found = Vec::new();
    for (k, (name, axis, one)) in straight.iter().enumerate() {
        for (of, _, other) in &straight[k + 1..] {
            let covariate = format!("{name}{TIMES}{of}");
            if is_kept(&covariate) {
                let product = one.times(|channel| other.part(channel).map(<[f64]>::to_vec));
                let columns = vec![product, (*one).clone(), (*other).clone()];
                found.push((What::Smooth { covariate, axis: *axis }, vec![(None, columns)]));
            }
        }
    }
    found
}
