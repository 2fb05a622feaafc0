//! Held-out physics in recordings as instruments write them: kinds and forms of one group (see
//! [`crate::groups`]), 0.1 to 100 times the noise, one effect or up to four, each off its formula by up to a
//! fifth.

use super::set::Set;
use crate::as_recorded::as_recorded;
use crate::base;
use crate::case::{self, Case, Concealed};
use crate::draw::Draw;
use crate::effect::Effect;
use crate::form;
use crate::groups::{self, Group};
use crate::housekeeping;
use crate::kinds::{self, Single};
use crate::manner;
use crate::outside::{self, Outside};
use crate::scene::{Campaign, Readings, SceneKind};
use crate::scenes::Length;

/// Times the noise.
pub const STRENGTHS: [f64; 6] = [3.0, 1.0, 10.0, 0.3, 100.0, 0.1];
/// Times the noise of what is outside the catalogue.
pub const BEYOND: [f64; 4] = [3.0, 10.0, 1.0, 100.0];
/// Times the noise, of each of several effects: least and most.
const SEVERAL: [f64; 2] = [1.0, 10.0];

/// Kinds and forms of a group.
pub fn kinds_of(group: Group) -> Vec<Single> {
    let all = kinds::ALL.into_iter().chain(kinds::FURTHER);
    all.filter(|kind| groups::of(kind.name, kind.form) == group).collect()
}

/// What is outside the catalogue, of a group.
pub fn outside_of(group: Group) -> Vec<Outside> {
    let all = outside::ALL.into_iter().chain(outside::FURTHER);
    all.filter(|(name, _)| groups::of(name, "") == group).collect()
}

fn concealed(
    name: &str,
    make: fn(&Campaign, &mut Draw) -> Effect,
    (campaign, strength): (&Campaign, f64),
    draw: &mut Draw,
) -> Concealed {
    let (effect, form_error) = form::inexact(name, make(campaign, draw), campaign, draw);
    Concealed { name: name.into(), effect, strength, form_error }
}

/// A campaign at random with what is made for it concealed in it, written down as an instrument would have.
fn written(
    (set, seed, number): (Set, u64, usize),
    (scene, step_s, strength): (SceneKind, Option<f64>, f64),
    make: impl FnOnce(&Campaign, &mut Draw) -> Vec<Concealed>,
    draw: &mut Draw,
) -> Case {
    let apart = draw.sign() > 0.0;
    let (mut campaign, mut said) = manner::campaign(scene, step_s, apart, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let all = make(&campaign, draw);
    said.extend(manner::converter(&mut campaign, &noise, &all, draw));
    let left = left_of(&campaign, &all);
    let rows = campaign.runs.iter().map(|run| run.times.len()).sum();
    let labels = set.labels(seed, number, strength, Length::of(rows));
    let mut case = case::make(&campaign, noise, all, labels, draw);
    case.truth.recorded = said;
    housekeeping::add(&mut case, &left, draw);
    as_recorded(&mut case, draw);
    case
}

/// What a fresh calibration leaves of effects at a size of one each.
fn left_of(campaign: &Campaign, all: &[Concealed]) -> Readings {
    let plain = campaign.plain();
    let mut sum: Readings =
        plain.iter().map(|run| run.clone().map(|column| vec![0.0; column.len()])).collect();
    for one in all {
        let added = (one.effect.act)(campaign, &plain, 1.0);
        let both = sum.iter_mut().flatten().flatten().zip(added.iter().flatten().flatten());
        both.for_each(|(sum, added)| *sum += added);
    }
    base::left(campaign, &sum)
}

/// One effect; kinds go fastest, and strengths with them.
pub(super) fn single(set: Set, group: Group, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let kinds = kinds_of(group);
    let (turn, round) = (number % kinds.len(), number / kinds.len());
    let which = kinds[turn];
    let strength = STRENGTHS[(turn + round) % STRENGTHS.len()];
    let make = |campaign: &Campaign, draw: &mut Draw| {
        vec![concealed(which.name, which.make, (campaign, strength), draw)]
    };
    written((set, seed, number), (which.scene, which.step_s, strength), make, draw)
}

/// Two to four effects of different names in runs in coils.
pub(super) fn several(set: Set, group: Group, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let make = |campaign: &Campaign, draw: &mut Draw| {
        let mut kinds = kinds_of(group);
        kinds.retain(|kind| kind.scene == SceneKind::Coils);
        let mut all = Vec::new();
        while all.len() < 2 + number % 3 && !kinds.is_empty() {
            let which = kinds.swap_remove(draw.below(kinds.len()));
            kinds.retain(|kind| kind.name != which.name);
            let strength = draw.octaves(SEVERAL[0], SEVERAL[1]);
            all.push(concealed(which.name, which.make, (campaign, strength), draw));
        }
        all
    };
    written((set, seed, number), (SceneKind::Coils, None, (SEVERAL[0] * SEVERAL[1]).sqrt()), make, draw)
}

/// What the catalogue has no name for, in runs in coils.
pub(super) fn beyond(set: Set, group: Group, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let all = outside_of(group);
    let (turn, round) = (number % all.len(), number / all.len());
    let (name, make) = all[turn];
    let strength = BEYOND[(turn + round) % BEYOND.len()];
    let make = |campaign: &Campaign, draw: &mut Draw| vec![concealed(name, make, (campaign, strength), draw)];
    written((set, seed, number), (SceneKind::Coils, None, strength), make, draw)
}

/// Nothing.
pub(super) fn clean(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let kinds = [
        SceneKind::Coils,
        SceneKind::Craft,
        SceneKind::Coils,
        SceneKind::Site,
        SceneKind::Coils,
        SceneKind::Pair,
        SceneKind::Fast,
    ];
    let scene = kinds[number % kinds.len()];
    written((Set::RecordedClean, seed, number), (scene, None, 0.0), |_, _| Vec::new(), draw)
}
