//! Which of the names that were found are kept when something is left over.
//!
//! A search that goes on until nothing fits any more gives every shape some name: what the catalogue does not have, it makes up of
//! several effects. Where what is left is noise, the names stand. Where it is not, a name stands only if it explains far more than is
//! left, and if nothing that is left follows what the effect itself follows: then its form is wrong.

use physics::{Acts, EffectInstance, Kind, Place};

use crate::candidates::What;
use crate::covariates;
use crate::search::{Addition, Structure};
use crate::{Found, Stage};

/// What a name explains over what is left.
const FAR_MORE: f64 = 10.0;

/// How many of the names, in the order in which they were found, are kept.
pub fn kept(found: &[Found], stages: &[Stage], level: f64) -> usize {
    let whole = made_of_moments(found, stages).unwrap_or(found.len());
    if stages[whole].look.clean(level) {
        return whole;
    }
    (0..=whole)
        .rev()
        .find(|count| {
            let mut all = found[..*count].iter().zip(stages);
            all.all(|(one, when)| stands(one, when, &stages[*count]))
        })
        .unwrap_or(0)
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

/// Whether a name that came in at one stage stands at another. Where the noise is what a residual shows, it has become less since.
fn stands(found: &Found, when: &Stage, now: &Stage) -> bool {
    let look = &now.look;
    found.gain * when.noise.variance() > FAR_MORE * look.left() * now.noise.variance()
        && !look.structures.iter().any(|left| same(&found.refined.proposal.addition, &left.what))
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
