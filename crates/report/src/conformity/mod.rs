//! The document against a specification: each requirement with its value, uncertainty, margin and verdict.
//!
//! A value comes from what the stages wrote to `calibration` and `model`; nothing is fitted here. Each kind
//! of requirement has a function whose docstring gives the equation. What the document does not hold is *not
//! shown*, with the procedure that would show it.

mod accuracy;
mod directions;
mod joint;
mod noise;
mod offset;
mod range;
mod spec;
mod temperature;
mod verdict;
mod words;

pub(crate) use joint::{Joint, axes, offset as offset_path};
pub use spec::{Requirement, RequirementKind, Spec};
pub(crate) use verdict::NORMAL;
use verdict::Rule;
pub use verdict::{Shown, ShownValue, Verdict};
pub use words::section;

use common::{Axis, Document};

/// The id of its section.
pub const ID: &str = "conformity";

/// A requirement with what the document shows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged<'a> {
    /// The requirement.
    pub requirement: &'a Requirement,
    /// What is shown of each sensor, pair of sensors or component of the field.
    pub shown: Vec<Shown>,
    /// The worst of their verdicts.
    pub verdict: Verdict,
    /// Which of them decides: of those with this verdict the one with the smallest margin; None where nothing
    /// is shown.
    pub decisive: Option<usize>,
}

/// Holds a document against each requirement of a specification.
///
/// # Errors
///
/// Where the document names effects that are none, or a covariance does not go with its `covariance_order`.
pub fn judge<'a>(document: &Document, spec: &'a Spec) -> Result<Vec<Judged<'a>>, common::Error> {
    document.check()?;
    physics::adopt(document).map_err(|error| error.at("model"))?;
    let rule = Rule { factor: spec.guard_factor };
    let joint = Joint::of(document)?;
    Ok(spec.requirements.iter().map(|requirement| one((document, &joint), requirement, rule)).collect())
}

fn one<'a>((document, joint): (&Document, &Joint), requirement: &'a Requirement, rule: Rule) -> Judged<'a> {
    let shown = match requirement.kind {
        RequirementKind::OrthogonalityDeg => directions::orthogonality(document, joint),
        RequirementKind::AxesArcsec => directions::known(document, joint),
        RequirementKind::AxesFromNominalArcsec => directions::from_nominal(document, joint, requirement),
        RequirementKind::AxesOverTemperatureArcsec => {
            each_sensor(document, |axis| directions::over_temperature(document, requirement, axis))
        }
        RequirementKind::RangeNt => range::range(document),
        RequirementKind::ResolutionNt => each_sensor(document, |axis| range::resolution(document, axis)),
        RequirementKind::BandwidthHz => each_sensor(document, |axis| range::bandwidth(document, axis)),
        RequirementKind::NoiseZeroToPeakNt => {
            each_sensor(document, |axis| noise::zero_to_peak(document, requirement, axis))
        }
        RequirementKind::OffsetStabilityNt => {
            each_sensor(document, |axis| offset::stability(document, joint, requirement, axis))
        }
        RequirementKind::AbsoluteAccuracyNt => accuracy::accuracy((document, joint), requirement, rule),
    };
    let side = requirement.kind.side();
    let of = |shown: &Shown| {
        shown.as_ref().map_or(Verdict::NotShown, |found| rule.verdict(side, requirement.limit, found))
    };
    let verdict = shown.iter().map(of).max().unwrap_or(Verdict::NotShown);
    let margin = |found: &ShownValue| rule.margin(side, requirement.limit, found);
    let deciding = shown.iter().enumerate().filter(|(_, shown)| of(shown) == verdict);
    let margins = deciding.filter_map(|(number, shown)| Some((number, margin(shown.as_ref().ok()?))));
    let decisive = margins.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(number, _)| number);
    Judged { requirement, shown, verdict, decisive }
}

/// What is shown of each sensor that the instrument has.
fn each_sensor(document: &Document, one: impl Fn(Axis) -> Result<ShownValue, String>) -> Vec<Shown> {
    let stated = document.instrument.as_ref().and_then(|instrument| instrument.sensors.as_ref());
    let has = |axis: &Axis| stated.is_none_or(|sensors| sensors.is_empty() || sensors.contains(axis));
    let shown = |axis: Axis| verdict::shown(format!("sensor {axis}"), one(axis));
    Axis::ALL.into_iter().filter(has).map(shown).collect()
}
