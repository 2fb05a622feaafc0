//! In which parts of the readings the difference lies.

use common::EnergyShare;
use estimate::even::{NEAR, Places};
use estimate::sine::power_along;
use nalgebra::Vector3;

use super::places::Guilty;
use crate::channel::Channel;
use crate::covariates;
use crate::model::Model;
use crate::{Error, Outcome};

/// Regions of equal numbers of readings along time and covariates.
const REGIONS: usize = 5;
/// From the upper to the lower edge of a band.
const BAND: f64 = 4.0;
/// Fewest readings of a channel that have a spectrum.
const SPECTRUM: usize = 24;

/// The excess of the whitened squared residual over the noise, by recording, sensor, time, band and
/// covariate: of what is left when all that was found is taken out of the final fit, its calibration kept. A
/// calibration fitted without it would have spread it over all rows. Where the noise is what the residual
/// itself shows, and nothing was found, the residual's own energy.
pub(super) fn energy(
    model: &Model<'_>,
    outcome: &Outcome,
    guilty: &Guilty,
    fields: &[Vec<Vector3<f64>>],
) -> Result<Vec<EnergyShare>, Error> {
    let observed = &model.observed;
    let mut without = outcome.now.fit.state.clone();
    without.keep_effects(|number| number < outcome.base.fit.state.effects.len());
    without.singles.truncate(outcome.base.fit.state.singles.len());
    let white = outcome.now.noise.whiten(observed, &model.residual(&without)?);
    let rest = &outcome.now.look.rest;
    let noise = if rest.known == 0.0 && outcome.found.is_empty() { 0.0 } else { rest.scale() };
    let noise = noise * rest.freedom / outcome.now.fit.white.len() as f64;
    let excess = |row: usize| white[row].powi(2) - noise;
    let of_channel = |channel: &Channel| channel.range().map(excess).sum::<f64>();
    let mut all = Vec::new();
    let sums = |key: &dyn Fn(&Channel) -> String| -> Vec<(Part, f64)> {
        let mut sums: Vec<(Part, f64)> = Vec::new();
        for channel in &observed.channels {
            let part = Part::Named(key(channel));
            match sums.iter_mut().find(|(known, _)| *known == part) {
                Some((_, sum)) => *sum += of_channel(channel),
                None => sums.push((part, of_channel(channel))),
            }
        }
        sums
    };
    all.extend(shares("recording", sums(&|channel| observed.runs[channel.run].recording.id.clone())));
    all.extend(shares("sensor", sums(&|channel| channel.column.clone())));
    let channels = || guilty.channels.iter().map(|number| &observed.channels[*number]);
    let along = |values: &dyn Fn(&Channel) -> Option<Vec<f64>>| -> Vec<(f64, f64)> {
        let of = |channel: &Channel| {
            let values = values(channel)?;
            let points = channel.range().zip(&channel.rows).map(|(row, at)| (values[*at], excess(row)));
            Some(points.filter(|(x, _)| x.is_finite()).collect::<Vec<_>>())
        };
        channels().filter_map(of).flatten().collect()
    };
    all.extend(shares("time_s", regions(along(&|channel| observed.runs[channel.run].on_clock()))));
    all.extend(shares("band_hz", bands(model, channels(), &white, noise)));
    for name in &guilty.covariates {
        let values = |channel: &Channel| covariates::values(model, fields, channel.run, channel.axis(), name);
        all.extend(shares(name, regions(along(&values))));
    }
    Ok(all)
}

#[derive(Clone, Debug, PartialEq)]
enum Part {
    Named(String),
    Region([f64; 2]),
}

/// Shares of what is above the noise; none where there is one part, or nothing above it.
fn shares(by: &str, parts: Vec<(Part, f64)>) -> Vec<EnergyShare> {
    let whole: f64 = parts.iter().map(|(_, sum)| sum.max(0.0)).sum();
    if parts.len() < 2 || whole <= 0.0 {
        return Vec::new();
    }
    let share = |(part, sum): (Part, f64)| {
        let (part, range) = match part {
            Part::Named(name) => (Some(name), None),
            Part::Region(range) => (None, Some(range)),
        };
        EnergyShare { by: by.into(), part, range, share: sum.max(0.0) / whole }
    };
    parts.into_iter().map(share).collect()
}

/// Regions along a covariate: one for each value where there are few, else of equal numbers.
fn regions(mut points: Vec<(f64, f64)>) -> Vec<(Part, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let constant = points.first().zip(points.last()).is_none_or(|(first, last)| first.0 == last.0);
    if constant || points.len() < 2 * REGIONS {
        return Vec::new();
    }
    let region = |some: &[(f64, f64)]| {
        (Part::Region([some[0].0, some[some.len() - 1].0]), some.iter().map(|(_, excess)| excess).sum())
    };
    let each: Vec<(Part, f64)> = points.chunk_by(|a, b| a.0 == b.0).map(region).take(REGIONS + 1).collect();
    if each.len() <= REGIONS {
        return each;
    }
    points.chunks(points.len().div_ceil(REGIONS)).map(region).collect()
}

/// Power of the whitened residual over that of the noise in bands, from the highest down.
fn bands<'c>(
    model: &Model<'_>,
    channels: impl Iterator<Item = &'c Channel>,
    white: &[f64],
    noise: f64,
) -> Vec<(Part, f64)> {
    let mut spectrum: Vec<(f64, f64)> = Vec::new();
    for channel in channels.filter(|channel| channel.rows.len() >= SPECTRUM) {
        let Some(time) = model.observed.times(channel) else { continue };
        let even = Places::of(&time).filter(|places| places.even(NEAR) && places.count() == time.len());
        let Some(Places { step_s: step, .. }) = even else { continue };
        let points = channel.rows.len();
        let power = power_along(&time, &white[channel.range()], step, points);
        let grid = 1.0 / (points as f64 * step);
        let excess = |k: usize| 2.0 * (power[k] / points as f64 - noise);
        spectrum.extend((1..points.div_ceil(2)).map(|k| (k as f64 * grid, excess(k))));
    }
    let highest = spectrum.iter().map(|(f, _)| *f).fold(0.0, f64::max);
    let lowest = spectrum.iter().map(|(f, _)| *f).fold(f64::INFINITY, f64::min);
    let mut found = Vec::new();
    let mut above = highest * (1.0 + 1e-9);
    while above > lowest && above.is_finite() {
        let below = if above / BAND > lowest { above / BAND } else { 0.0 };
        let inside = spectrum.iter().filter(|(f, _)| (below..above).contains(f));
        found.push((Part::Region([below, above]), inside.map(|(_, excess)| excess).sum()));
        above = below;
    }
    found
}
