//! Absolute measurements, and the baselines that are adopted between them.

use common::time::Start;
use common::{
    AbsoluteCalibration, AbsoluteSet, AdoptedBaseline, AdoptedBaselines, Document, Quantity, Recording,
};

use super::time::{Clock, earliest};
use super::{Plots, events};
use crate::number;
use crate::page::words::{key, slug};
use crate::plot::{Dimension, Mark, Plot, Point, Series, Timeline};

/// Of a normal distribution, where no other factor is stated.
const FACTOR_95: f64 = 1.96;

pub fn found(document: &Document) -> Option<&AbsoluteCalibration> {
    document.calibration.as_ref()?.absolute.as_deref()
}

/// The recording in whose time measurements and baselines are shown, and the Unix time of its start: the first of
/// the variometer, without one the first measurement.
pub fn origin(document: &Document, found: &AbsoluteCalibration) -> Option<(String, f64)> {
    let measured = || found.sets.iter().map(|set| set.recording.clone()).collect();
    let ids = if found.variometer.is_empty() { measured() } else { found.variometer.clone() };
    let dated = |recording: &Recording| Some((recording.id.clone(), recording.start()?.unix_s));
    let first = |set: &AbsoluteSet| Some((set.recording.clone(), unix_s(&set.time)?));
    earliest(document, &ids).and_then(dated).or_else(|| found.sets.first().and_then(first))
}

pub fn unix_s(moment: &str) -> Option<f64> {
    Start::parse(moment).map(|start| start.unix_s)
}

/// The baselines one above the other with ΔF below them, and how the theodolite's own errors went.
pub fn plots(plots: &mut Plots, document: &Document) {
    let Some(found) = found(document) else { return };
    let Some((recording, epoch_s)) = origin(document, found) else { return };
    let times: Vec<f64> =
        found.sets.iter().map(|set| unix_s(&set.time).map_or(f64::NAN, |time| time - epoch_s)).collect();
    let nodes: Vec<f64> = found.adopted.iter().flat_map(|adopted| nodes(adopted, epoch_s)).collect();
    let clock = Clock::of(&[times.clone(), nodes.clone()].concat());
    let (times, nodes) = (clock.times(&times), clock.times(&nodes));
    let group = recording.clone();
    let time = Timeline { recording, group, unit_s: clock.seconds, epoch_s: Some(epoch_s) };
    let plot = |id: String, title: String, y: Dimension| {
        let plot = Plot::new(id, title).axes(Dimension::linear("time", clock.unit), y);
        Plot { time: Some(time.clone()), ..plot }
    };
    let adopted = found.adopted.iter().flat_map(|adopted| &adopted.components);
    let baselines = adopted.map(|(name, adopted)| {
        let (axis, shown) = axis(name, adopted);
        let title = format!("Baseline of {}", key(name).0.to_uppercase());
        let plot = plot(format!("baseline-{}", slug(name)), title, axis);
        with_baseline(plot, document, found, (name, adopted), [&times, &nodes], shown)
    });
    let delta = delta_f(document, epoch_s, &clock).map(|series| {
        plot("delta-f".into(), "ΔF: |B| minus the scalar magnetometer".into(), "ΔF [nT]".into()).with(series)
    });
    let stacked = baselines.chain(delta).map(|plot| Plot { stacked: true, ..plot });
    plots.insert("baselines".into(), stacked.collect());
    let own = |id: &str, title: &str, y: &str, of: fn(&AbsoluteSet) -> &Quantity| {
        let values = found.sets.iter().zip(&times).map(|(set, time)| (*time, of(set)));
        plot(format!("theodolite-{id}"), title.into(), y.into())
            .with(measured("measured", 0, values, |value| value))
            .note("Bars: 95 % intervals.")
    };
    let history = [
        own("offset", "Offset of the theodolite's magnetometer", "offset [nT]", |set| &set.sensor_offset_nt),
        own("horizontal", "Its collimation, horizontal", "angle to the telescope [arcsec]", |set| {
            &set.horizontal_collimation_arcsec
        }),
        own("vertical", "Its collimation, vertical", "angle to the telescope [arcsec]", |set| {
            &set.vertical_collimation_arcsec
        }),
    ];
    plots.insert("theodolite".into(), history.into_iter().filter(|_| found.sets.len() > 1).collect());
}

/// The times of the nodes from the origin, s.
fn nodes(adopted: &AdoptedBaselines, epoch_s: f64) -> impl Iterator<Item = f64> {
    let start_s = unix_s(&adopted.start).map_or(f64::NAN, |start| start - epoch_s);
    adopted.time_s.iter().map(move |time| start_s + time)
}

/// A component's axis, and how its values are shown: a declination in minutes of arc from a whole degree.
fn axis(name: &str, adopted: &AdoptedBaseline) -> (Dimension, impl Fn(f64) -> f64 + Copy) {
    let (letter, unit) = (key(name).0.to_uppercase(), key(name).1);
    let first = adopted.value.iter().copied().find(|value| value.is_finite()).unwrap_or(0.0);
    let (axis, from, factor) = match unit.as_str() {
        "deg" => {
            let whole = first.round();
            (Dimension::linear(format!("{letter} less {}°", number::bare(whole)), "arcmin"), whole, 60.0)
        }
        _ => (Dimension::linear(letter, unit), 0.0, 1.0),
    };
    (axis, move |value| factor * (value - from))
}

fn measured<'a>(
    name: &str,
    style: usize,
    values: impl Iterator<Item = (f64, &'a Quantity)>,
    shown: impl Fn(f64) -> f64,
) -> Series {
    let point = |(x, quantity): (f64, &Quantity)| {
        let usual =
            || quantity.std().map(|std| [-1.0, 1.0].map(|side| quantity.value() + side * FACTOR_95 * std));
        let bar = quantity.interval_95().or_else(usual).map(|ends| ends.map(&shown));
        Point { x, y: shown(quantity.value()), bar }
    };
    Series { name: name.into(), mark: Mark::Points, style, points: values.map(point).collect() }
}

/// With the measurements of a component and its adopted baseline. Measurements that are not used, and so far off
/// that the others would lie flat, are counted only.
fn with_baseline(
    plot: Plot,
    document: &Document,
    found: &AbsoluteCalibration,
    (name, adopted): (&str, &AdoptedBaseline),
    [times, nodes]: [&[f64]; 2],
    shown: impl Fn(f64) -> f64 + Copy,
) -> Plot {
    let of = |name_of: &str, style: usize, used: bool| {
        let all =
            found.sets.iter().zip(times).filter(|(set, _)| adopted.not_used.contains(&set.recording) != used);
        let values = all.filter_map(|(set, time)| Some((*time, set.baseline.get(name)?)));
        measured(name_of, style, values, shown)
    };
    let mut curve = Series { name: "adopted".into(), mark: Mark::Dashes, style: 5, points: Vec::new() };
    let rows = nodes.iter().zip(adopted.value.iter().zip(&adopted.std));
    for (row, (x, (value, std))) in rows.enumerate() {
        // A step: the line begins anew.
        if row > 0 && nodes[row - 1] == *x {
            curve.points.push(Point { x: f64::NAN, y: f64::NAN, bar: None });
        }
        let ends = [-FACTOR_95, FACTOR_95].map(|factor| shown(value + factor * std));
        curve.points.push(Point { x: *x, y: shown(*value), bar: Some(ends) });
    }
    let used = of("observed", 0, true);
    let mut others = of("observed, not used", 1, false);
    let within = used.points.iter().chain(&curve.points).flat_map(|point| point.bar.unwrap_or([point.y; 2]));
    let [low, high] = number::ends(within).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let count = others.points.len();
    others.points.retain(|point| point.y > 2.0 * low - high && point.y < 2.0 * high - low);
    let off = match count - others.points.len() {
        0 => String::new(),
        off => format!(" {} not used, off the scale.", number::counted(off, "measurement")),
    };
    let columns: Vec<String> = (adopted.follows.iter())
        .map(|one| format!("{} at {}", one.column, number::significant(one.reference, 4)))
        .collect();
    let mut reduced = Series { name: "observed, reduced".into(), style: 2, ..Series::default() };
    let mut follows = String::new();
    if !columns.is_empty() {
        follows = format!(" Reduced and adopted: with {}.", columns.join(", "));
        reduced.points = (used.points.iter())
            .filter_map(|point| {
                let moment =
                    plot.time.as_ref().and_then(|time| Some(time.epoch_s? + point.x * time.unit_s))?;
                let by = shown(followed(document, found, adopted, moment)?) - shown(0.0);
                Some(Point { y: point.y - by, bar: point.bar.map(|ends| ends.map(|end| end - by)), ..*point })
            })
            .collect();
    }
    plot.with(used)
        .with(reduced)
        .with(others)
        .with(curve)
        .note(format!("Bars and band: 95 % intervals.{follows}{off}"))
}

/// What columns of the variometer, where they are known, add to a baseline at a moment.
fn followed(
    document: &Document,
    found: &AbsoluteCalibration,
    adopted: &AdoptedBaseline,
    moment: f64,
) -> Option<f64> {
    let all = adopted.follows.iter().map(|one| {
        let at = |recording: &Recording| {
            let (start, times) = (recording.start()?.unix_s, recording.column("time_s")?);
            let row = times.partition_point(|time| start + time < moment);
            let within = row > 0 && found.variometer.contains(&recording.id);
            recording.column(&one.column)?.get(row).copied().filter(|_| within)
        };
        let value = document.recordings.iter().find_map(at)?;
        Some(one.coefficient.value() * (value - one.reference))
    });
    all.sum()
}

/// ΔF of the corrected recordings of the variometer, parted at their gaps.
fn delta_f(document: &Document, epoch_s: f64, clock: &Clock) -> Option<Series> {
    let mut series = Series { name: "ΔF".into(), mark: Mark::Line, ..Series::default() };
    for recording in &document.recordings {
        let columns = recording.column("time_s").zip(recording.column("delta_f_nt"));
        let Some(((times, delta), start)) = columns.zip(recording.start()) else { continue };
        let times: Vec<f64> = times.iter().map(|time| time + start.unix_s - epoch_s).collect();
        let times = clock.times(&times);
        for rows in events::segments(recording) {
            series.append(&times[rows.clone()], &delta[rows]);
        }
    }
    (!series.points.is_empty()).then_some(series)
}
