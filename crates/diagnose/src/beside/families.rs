//! The kinds of physics among the causes of a difference.

use common::{ExplainedEffect, ExplainedFamily, FamilyMember};
use explain::Cause;
use physics::{Family, Kind};
use std::collections::BTreeSet;

use super::Compared;
use crate::families::{by_share, described};

/// The families of the effects that were found, the one that explains most first: how probable each is, and its
/// members in the sets that were weighed. Clocks and steps were found apart and stand as they are.
pub fn families(compared: &Compared, found: &[ExplainedEffect]) -> Vec<ExplainedFamily> {
    let explained = &compared.of.explained;
    let causes: BTreeSet<Cause> = explained.rivals.iter().flat_map(|set| set.causes.clone()).collect();
    let weight = |any_of: &[Cause]| -> f64 {
        let sets = explained.rivals.iter().filter(|set| set.causes.iter().any(|one| any_of.contains(one)));
        sets.map(|set| set.probability).sum::<f64>().min(1.0)
    };
    let of = |family: Family| {
        let is_of = |kind: Kind| kind.about().family == family;
        let own: Vec<&ExplainedEffect> =
            found.iter().filter(|effect| Kind::named(&effect.effect).is_some_and(is_of)).collect();
        if own.is_empty() {
            return None;
        }
        let weighed: Vec<Cause> =
            causes.iter().copied().filter(|cause| is_of(compared.kind(*cause))).collect();
        let apart = own.iter().filter(|effect| effect.share.is_none());
        let mut members: Vec<FamilyMember> = apart
            .map(|effect| FamilyMember {
                effect: effect.effect.clone(),
                probability: effect.probability.unwrap_or(1.0),
            })
            .collect();
        let certain = members.iter().map(|member| member.probability).fold(0.0, f64::max);
        members.extend(
            weighed
                .iter()
                .map(|cause| FamilyMember { effect: compared.label(*cause), probability: weight(&[*cause]) }),
        );
        Some(ExplainedFamily {
            probability: weight(&weighed).max(certain),
            share: own.iter().filter_map(|effect| effect.share).sum::<f64>().min(1.0),
            ..described(family, members)
        })
    };
    by_share(of)
}
