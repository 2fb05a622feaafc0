//! Which effects a host can carry: a rule about recordings and physics, not about who finds what.
//!
//! 1. What an effect needs is recorded: coils and their currents, a station outside, tiltmeters, solar arrays and milliseconds are in no
//!    host; a temperature, a field that moves, a second magnetometer, or a working day are in some.
//! 2. A fresh calibration does not take it up: of its changes at least a twentieth is left.
//! 3. Beside a scalar magnetometer its sensor has at least a tenth of the field: the length feels it.
//! 4. The strength that is wanted can be reached within a tenth.

use concealed::effect::Effect;
use concealed::kinds::{self, Single};
use concealed::scene::Kind;

use crate::host::{Host, Watched, mean};
use crate::left;

/// Least share of the changes of an effect that the refit may leave.
const LEAST_LEFT: f64 = 0.05;
/// Least share of the field that a sensor must have where the length alone is seen.
const LEAST_ALONG: f64 = 0.1;
/// A working day with the hours before and after it, s.
const DAY_S: f64 = 85_000.0;
/// A temperature that moves by less, from its least to its greatest, is held, K.
const HELD_K: f64 = 0.1;

/// What no host has, by the names that need it.
const IN_NO_HOST: [&str; 11] = [
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
    // Beside zero fields alone.
    "perming",
];

/// Kinds that ask nothing of the field: an offset of a channel, or a field that is added.
const WITHOUT_FIELD: [&str; 11] = [
    "ageing",
    "warm_up",
    "reading_step",
    "spike",
    "quantisation",
    "dropout",
    "vehicle_pass",
    "working_hours",
    "offset_temperature",
    "offset_temperature_lag",
    "offset_temperature_inflection",
];

/// Kinds and forms whose inputs a host has: the first part of the rule.
pub fn kinds_of(host: &Host) -> Vec<Single> {
    kinds::ALL.into_iter().chain(kinds::FURTHER).filter(|kind| has_inputs(host, kind)).collect()
}

fn has_inputs(host: &Host, kind: &Single) -> bool {
    let name = kind.name;
    if IN_NO_HOST.contains(&name) || (kind.scene == Kind::Pair && host.campaign.kind != Kind::Pair) {
        // What holds a value is seen in any channel.
        return name == "dropout";
    }
    let thermometer = match name {
        name if name.contains("electronics_temperature") => Some(1),
        "axis_creep" | "pillar_tilt" => Some(0),
        name if name.contains("temperature") => Some(0),
        _ => None,
    };
    let without_field = WITHOUT_FIELD.contains(&name) || name.starts_with("offset_electronics_temperature");
    let times = &host.campaign.runs[0].times;
    let long = times.last().zip(times.first()).is_some_and(|(last, first)| last - first > DAY_S);
    thermometer.is_none_or(|which| goes(host, which))
        && (without_field || host.moves)
        && (name != "working_hours" || long)
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
    let added = (effect.act)(&host.campaign, &host.plain, 1.0);
    let changes = added[0].iter().map(|column| {
        let level = mean(column);
        left::rms(&column.iter().map(|value| value - level).collect::<Vec<_>>())
    });
    let (changes, left) = (changes.fold(0.0, f64::max), left::size(host, &added));
    left.is_finite() && changes > 0.0 && left >= LEAST_LEFT * changes
}
