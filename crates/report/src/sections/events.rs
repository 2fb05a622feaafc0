//! Gaps, steps and spikes of a recording that no program has read, as its times and readings alone show them.

use crate::page::words::{counted, key};
use crate::page::{Cell, Place};
use common::Recording;
use estimate::cadence::Cadence;
use estimate::events::{MEMORY, Search, Shape};
use estimate::spectrum::welch;
use minijinja::{Value, context};
use std::ops::Range;

use crate::number;

/// Told from so many of its standard uncertainties on, beside the recording's own spectrum: natural variations
/// are not normally distributed.
const STRIKING: f64 = 10.0;
const SEGMENT: usize = 512;
/// An interval of more usual ones is a gap.
const GAP: f64 = 1.5;
/// Rows about an event in which another is the same.
const NEAR: usize = 10;
/// Share of the ratio of an event from which another one in the memory of the filter is more than its echo.
const ECHO: f64 = 0.3;
/// So many of a kind are listed, the largest.
const MOST: usize = 12;

struct Event {
    shape: Shape,
    row: usize,
    column: String,
    size: f64,
    ratio: f64,
}

/// The usual interval of some times, and the first row after each gap.
fn gaps(time: &[f64]) -> Option<(f64, Vec<usize>)> {
    let usual_s = Cadence::of(time)?.usual_s;
    if usual_s <= 0.0 {
        return None;
    }
    let after = (1..time.len()).filter(|row| time[*row] - time[row - 1] > GAP * usual_s);
    Some((usual_s, after.collect()))
}

pub fn segments(recording: &Recording) -> Vec<Range<usize>> {
    let gaps = recording.column("time_s").and_then(gaps).map(|(_, gaps)| gaps).unwrap_or_default();
    between(&gaps, recording.rows())
}

fn between(gaps: &[usize], rows: usize) -> Vec<Range<usize>> {
    let starts = std::iter::once(0).chain(gaps.iter().copied());
    let ends = gaps.iter().copied().chain(std::iter::once(rows));
    starts.zip(ends).map(|(from, to)| from..to).collect()
}

/// How many gaps there are, and the rows of the table of gaps, steps and spikes.
pub fn of(recording: &Recording) -> (usize, Vec<Value>) {
    let time = recording.column("time_s").unwrap_or_default();
    let Some((usual_s, gaps)) = gaps(time) else { return (0, Vec::new()) };
    let segments = between(&gaps, time.len());
    let interval = |row: usize| time[row] - time[row - 1];
    let row = |what: String, size: String, time_s: [f64; 2]| {
        let place = Cell::Placed(what, Place::new(&recording.id, time_s));
        let moment = recording.start().and_then(|start| start.after(time_s[0]).text());
        let at = moment.unwrap_or_else(|| format!("{} s", number::bare(time_s[0])));
        context! { recording => recording.id, what => Value::from_object(place), size, at }
    };
    let count = gaps.len();
    let mut longest = gaps;
    longest.sort_by(|a, b| interval(*b).total_cmp(&interval(*a)));
    let gaps = longest.into_iter().take(MOST).map(|after| {
        let missing = (interval(after) / usual_s).round() as usize - 1;
        row("gap".into(), counted(missing, "row"), [time[after - 1], time[after]])
    });
    let mut events: Vec<Event> = Vec::new();
    for name in recording
        .columns
        .keys()
        .filter(|name| ["nt", "v"].iter().any(|unit| name.ends_with(&format!("_{unit}"))))
    {
        let values = recording.column(name).unwrap_or_default();
        let rows = segments.iter().cloned();
        events.extend(rows.flat_map(|rows| striking(name, values, rows, usual_s)));
    }
    events.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    let events = events.iter().take(MOST).map(|event| {
        let (column, unit) = key(&event.column);
        let shape = if event.shape == Shape::Step { "step" } else { "spike" };
        let size = format!("{} {unit}", number::significant(event.size, 3));
        row(format!("{shape} of {column}"), size, [time[event.row]; 2])
    });
    (count, gaps.chain(events).collect())
}

/// The steps and spikes of a column within some rows, the largest of neighbours.
fn striking(column: &str, values: &[f64], rows: Range<usize>, step_s: f64) -> Vec<Event> {
    let first = rows.start;
    let Some(series) = filled(&values[rows]) else { return Vec::new() };
    let Ok(spectrum) = welch(&series, step_s, SEGMENT.min(series.len() / 4)) else { return Vec::new() };
    let least = spectrum.density.iter().copied().fold(0.0, f64::max) * 1e-12;
    let density = |frequency: f64| {
        let bin = spectrum.frequency_hz.partition_point(|known| *known < frequency);
        spectrum.density[bin.min(spectrum.density.len() - 1)].max(least)
    };
    let Ok(search) = Search::new(&series, step_s, &density) else { return Vec::new() };
    let mut found: Vec<Event> = Vec::new();
    for shape in [Shape::Spike, Shape::Step] {
        for row in 0..series.len() {
            let ratio = search.ratio(shape, row).abs();
            if ratio > STRIKING {
                let (size, _) = search.size(shape, row);
                found.push(Event { shape, row: first + row, column: column.into(), size, ratio });
            }
        }
    }
    found.sort_by(|a, b| b.ratio.total_cmp(&a.ratio));
    let mut kept: Vec<Event> = Vec::new();
    for event in found {
        if kept.len() < MOST && kept.iter().all(|other| stands_beside(&event, other)) {
            kept.push(event);
        }
    }
    kept
}

/// Whether an event is not the echo of a larger one in the filter.
fn stands_beside(event: &Event, larger: &Event) -> bool {
    let distance = larger.row.abs_diff(event.row);
    distance > MEMORY || (distance > NEAR && event.ratio > ECHO * larger.ratio)
}

/// A series whose missing values are those before them; None of few or constant ones.
fn filled(values: &[f64]) -> Option<Vec<f64>> {
    let mut last = values.iter().copied().find(|value| value.is_finite())?;
    let hold = |value: &f64| {
        if value.is_finite() {
            last = *value;
        }
        last
    };
    let series: Vec<f64> = values.iter().map(hold).collect();
    (series.len() >= 8 * NEAR && number::span(series.iter().copied()) > 0.0).then_some(series)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_and_a_step_are_told_and_noise_is_not() {
        let mut state = 1977_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let quiet: Vec<f64> = (0..4000).map(|row| noise() + (f64::from(row) / 300.0).sin()).collect();
        assert!(striking("sensor_x_nt", &quiet, 0..4000, 1.0).is_empty());
        let mut marked = quiet;
        marked[1000] += 20.0;
        marked[3000..].iter_mut().for_each(|value| *value += 15.0);
        let mut found: Vec<(usize, Shape)> = striking("sensor_x_nt", &marked, 0..4000, 1.0)
            .iter()
            .map(|event| (event.row, event.shape))
            .collect();
        found.sort_by_key(|(row, _)| *row);
        assert_eq!(found, [(1000, Shape::Spike), (3000, Shape::Step)]);
    }
}
