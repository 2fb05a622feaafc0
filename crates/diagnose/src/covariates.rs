//! What the difference may be plotted against: columns, and the fields in SEN that a sensor feels.

use common::Axis;
use nalgebra::Vector3;
use physics::{Acts, EffectInstance, Family, Kind, Place};

use crate::Error;
use crate::model::{Model, State};

pub const ALONG: &str = "the field along it";

/// What stands before the field whose past something follows.
pub const PAST: &str = "the past of ";

/// What stands before a temperature whose rate something follows.
pub const RATE: &str = "the rate of ";

/// What stands behind something that goes with time too.
pub const WITH_TIME: &str = ", with time";

/// What stands between two whose product something follows.
pub const TIMES: &str = " times ";

/// The sum of the sizes of all coil currents: what the supply delivers.
pub const LOAD: &str = "the sum of the coil currents";

/// The field across a sensor, along another.
pub fn across(other: Axis) -> String {
    format!("the transverse field ({other})")
}

/// Whether a name is of the field along or across a sensor.
pub fn is_field(name: &str) -> bool {
    name == ALONG || Axis::ALL.into_iter().any(|axis| name == across(axis))
}

/// Whether a name is of a field across a sensor, or of its past.
pub fn is_across(name: &str) -> bool {
    Axis::ALL.into_iter().any(|other| name.contains(&across(other)))
}

/// What kind of physics it is to follow something.
pub fn family(covariate: &str) -> Family {
    if let Some((one, other)) = covariate.split_once(TIMES) {
        let own = family(one);
        return if own == family(other) { own } else { Family::FollowsColumn };
    }
    match covariate {
        LOAD => Family::OwnField,
        name if name.strip_prefix(PAST).is_some_and(is_field) => Family::LateResponse,
        name if is_field(name) => Family::OwnField,
        "position_m" => Family::Position,
        "time_s" | "row" => Family::Time,
        name if name.ends_with(WITH_TIME) => Family::Time,
        _ => Family::FollowsColumn,
    }
}

/// What structure follows, as the effect `empirical` has it: the name of the covariate, the column, and whether by how
/// much it is off its own past; None for what the effect does not have.
pub fn followed(covariate: &str, sensor: Axis) -> Option<(&str, String, bool)> {
    let past = covariate.strip_prefix(PAST).or_else(|| covariate.strip_prefix(RATE));
    let name = past.unwrap_or(covariate);
    let own = |name: &str| {
        let across = Axis::ALL.into_iter().find(|axis| name == across(*axis));
        match across.or((name == ALONG).then_some(sensor)) {
            Some(axis) => Some(format!("field_{axis}")),
            None if name == LOAD => Some("coils_a".into()),
            None if name.ends_with(WITH_TIME) || ["row", "position_m"].contains(&name) => None,
            None => Some(name.to_string()),
        }
    };
    let columns: Option<Vec<String>> = name.split(TIMES).map(own).collect();
    Some((name, columns?.join("*"), past.is_some()))
}

/// What is known of the Sun.
pub const SUN: [&str; 6] =
    ["sun_azimuth_rad", "sun_azimuth_deg", "sun_elevation_rad", "sun_elevation_deg", "sunlit", "eclipse"];

/// What an effect's contribution follows, of what was recorded of the Sun no more than that.
pub fn recorded(model: &Model<'_>, effect: &EffectInstance) -> Vec<String> {
    let there = |name: &String| {
        let mut runs = model.observed.runs.iter();
        !SUN.contains(&name.as_str()) || runs.any(|run| run.setting.context.optional(name).is_some())
    };
    of(effect).into_iter().filter(there).collect()
}

pub fn of(effect: &EffectInstance) -> Vec<String> {
    let needs = effect.kind.about().needs;
    let columns = needs.iter().filter(|need| **need != "time_s" && !need.contains([' ', '.']));
    let mut names: Vec<String> =
        columns.map(|need| (*need).to_string()).chain(effect.column.clone()).collect();
    match (effect.kind, effect.axis) {
        (
            Kind::CrossField | Kind::CrossFieldSensitivity | Kind::AxisTemperature | Kind::AxisCreep,
            Some(own),
        ) => {
            names.extend(Axis::ALL.into_iter().filter(|axis| *axis != own).map(across));
        }
        (_, Some(axis)) if on_coil(effect) => names.push(format!("coil_{axis}_a")),
        (kind, Some(_)) if names.is_empty() && needs.is_empty() && kind.place() != Place::Environment => {
            names.push(ALONG.into());
        }
        (Kind::SunThermoelectric | Kind::SunThermoelectricHarmonics, _) => {
            names = SUN.map(str::to_string).to_vec();
        }
        (Kind::Hysteresis | Kind::Perming | Kind::SensitivityAgeing, _) => names.push(ALONG.into()),
        (kind, _) if kind.name().starts_with("sensitivity_") => names.push(ALONG.into()),
        _ => {}
    }
    names
}

/// Fields in SEN that the basic model of a state predicts, run by run.
pub fn fields(model: &Model<'_>, state: &State) -> Result<Vec<Vec<Vector3<f64>>>, Error> {
    (0..model.observed.runs.len())
        .map(|run| {
            let (basic, context) = model.setting(state, run);
            let predicted = physics::predict(&basic, &[], &context);
            let predicted = predicted.map_err(|e| e.at(&model.observed.runs[run].path))?;
            Ok(predicted.field_sen)
        })
        .collect()
}

/// A covariate in a run for a sensor, row by row; None where it is not there.
pub fn values(
    model: &Model<'_>,
    fields: &[Vec<Vector3<f64>>],
    run: usize,
    axis: Option<Axis>,
    name: &str,
) -> Option<Vec<f64>> {
    let component = |axis: Axis| fields[run].iter().map(|field| field[axis.index()]).collect();
    if name == ALONG {
        return axis.map(component);
    }
    if let Some(other) = Axis::ALL.into_iter().find(|other| name == across(*other)) {
        return Some(component(other));
    }
    if let Some((one, other)) = name.split_once(TIMES) {
        let [one, other] = [one, other].map(|name| values(model, fields, run, axis, name));
        return Some(one?.iter().zip(other?).map(|(a, b)| a * b).collect());
    }
    let context = &model.observed.runs[run].setting.context;
    if name == LOAD {
        return Some(context.coils_a().collect());
    }
    let values = context.optional(name).map(|values| values.to_vec());
    // Time is the campaign's.
    if name == "time_s" {
        values.map(|time| time.iter().map(|t| t + context.clock_s).collect())
    } else {
        values
    }
}

pub fn on_coil(effect: &EffectInstance) -> bool {
    effect.kind.about().acts == Acts::OneCoil
}
