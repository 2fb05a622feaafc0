//! Which of the names that were found are kept when something is left over.
//!
//! A search that goes on until nothing fits any more gives every shape some name: what the catalogue does not have, it makes up of
//! several effects. Where what is left is noise, the names stand. Where it is not, a name stands only if it explains far more than is
//! left, and if nothing that is left follows what the effect itself follows: then its form is wrong.

use common::Axis;
use physics::{Acts, EffectInstance, Kind, Place};

use crate::candidates::{What, named};
use crate::covariates;
use crate::search::{Addition, Structure};
use crate::{Found, Stage};

/// What a name explains over what is left.
const FAR_MORE: f64 = 10.0;
/// Most different names in one sensor.
const MOST_IN_ONE: usize = 3;
/// Share of the level above which a further name in a sensor hardly stands out.
const HARDLY: f64 = 0.01;
/// Share of its energy to which the form that the catalogue has of an effect is met.
pub const FORM: f64 = 0.02;

/// How many of the names, in the order in which they were found, are kept.
pub fn kept(found: &[Found], stages: &[Stage], level: f64) -> usize {
    let whole = [made_of_moments(found, stages), made_of_pieces(found), crumbs(found, level)];
    let whole = whole.into_iter().flatten().fold(found.len(), usize::min);
    if whole == found.len() && stages[whole].look.clean(level) {
        return whole;
    }
    (0..=whole).rev().find(|count| stand(&found[..*count], stages, level)).unwrap_or(0)
}

/// None of the names if one sensor takes more different ones than [`MOST_IN_ONE`]: what the catalogue does not have is made up of them.
fn made_of_pieces(found: &[Found]) -> Option<usize> {
    let of = |axis: Axis| -> usize {
        let mut names: Vec<String> =
            found.iter().filter(|one| acts_on(&one.refined.proposal.addition, axis)).map(name).collect();
        names.sort();
        names.dedup();
        names.len()
    };
    Axis::ALL.into_iter().any(|axis| of(axis) > MOST_IN_ONE).then_some(0)
}

/// The first name that hardly stands out beside an earlier one in the same sensor, by chance, or by size where both are of one axis: the
/// earlier one's form leaves something rather than that there are two.
fn crumbs(found: &[Found], level: f64) -> Option<usize> {
    let crumb = |(at, one): &(usize, &Found)| {
        let own = &one.refined.proposal.addition;
        found[..*at].iter().filter(|earlier| name(earlier) != name(one)).any(|earlier| {
            let theirs = &earlier.refined.proposal.addition;
            let together = Axis::ALL.into_iter().any(|axis| acts_on(own, axis) && acts_on(theirs, axis));
            let by_chance = together && one.refined.p_adjusted > HARDLY * level;
            by_chance || same_axis(own, theirs) && one.gain < FORM * earlier.gain
        })
    };
    found.iter().enumerate().find(crumb).map(|(at, _)| at)
}

/// Whether two effects are of one sensor, or of a sensor and the coil along it.
fn same_axis(a: &Addition, b: &Addition) -> bool {
    match (a, b) {
        (Addition::Effect(a), Addition::Effect(b)) => a.axis.is_some() && a.axis == b.axis,
        _ => false,
    }
}

/// Whether an addition acts on a sensor.
fn acts_on(addition: &Addition, sensor: Axis) -> bool {
    match addition {
        Addition::Effect(effect) => {
            let one = effect.axis.filter(|_| effect.kind.about().acts == Acts::OneSensor);
            one.is_none_or(|own| own == sensor)
        }
        Addition::Column(column) => column.follows.as_ref().is_some_and(|follows| follows.axis == sensor),
    }
}

/// The name of an effect and its target, wherever it was found.
fn name(one: &Found) -> String {
    match &one.refined.proposal.addition {
        Addition::Effect(effect) => named(effect),
        Addition::Column(column) => column.what.clone(),
    }
}

/// The first of several single moments (steps, spikes, passes) if a smooth function of one covariate says more with fewer unknowns than
/// all of them: levels that come and go with a temperature are no steps.
fn made_of_moments(found: &[Found], stages: &[Stage]) -> Option<usize> {
    let moments: Vec<&Found> = found.iter().filter(|one| one.refined.proposal.local).collect();
    let first = found.iter().position(|one| one.refined.proposal.local).filter(|_| moments.len() > 1)?;
    let look = &stages[first].look;
    let price = (stages[first].fit.white.len() as f64).ln();
    let worth: f64 = moments.iter().map(|one| one.gain - one.refined.unknowns * price).sum();
    let says_more = |structure: &Structure| match &structure.what {
        What::Smooth { covariate, .. } if covariate == "time_s" || covariate == "row" => false,
        _ => structure.gain - structure.unknowns * price > worth,
    };
    look.structures.iter().any(says_more).then_some(first)
}

/// Whether names that came in one after the other stand at the stage after the last of them. Harmonics of one effect count together, each
/// single moment for itself. Where the noise is what a residual shows, it has become less since.
fn stand(found: &[Found], stages: &[Stage], level: f64) -> bool {
    let now = &stages[found.len()];
    let gain = |(one, when): (&Found, &Stage)| one.gain * when.noise.variance() / now.noise.variance();
    found.iter().enumerate().all(|(at, one)| {
        let harmonics = |other: &Found| !one.refined.proposal.local && name(other) == name(one);
        let all = found.iter().zip(stages).enumerate();
        let together = all.filter(|(k, (other, _))| *k == at || harmonics(other)).map(|(_, pair)| pair);
        together.map(gain).sum::<f64>() > FAR_MORE * now.look.left(level)
            && !now.look.structures.iter().any(|left| same(&one.refined.proposal.addition, &left.what))
    })
}

/// Whether structure follows what an effect follows, in the same sensor.
fn same(addition: &Addition, left: &What) -> bool {
    let (covariate, axis) = match left {
        What::Smooth { covariate, axis } => (covariate.as_str(), *axis),
        What::Dependence { column, axis } => (column.as_str(), *axis),
        What::Physics(_) => return false,
    };
    match addition {
        Addition::Effect(effect) => {
            let own = effect.axis.filter(|_| effect.kind.about().acts == Acts::OneSensor);
            own.is_none_or(|own| own == axis) && follows(effect, covariate)
        }
        Addition::Column(column) => column.what.ends_with(covariate),
    }
}

fn follows(effect: &EffectInstance, covariate: &str) -> bool {
    if effect.column.as_deref() == Some(covariate)
        || effect.kind.about().needs.contains(&covariate) && covariate != "time_s"
        || covariates::of(effect).iter().any(|name| name == covariate)
    {
        return true;
    }
    match effect.kind {
        Kind::CrossField | Kind::CrossFieldSensitivity | Kind::AxisTemperature | Kind::AxisCreep => {
            covariate.contains("across")
        }
        Kind::WarmUp | Kind::Ageing | Kind::SensitivityAgeing | Kind::ReadingStep | Kind::PillarSettling => {
            covariate == "time_s"
        }
        kind if matches!(kind.place(), Place::Sensor | Place::Electronics) => covariate.contains("along"),
        kind if kind.place() == Place::Facility => covariate.contains("field"),
        _ => false,
    }
}
