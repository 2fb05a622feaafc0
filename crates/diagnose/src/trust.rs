//! Which of the names that were found are kept when something is left over.
//!
//! A search that goes on until nothing fits any more gives every shape some name: what the catalogue does not have, it makes up of
//! several effects. Where what is left is noise, the names stand. Where it is not, a name stands only if it explains far more than is
//! left, and if nothing that is left follows what the effect itself follows: then its form is wrong.

use physics::{Acts, EffectInstance, Kind, Place};

use crate::candidates::What;
use crate::covariates;
use crate::search::{Addition, Look};
use crate::{Found, Stage};

/// What a name explains over what is left.
const FAR_MORE: f64 = 10.0;

/// How many of the names, in the order in which they were found, are kept.
pub fn kept(found: &[Found], stages: &[Stage], level: f64) -> usize {
    let whole = found.len();
    if stages[whole].look.clean(level) {
        return whole;
    }
    (0..=whole)
        .rev()
        .find(|count| found[..*count].iter().all(|one| stands(one, &stages[*count].look)))
        .unwrap_or(0)
}

fn stands(found: &Found, look: &Look) -> bool {
    found.gain > FAR_MORE * look.left()
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
