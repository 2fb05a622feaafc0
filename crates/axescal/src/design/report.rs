//! A design as it is written and said.

use common::number::{bare, counted, figures, significant};
use common::{Axis, Matrix3x3, OneOrEach};
use nalgebra::Matrix3;
use physics::frames::ARCSEC;
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write;

use super::basis;
use super::given::{Given, Setting, listed};
use super::information::TURNS;
use super::least::{Hours, Search, Target, block};
use super::limits::{Limit, More, limits, more};
use super::radius::{Reach, axes};
use crate::{Error, Result};

/// Targets of the table beside the one that is asked for, arcsec.
const TABLE_ARCSEC: [f64; 4] = [2.0, 1.0, 0.5, 0.25];

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Request {
    /// Error of a direction, arcsec.
    pub target_arcsec: f64,
    /// Probability with which it is to be kept, for each direction.
    pub confidence: f64,
    /// Whether the coils' directions count as well.
    pub coils: bool,
}

/// The recordings of the least time, what they reach, and what limits it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    #[serde(flatten)]
    pub request: Request,
    pub recordings: Recorded,
    /// Time at the facility, h.
    pub hours: Hours,
    pub predicted: Predicted,
    /// What makes the error of the direction that errs most.
    pub limits: Vec<Limit>,
    pub more: Vec<More>,
    pub table: Vec<Cost>,
    pub given: Given,
    /// The part of a plan for simulate that makes these recordings.
    pub procedure: Value,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recorded {
    /// Settings of the block.
    pub settings: usize,
    /// The orientation of each, R (GEO -> SEN).
    pub orientations: Vec<Matrix3x3>,
    #[serde(flatten)]
    pub setting: Setting,
    pub drives: usize,
    /// Largest field of each coil, nT.
    pub drive_nt: [f64; 3],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Predicted {
    pub sensors: Directions,
    pub coils: Directions,
    /// The largest that counts: within this with the probability that was asked for, arcsec.
    pub worst_arcsec: f64,
}

/// Errors of three directions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Directions {
    /// Largest standard deviation over all ways it may turn, arcsec: what axescal will state.
    pub std_arcsec: OneOrEach,
    /// It stays within this with the probability that was asked for, arcsec.
    pub within_arcsec: OneOrEach,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cost {
    pub target_arcsec: f64,
    /// None where it is out of reach.
    #[serde(flatten)]
    pub reached: Option<Reached>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reached {
    /// Time at the facility, h.
    pub hours: f64,
    /// Settings of the block.
    pub settings: usize,
    #[serde(flatten)]
    pub setting: Setting,
}

/// Finds the recordings of the least time that reach a target.
///
/// # Errors
///
/// A target that is out of reach of the most recordings that are tried, with what limits it.
pub fn plan(given: &Given, candidates: &[Matrix3<f64>], request: Request) -> Result<Plan> {
    let target = |arcsec: f64| Target {
        arcsec,
        reach: Reach::new(request.confidence),
        turns: if request.coils { TURNS } else { TURNS / 2 },
    };
    let search = Search::new(given, candidates);
    let asked = target(request.target_arcsec);
    let recordings = search.least(&asked).map_err(|best| out_of_reach(request, best))?;
    let covariance =
        search.covariance(given, &recordings).ok_or_else(|| out_of_reach(request, f64::INFINITY))?;
    let each = |first: usize, of: &dyn Fn([[f64; 2]; 2]) -> f64| {
        let of = |axis: Axis| (axis, of(block(&covariance, first + 2 * axis.index())) / ARCSEC);
        OneOrEach::Each(Axis::ALL.into_iter().map(of).collect())
    };
    let directions = |first: usize| Directions {
        std_arcsec: each(first, &|block| axes(block)[0]),
        within_arcsec: each(first, &|block| asked.reach.of(block)),
    };
    let mut targets: Vec<f64> = TABLE_ARCSEC.into_iter().chain([request.target_arcsec]).collect();
    targets.sort_by(|a, b| b.total_cmp(a));
    targets.dedup();
    let cost = |target_arcsec: f64| {
        let reached = search.least(&target(target_arcsec)).ok().map(|found| Reached {
            hours: found.hours(given).total,
            settings: found.orientations.len(),
            setting: found.setting,
        });
        Cost { target_arcsec, reached }
    };
    Ok(Plan {
        request,
        recordings: Recorded {
            settings: recordings.orientations.len(),
            orientations: listed(candidates, &recordings.orientations),
            setting: recordings.setting,
            drives: given.drives(&recordings.setting).len(),
            drive_nt: given.coil_nt,
        },
        hours: recordings.hours(given),
        predicted: Predicted {
            sensors: directions(0),
            coils: directions(TURNS / 2),
            worst_arcsec: asked.worst_arcsec(Some(&covariance)),
        },
        limits: limits(&search, &recordings, &asked),
        more: more(&search, &recordings, &asked),
        table: targets.into_iter().map(cost).collect(),
        given: given.clone(),
        procedure: basis::procedure(given, candidates, &recordings),
    })
}

fn out_of_reach(request: Request, best: f64) -> Error {
    let of = if request.coils { "sensors and coils" } else { "the sensors" };
    let reached = if best.is_finite() {
        format!("the most recordings that are tried reach {}\"", significant(best, 3))
    } else {
        "the orientations do not determine the directions; their rotations must be about at least two different axes".into()
    };
    Error::Unanswerable(format!(
        "{}\" for {of} with a probability of {} is out of reach: {reached}. Ask for less (--target-arcsec), or state better theodolites, \
         a stronger drive or less noise",
        bare(request.target_arcsec),
        bare(request.confidence)
    ))
}

/// The design in a few lines for people.
pub fn words(plan: &Plan) -> String {
    let Plan { request, recordings, hours, predicted, .. } = plan;
    let mut text = format!(
        "axescal design: each sensor{} within {}\" with a probability of {}: {} h at the facility\n",
        if request.coils { " and coil" } else { "" },
        bare(request.target_arcsec),
        bare(request.confidence),
        significant(hours.total, 3)
    );
    let Setting { theodolite_readings, cycles, weakest_coil, readings } = recordings.setting;
    let of_weakest = if weakest_coil > 1 {
        let weakest = Axis::ALL[plan.given.weakest()];
        format!(" ({} of them of coil {weakest})", 2 * weakest_coil * cycles)
    } else {
        String::new()
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "  {} of the block; in each {}, {}{of_weakest}, {}",
        counted(recordings.settings, "setting"),
        counted(theodolite_readings, "theodolite reading"),
        counted(recordings.drives, "drive"),
        if readings == 1 { "each read once".to_string() } else { format!("each read {readings} times") },
    );
    let mut items = vec![
        format!("block {}", significant(hours.orientations, 3)),
        format!("theodolites again {}", significant(hours.theodolites, 3)),
        format!("drives {}", significant(hours.drives, 3)),
    ];
    if hours.temperatures > 0.0 {
        items.push(format!("temperatures {}", significant(hours.temperatures, 3)));
    }
    let _ = writeln!(text, "  hours: {}", items.join(", "));
    for (kind, directions) in [("sensors", &predicted.sensors), ("coils", &predicted.coils)] {
        let each = Axis::ALL.map(|axis| {
            let of = |all: &OneOrEach, digits: usize| figures(all.get(axis).unwrap_or(0.0), digits);
            let (within, std) = (of(&directions.within_arcsec, 3), of(&directions.std_arcsec, 2));
            format!("{axis} {within}\" (σ {std}\")")
        });
        let _ = writeln!(text, "  {kind} within: {}", each.join(", "));
    }
    let share = |limit: &Limit| format!("{} {} %", limit.source, significant(100.0 * limit.share, 2));
    let shares: Vec<String> = plan.limits.iter().filter(|limit| limit.share >= 0.005).map(share).collect();
    let _ = writeln!(text, "  limited by: {}", shares.join(", "));
    for More { change, worst_arcsec, hours } in &plan.more {
        let cost = if *hours == 0.0 { String::new() } else { format!(", {} h more", significant(*hours, 2)) };
        let _ = writeln!(text, "  {change}: {}\"{cost}", figures(*worst_arcsec, 3));
    }
    let _ = writeln!(text, "  target arcsec  hours  settings  theodolite readings  drives' readings");
    for Cost { target_arcsec, reached } in &plan.table {
        let target = bare(*target_arcsec);
        let _ = match reached {
            None => writeln!(text, "  {target:>13}  out of reach"),
            Some(Reached { hours, settings, setting }) => {
                let (hours, read) = (significant(*hours, 3), setting.theodolite_readings);
                let drives = plan.given.drives(setting).len() * setting.readings;
                let mark = if *target_arcsec == request.target_arcsec { " <- chosen" } else { "" };
                writeln!(text, "  {target:>13}  {hours:>5}  {settings:>8}  {read:>19}  {drives:>16}{mark}")
            }
        };
    }
    text
}
