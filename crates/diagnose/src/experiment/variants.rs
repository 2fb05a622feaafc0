//! Recordings that a site could make instead of one that it made.

use common::{Axis, Document, Recording};
use nalgebra::{Matrix3, Rotation3, Vector3};
use physics::frames;

use crate::waves::mean_step_s;

/// Shortest time between readings, s.
const SHORTEST_S: f64 = 1e-3;
/// Drives that are tried, so many times as fast.
const RATES: [f64; 3] = [4.0, 32.0, 1000.0];
/// The slower one, with all that effects follow.
const SLOWER: f64 = 4.0;

/// Beginnings of columns of what nobody sets.
const SURROUNDINGS: [&str; 4] = ["outside_", "tilt_", "sun", "eclipse"];

/// A recording that could be made, its readings zero.
#[derive(Clone, Debug)]
pub struct Variant {
    pub words: String,
    pub recording: Recording,
}

pub fn is_reading(name: &str) -> bool {
    let reads = |prefix: &str| name.starts_with(prefix) && (name.ends_with("_nt") || name.ends_with("_v"));
    reads("sensor_") || reads("test_") || name == "reference_nt"
}

fn is_drive(name: &str) -> bool {
    name.starts_with("coil_") && name.ends_with("_a")
}

/// What could be recorded in the place of a recording in coils; nothing for one elsewhere.
pub fn variants(document: &Document, recording: &Recording) -> Vec<Variant> {
    let mut own = recording.clone();
    own.id = format!("{}-again", recording.id);
    own.procedure = common::procedure::FREE_RUN.into();
    own.start = later(recording);
    for (name, column) in &mut own.columns {
        if is_reading(name) {
            column.fill(0.0);
        }
    }
    if !own.columns.keys().any(|name| is_drive(name)) {
        return Vec::new();
    }
    if own.start.is_none() {
        // All on one clock: after the other.
        let time = own.columns.get_mut("time_s");
        time.into_iter().for_each(|time| {
            let length = time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first);
            time.iter_mut().for_each(|t| *t += 2.0 * length);
        });
    }
    let names: Vec<String> =
        own.columns.keys().filter(|name| *name != "time_s" && !is_reading(name)).cloned().collect();
    let drives: Vec<String> = names.iter().filter(|name| is_drive(name)).cloned().collect();
    let others: Vec<String> = names.iter().filter(|name| !is_drive(name)).cloned().collect();
    let moving = |name: &&String| {
        let values = &own.columns[*name];
        values.iter().any(|value| *value != values[0])
    };
    let driven = drives.iter().any(|name| moving(&name));
    let set = |name: &&String| !SURROUNDINGS.iter().any(|beginning| name.starts_with(beginning));
    let followed: Vec<String> = others.iter().filter(moving).filter(set).cloned().collect();
    let mut all = Vec::new();
    let mut add = |words: String, change: &dyn Fn(&mut Recording)| {
        let mut recording = own.clone();
        change(&mut recording);
        all.push(Variant { words, recording });
    };
    let step_s = own.column("time_s").filter(|time| !time.is_empty()).map_or(0.0, mean_step_s);
    for rate in RATES.into_iter().filter(|rate| driven && step_s / rate >= SHORTEST_S) {
        add(format!("the same drive {rate} times as fast, with all else held"), &|recording| {
            others.iter().for_each(|name| hold(recording, name, mean));
            stretch(recording, 1.0 / rate);
        });
    }
    add(format!("the same, {SLOWER} times as slowly"), &|recording| stretch(recording, SLOWER));
    if !followed.is_empty() {
        let words = || followed.join(", ");
        add(format!("{} up and back at twice the rate, with the same drive", words()), &|recording| {
            followed.iter().for_each(|name| fold(recording, name));
        });
        add(format!("{} as before, without drive", words()), &|recording| {
            drives.iter().for_each(|name| hold(recording, name, |_| 0.0));
        });
        add("the same drive with all else held".into(), &|recording| {
            followed.iter().for_each(|name| hold(recording, name, mean));
        });
    }
    for one in &followed {
        let alone = |recording: &mut Recording| {
            others.iter().filter(|name| *name != one).for_each(|name| hold(recording, name, mean));
        };
        for (words, drive) in [("the same drive", None), ("the largest drive held", Some(largest as Level))] {
            add(format!("{one} as before with {words} and all else held"), &|recording| {
                alone(recording);
                drive.iter().for_each(|level| drives.iter().for_each(|name| hold(recording, name, *level)));
            });
        }
        let words = format!("{one} up and back at twice the rate with the same drive and all else held");
        add(words, &|recording| {
            alone(recording);
            fold(recording, one);
        });
    }
    for (words, factor) in [("reversed", -1.0), ("halved", 0.5), ("doubled", 2.0)] {
        let possible = drives.iter().all(|name| within(document, &own, name, factor));
        if driven && possible {
            add(format!("the same with the drive {words}"), &|recording| {
                drives.iter().for_each(|name| times(recording, name, factor));
            });
        }
    }
    if drives.iter().filter(|name| moving(name)).count() > 1 {
        for one in drives.iter().filter(|name| moving(name)) {
            let coil = one.trim_start_matches("coil_").trim_end_matches("_a");
            add(format!("the same with coil {coil} driven alone"), &|recording| {
                drives.iter().filter(|name| *name != one).for_each(|name| hold(recording, name, |_| 0.0));
            });
        }
    }
    if let Some(now) = own.conditions.orientation {
        for axis in Axis::ALL {
            let words = format!("the same with the sensor block turned by 90° about its axis {axis}");
            add(words, &|recording| {
                let about = Vector3::ith_axis(axis.index());
                let turn = Rotation3::from_axis_angle(&about, std::f64::consts::FRAC_PI_2).into_inner();
                let turn: Matrix3<f64> = turn.map(f64::round);
                recording.conditions.orientation = Some(frames::rows(&(turn * frames::matrix(&now))));
            });
        }
    }
    all
}

type Level = fn(&[f64]) -> f64;

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn alter(recording: &mut Recording, name: &str, of: impl Fn(&[f64]) -> Vec<f64>) {
    if let Some(column) = recording.columns.get_mut(name) {
        *column = of(column).into();
    }
}

fn hold(recording: &mut Recording, name: &str, level: Level) {
    alter(recording, name, |values| vec![level(values); values.len()]);
}

fn times(recording: &mut Recording, name: &str, factor: f64) {
    alter(recording, name, |values| values.iter().map(|value| value * factor).collect());
}

/// There and back, in the same time.
fn fold(recording: &mut Recording, name: &str) {
    alter(recording, name, |values| {
        let last = values.len() - 1;
        (0..=last).map(|row| values[(2 * row).min(2 * last - 2 * row)]).collect()
    });
}

/// Times from the first on by a factor.
fn stretch(recording: &mut Recording, factor: f64) {
    alter(recording, "time_s", |times| times.iter().map(|t| times[0] + factor * (t - times[0])).collect());
}

/// Whether a drive by a factor stays within what the coil bears.
fn within(document: &Document, recording: &Recording, name: &str, factor: f64) -> bool {
    let largest = recording.columns[name].iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let bears = |axis: Axis| {
        let constant = document.calibration.as_ref()?.coil(axis)?.constant_nt_per_a.as_ref()?.value();
        let most = document.facility.as_ref()?.coils.as_ref()?.get(axis)?.max_nt?;
        Some(factor.abs() * largest * constant.abs() <= most)
    };
    let axis = Axis::ALL.into_iter().find(|axis| name == format!("coil_{axis}_a"));
    factor.abs() <= 1.0 || axis.and_then(bears).unwrap_or(false)
}

fn later(recording: &Recording) -> Option<String> {
    let last = recording.column("time_s").and_then(|time| time.last().copied()).unwrap_or(0.0);
    recording.start()?.after(last + 86_400.0).text()
}
