//! Which effects a host can carry: a rule about recordings and physics, not about who finds what.
//!
//! 1. What an effect needs is recorded: coils and their currents, a station outside, tiltmeters, solar arrays
//!    and milliseconds are in no host; a temperature that moves, a field that moves, a second vector
//!    magnetometer, a working day, or a reading each ten seconds for a vehicle that passes in a minute, are
//!    in some. A sensitivity that changes, and whatever a core does with its drive, needs a field that moves
//!    by a tenth of itself: else the first is an offset by another name, and the second thousands of times
//!    what any core has.
//! 2. A fresh calibration does not take it up: of its changes at least a twentieth is left.
//! 3. Beside a scalar magnetometer its sensor has at least a tenth of the field: the length feels it.
//! 4. The strength that is wanted can be reached within a tenth, by what adds no more than the Earth's field
//!    to any reading, and the second part holds for it too.

use concealed::effect::Effect;
use concealed::kinds::{self, Single};
use concealed::scene::{Readings, SceneKind};

use crate::host::{Host, Watched};
use crate::stats::{mean, rms};

/// Least share of the changes of an effect that the refit may leave.
const LEAST_LEFT: f64 = 0.05;
/// Least share of the field that a sensor must have where the length alone is seen.
const LEAST_ALONG: f64 = 0.1;
/// The most that may be added to a reading, nT.
const MOST_NT: f64 = 60_000.0;
/// A working day with the hours before and after it, s.
const DAY_S: f64 = 85_000.0;
/// Longest step at which a vehicle is more than one reading, s.
const PASSING_S: f64 = 10.0;
/// A temperature that moves by less, from its least to its greatest, is held, K.
const HELD_K: f64 = 0.1;
/// A field whose sensors move by less of its length, from least to greatest, is no drive.
const DRIVE: f64 = 0.1;

/// What needs columns or rates that no host has.
const IN_NO_HOST: [&str; 10] = [
    "eddy_currents",
    "coil_heating",
    "coil_temperature",
    "coil_gradient",
    "nulling_leakage",
    "measured_tilt",
    "stray_current",
    "sun_thermoelectric",
    "mains",
    "traction_power",
];

/// What asks nothing of the field: an offset of a channel, or a field that is added. Offsets that follow a
/// temperature are besides.
const WITHOUT_FIELD: [&str; 8] = [
    "ageing",
    "warm_up",
    "reading_step",
    "spike",
    "quantisation",
    "dropout",
    "vehicle_pass",
    "working_hours",
];

/// What a core or an amplifier does with a drive.
const OF_THE_DRIVE: [&str; 8] = [
    "hysteresis",
    "perming",
    "quadratic_nonlinearity",
    "cubic_nonlinearity",
    "cross_field",
    "cross_field_sensitivity",
    "saturation",
    "clipping",
];

/// Kinds and forms whose inputs a host has: the first part of the rule.
pub fn kinds_of(host: &Host) -> Vec<Single> {
    kinds::ALL.into_iter().chain(kinds::FURTHER).filter(|kind| has_inputs(host, kind)).collect()
}

fn has_inputs(host: &Host, kind: &Single) -> bool {
    let name = kind.name;
    let warm = name.contains("temperature") || ["axis_creep", "pillar_tilt"].contains(&name);
    let thermometer = usize::from(name.contains("electronics"));
    let still = WITHOUT_FIELD.contains(&name) || (name.starts_with("offset_") && warm);
    // A dropout holds the value of any channel, whatever is beside it.
    let pair = kind.scene == SceneKind::Pair && name != "dropout";
    let times = &host.campaign.runs[0].times;
    let span = times.last().zip(times.first()).map_or(0.0, |(last, first)| last - first);
    !IN_NO_HOST.contains(&name)
        && (!pair || host.campaign.kind == SceneKind::Pair)
        && (!warm || goes(host, thermometer))
        && (still || host.moves)
        && (!(name.starts_with("sensitivity_") || OF_THE_DRIVE.contains(&name)) || drive(host) >= DRIVE)
        && (name != "working_hours" || span > DAY_S)
        && (name != "vehicle_pass" || host.campaign.runs[0].step_s() <= PASSING_S)
}

/// How far the fields along the sensors move, from least to greatest, over the field's length.
fn drive(host: &Host) -> f64 {
    let (run, bench) = (&host.campaign.runs[0], &host.campaign.bench);
    let fields: Vec<_> = run.times.iter().map(|t| run.field_sen(bench, *t)).collect();
    let range = |k: usize| {
        let all = || fields.iter().map(|field| field[k]);
        all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)
    };
    let longest = fields.iter().map(|field| field.norm()).fold(0.0, f64::max);
    [0, 1, 2].map(range).into_iter().fold(0.0, f64::max) / longest
}

/// Whether a thermometer was recorded, and moves.
fn goes(host: &Host, which: usize) -> bool {
    let run = &host.campaign.runs[0];
    let all = || run.times.iter().map(|t| run.temperatures[which](*t));
    all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min) > HELD_K
}

/// Whether an effect that was made shows: the second and the third part of the rule.
pub fn shows(host: &Host, effect: &Effect) -> bool {
    if host.watched == Watched::Length {
        let along = host.along();
        if effect.sensors.iter().any(|sensor| along[*sensor].abs() < LEAST_ALONG) {
            return false;
        }
    }
    stays(host, &(effect.act)(&host.campaign, &host.plain, 1.0))
}

/// Whether a fresh calibration leaves enough of what is added, and it is no more than there can be.
pub fn stays(host: &Host, added: &Readings) -> bool {
    if added.iter().flatten().flatten().any(|value| !value.is_finite() || value.abs() > MOST_NT) {
        return false;
    }
    let changes = added[0].iter().map(|column| {
        let level = mean(column);
        rms(&column.iter().map(|value| value - level).collect::<Vec<_>>())
    });
    let (changes, left) = (changes.fold(0.0, f64::max), host.size(added));
    left.is_finite() && changes > 0.0 && left >= LEAST_LEFT * changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{Beside, CANDIDATE, series};
    use std::collections::BTreeSet;

    #[test]
    fn a_host_carries_what_it_has_the_columns_for() {
        let names = |beside: &Beside| -> BTreeSet<&str> {
            let host = Host::of(&CANDIDATE, &series(beside)).expect("a host");
            kinds_of(&host).into_iter().map(|kind| kind.name).collect()
        };
        let [pair, scalar, alone] = [Beside::Vector, Beside::Scalar, Beside::Thermometer].map(|b| names(&b));
        for names in [&pair, &scalar, &alone] {
            assert!(names.contains("reading_step") && names.contains("dropout"), "{names:?}");
            for out in [
                "eddy_currents",
                "mains",
                "sensitivity_ageing",
                "hysteresis",
                "vehicle_pass",
                "working_hours",
            ] {
                assert!(!names.contains(out), "{out}");
            }
        }
        assert!(pair.contains("induction_difference") && !scalar.contains("induction_difference"));
        assert!(scalar.contains("clock_offset") && !alone.contains("clock_offset"));
        assert!(alone.contains("offset_temperature_lag") && !scalar.contains("offset_temperature_lag"));
        assert!(!alone.contains("offset_electronics_temperature"));
    }
}
