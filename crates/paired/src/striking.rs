//! What is striking in what is left of a pair: lines, steps, and what repeats along a reading.

use estimate::sine::{Series, Strongest, strongest};
use estimate::{Error, dot, stats};
use explain::{Explained, Problem};

use crate::courses::{Acting, Sensors, Uneven, bit, coarse, range, waves};
use crate::left::{Left, basis, without};
use crate::problem::ALIKE;
use crate::steps::steps;

/// Periods of a line that must have been seen: fewer are a course of the day or of what is repeated.
const CYCLES: f64 = 10.0;
/// Lines looked at for each that may be told.
const TRIED: usize = 2;
/// Frequencies tried for each Fourier frequency.
const OVERSAMPLED: usize = 3;
/// What is as strong by chance in so many searches is weighed.
const BY_CHANCE: f64 = 0.01;
/// Most cells along a reading, and cells in the shortest period.
const CELLS: usize = 1 << 18;
const FINE: f64 = 2.0;
/// Period over the standard deviation of what is left below which codes do not show.
const BLURRED: f64 = 2.0;
/// Periods that a reading must go through.
const PERIODS: f64 = 2.5;
/// Widths tried about one that was found, to either side, over the distance in which all codes slip by one.
const WIDTHS: i32 = 32;
/// Phases of a bit that are tried.
const PHASES: i32 = 16;

/// Lines and steps, at most so many of each, and what repeats along the reading in which most does, each with the number
/// of alike ones among which it was found.
/// Refused: times out of order.
pub fn striking(
    problem: &Problem,
    sensors: &Sensors,
    explained: &Explained,
    most: usize,
) -> Result<Vec<(Acting, f64)>, Error> {
    let all = (0..problem.channels.len()).map(|channel| Left::of(problem, sensors, explained, channel));
    let Some(mut all) = all.collect::<Result<Option<Vec<Left<'_>>>, Error>>()? else { return Ok(Vec::new()) };
    let mut found: Vec<(Acting, f64)> = Vec::new();
    let codes = (0..sensors.count()).filter_map(|sensor| {
        let along = sensors.predicted(problem, sensor, &explained.residual);
        codes(sensors, sensor, &along, &all[sensors.channel(sensor).unwrap_or(0)])
    });
    found.extend(codes.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, codes)| codes).unwrap_or_default());
    found.extend(steps(problem, &all, most));
    // Each line beside those before it, told or not.
    let mut lines = 0;
    for _ in 0..TRIED * most {
        let Some(line) = line(problem, &all).filter(|_| lines < most) else { break };
        if line.is_own {
            found.push((Acting::Line(line.frequency), line.looks));
            lines += 1;
        }
        let waves = basis(waves(&problem.time_s, line.frequency));
        all.iter_mut().for_each(|of| waves.iter().for_each(|wave| without(&mut of.white, wave)));
    }
    Ok(found)
}

/// The strongest line, where the engine may name it.
struct Line {
    frequency: f64,
    /// Among how many it was found.
    looks: f64,
    /// It is neither a share of the field, as noise of the reference leaves one, nor a part of something that is known
    /// and has more of it.
    is_own: bool,
}

/// Noise of the reference leaves a share of the field within a standard deviation of [`ALIKE`].
fn line(problem: &Problem, all: &[Left<'_>]) -> Option<Line> {
    let (step_s, length_s) = (problem.step_s(), problem.length_s());
    let weight = 2.0 / problem.rows() as f64;
    let series: Vec<Series<'_>> =
        all.iter().map(|own| Series { x: problem.time_s.clone(), y: &own.white, weight }).collect();
    let points = (2 * OVERSAMPLED * (length_s / step_s) as usize).next_power_of_two();
    let found = strongest(&series, 0.5 * step_s, points, (CYCLES / length_s, 0.5 / step_s))?;
    let looks = found.band * length_s;
    let waves = waves(&problem.time_s, found.frequency);
    let size = |[sine, cosine]: [f64; 2]| sine.hypot(cosine);
    let own = |of: &Left<'_>| waves.each_ref().map(|wave| dot(wave, &of.white));
    let beyond: f64 = all
        .iter()
        .map(|of| {
            let ([sine, cosine], [s, c]) = (own(of), of.wave_of(&waves, &of.field).map(|part| ALIKE * part));
            let along = (sine * s + cosine * c).powi(2) / (weight.recip() + s * s + c * c);
            weight * (sine * sine + cosine * cosine - along)
        })
        .sum();
    let most = all.iter().max_by(|a, b| size(own(a)).total_cmp(&size(own(b))))?;
    let less = |series: &[f64]| size(most.wave_of(&waves, series)) < size(own(most));
    let by_chance = looks * stats::chi_squared_p(beyond, 2.0 * all.len() as f64);
    let is_own = by_chance < BY_CHANCE && most.parts.iter().all(|part| less(part));
    let powers: Vec<f64> = all.iter().map(|of| weight * size(own(of)).powi(2)).collect();
    let odds = explain::odds(&powers, 2, problem.rows(), problem.causes().len()) - looks.ln();
    (odds > 0.0).then_some(Line { frequency: found.frequency, looks, is_own })
}

/// What repeats along a sensor's reading: by how much it lowers the sum of squares, and what it may be.
fn codes(
    sensors: &Sensors,
    sensor: usize,
    along: &[f64],
    of: &Left<'_>,
) -> Option<(f64, Vec<(Acting, f64)>)> {
    // C⁻¹ r, so that its product with a column is that of both whitened.
    let y: Vec<f64> = of.filter.whiten_transposed(&of.white);
    let Strongest { frequency, band, .. } = repeats(along, of.left, &y)?;
    let looks = band * range(along) * sensors.count() as f64;
    let period_nt = 1.0 / frequency;
    let gain = explained(waves(along, frequency).iter().map(|wave| of.filter.whiten(wave)), &of.white);
    if looks * stats::chi_squared_p(gain, 2.0) >= BY_CHANCE {
        return None;
    }
    let slip = period_nt / range(along) * period_nt;
    let near: Vec<f64> =
        (-WIDTHS..=WIDTHS).map(|k| period_nt + slip * f64::from(k) / f64::from(WIDTHS)).collect();
    let fit = |column: Vec<f64>| dot(&column, &y) / dot(&column, &column).sqrt();
    let mut best = (f64::NEG_INFINITY, (period_nt, 0.0));
    for width in &near {
        for from in (0..PHASES).map(|k| f64::from(k) / f64::from(PHASES)) {
            let fit = fit(bit(along, *width, from));
            if fit > best.0 {
                best = (fit, (*width, from));
            }
        }
    }
    let mut found = vec![(Acting::Uneven(sensor, Uneven { period_nt, bit: best.1 }), looks)];
    // Beside a magnitude only the readings themselves are known, not what they were rounded from.
    if sensors.channel(sensor).is_some() {
        let fits = near.iter().map(|width| (fit(coarse(along, *width)), *width));
        found.extend(
            fits.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, width)| (Acting::Coarse(sensor, width), looks)),
        );
    }
    Some((gain, found))
}

/// What is strongest along a reading.
fn repeats(along: &[f64], left: &[f64], y: &[f64]) -> Option<Strongest> {
    let changes: f64 = left.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    let std = (changes.min(2.0 * dot(left, left)) / (2.0 * left.len() as f64)).sqrt();
    let (range, longest) = (range(along), range(along) / PERIODS);
    let shortest = (BLURRED * std).max(2.0 * FINE * range / CELLS as f64);
    if !(range > 0.0 && longest > 2.0 * shortest) {
        return None;
    }
    let cell = shortest / FINE;
    let points = ((2.0 * range / cell).ceil() as usize).next_power_of_two();
    let series = [Series { x: along.to_vec(), y, weight: 2.0 / left.len() as f64 }];
    strongest(&series, cell, points, (1.0 / longest, 1.0 / shortest))
}

/// By how much columns lower the sum of squares of white readings.
fn explained(columns: impl Iterator<Item = Vec<f64>>, y: &[f64]) -> f64 {
    basis(columns).iter().map(|one| dot(one, y).powi(2)).sum()
}
