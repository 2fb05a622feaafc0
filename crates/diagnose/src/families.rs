//! What the weighed sets say of kinds of physics, whatever the member and its form.

use common::{Axis, ExplainedFamily, FamilyMember};
use physics::Family;
use std::collections::BTreeSet;

use crate::atoms::{Atom, Atoms};
use crate::covariates;
use crate::proposal::{Addition, What};
use crate::sets::Set;

/// Members, and forms that no member has, that are less probable are not told.
pub const LEAST: f64 = 0.02;

/// What kind of physics an atom is; structure without a name by what it follows.
pub fn of(atom: &Atom) -> Family {
    match &atom.what {
        What::Physics(effect) => effect.kind.about().family,
        What::Event(additions) => match additions.first() {
            Some(Addition::Effect(effect)) => effect.kind.about().family,
            _ => Family::Moments,
        },
        What::Smooth { covariate, .. } => covariates::family(covariate),
    }
}

/// The kinds of physics of the best set, the one that explains most first: how probable each is, and which
/// members it has in the sets that were weighed. `share` says what atoms explain together, beside all others.
pub fn families(
    atoms: &Atoms<'_>,
    (ranked, weights): (&[Set], &[f64]),
    best: &Set,
    share: impl Fn(&[usize]) -> f64,
) -> Vec<ExplainedFamily> {
    let is_of = |family: Family, set: &Set| -> Vec<usize> {
        set.key().into_iter().filter(|atom| of(&atoms.all[*atom]) == family).collect()
    };
    by_share(|family| {
        let own = is_of(family, best);
        if own.is_empty() {
            return None;
        }
        let weight = |which: &dyn Fn(&[usize]) -> bool| -> f64 {
            let sets = ranked.iter().zip(weights);
            let weights = sets.filter(|(set, _)| which(&is_of(family, set))).map(|(_, weight)| weight);
            weights.sum::<f64>().min(1.0)
        };
        let is_named = |atom: &usize| atoms.all[*atom].is_named();
        let named: BTreeSet<usize> =
            ranked.iter().flat_map(|set| is_of(family, set)).filter(is_named).collect();
        let member = |atom: usize| FamilyMember {
            effect: atoms.all[atom].name.clone(),
            probability: weight(&|all| all.contains(&atom)),
        };
        let sensors: BTreeSet<Axis> = own.iter().filter_map(|atom| atoms.all[*atom].sensor()).collect();
        Some(ExplainedFamily {
            sensors: sensors.into_iter().collect(),
            probability: weight(&|all| !all.is_empty()),
            share: share(&own).clamp(0.0, 1.0),
            no_member: weight(&|all| !all.is_empty() && !all.iter().any(is_named)),
            ..described(family, named.into_iter().map(member).collect())
        })
    })
}

/// A kind of physics with its members, the most probable first; improbable ones are not told.
pub fn described(family: Family, mut members: Vec<FamilyMember>) -> ExplainedFamily {
    members.retain(|member| member.probability >= LEAST);
    members.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    ExplainedFamily {
        family: family.word().into(),
        title: family.title().into(),
        members,
        told_apart_by: family.told_apart_by().into(),
        ..ExplainedFamily::default()
    }
}

/// The kinds of physics that there are, the one that explains most first.
pub fn by_share(of: impl Fn(Family) -> Option<ExplainedFamily>) -> Vec<ExplainedFamily> {
    let mut all: Vec<ExplainedFamily> = Family::ALL.into_iter().filter_map(of).collect();
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}
