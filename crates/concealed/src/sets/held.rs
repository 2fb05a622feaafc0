//! Held-out physics in recordings as instruments write them: kinds and forms of one group (see [`crate::groups`]), 0.1 to 100 times the
//! noise, one effect or up to four, each off its formula by up to a fifth.

use super::Set;
use crate::as_recorded::as_recorded;
use crate::case::{self, Case, Concealed};
use crate::draw::Draw;
use crate::effect::Effect;
use crate::form;
use crate::groups::{self, Group};
use crate::kinds::{self, Single};
use crate::outside::{self, Outside};
use crate::scene::{Campaign, Kind};
use crate::scenes::{self, Length};

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

/// A thousand rows, three thousand, nine thousand.
fn length(turn: usize) -> Length {
    [Length::Long, Length::Campaign, Length::Day][turn % 3]
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

fn written(mut case: Case, draw: &mut Draw) -> Case {
    as_recorded(&mut case, draw);
    case
}

/// One effect; kinds go fastest, and strengths with them.
pub(super) fn single(set: Set, group: Group, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let kinds = kinds_of(group);
    let (turn, round) = (number % kinds.len(), number / kinds.len());
    let which = kinds[turn];
    let strength = STRENGTHS[(turn + round) % STRENGTHS.len()];
    let length = length(turn / STRENGTHS.len() + turn + round);
    let campaign =
        scenes::campaign(which.scene, length, (turn + round).is_multiple_of(2), which.step_s, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let all = vec![concealed(which.name, which.make, (&campaign, strength), draw)];
    written(case::make(&campaign, noise, all, set.labels(seed, number, strength, length), draw), draw)
}

/// Two to four effects of different names in runs in coils.
pub(super) fn several(set: Set, group: Group, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let (count, length) = (2 + number % 3, length(number));
    let campaign = scenes::campaign(Kind::Coils, length, number.is_multiple_of(2), None, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let mut kinds = kinds_of(group);
    kinds.retain(|kind| kind.scene == Kind::Coils);
    let mut all = Vec::new();
    while all.len() < count && !kinds.is_empty() {
        let which = kinds.swap_remove(draw.below(kinds.len()));
        kinds.retain(|kind| kind.name != which.name);
        let strength = draw.octaves(SEVERAL[0], SEVERAL[1]);
        all.push(concealed(which.name, which.make, (&campaign, strength), draw));
    }
    let strength = (SEVERAL[0] * SEVERAL[1]).sqrt();
    written(case::make(&campaign, noise, all, set.labels(seed, number, strength, length), draw), draw)
}

/// What the catalogue has no name for, in runs in coils.
pub(super) fn beyond(set: Set, group: Group, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let all = outside_of(group);
    let (turn, round) = (number % all.len(), number / all.len());
    let (name, make) = all[turn];
    let strength = BEYOND[(turn + round) % BEYOND.len()];
    let length = length(turn / BEYOND.len() + turn + round);
    let campaign = scenes::campaign(Kind::Coils, length, (turn + round).is_multiple_of(2), None, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let all = vec![concealed(name, make, (&campaign, strength), draw)];
    written(case::make(&campaign, noise, all, set.labels(seed, number, strength, length), draw), draw)
}

/// Nothing.
pub(super) fn clean(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let kinds = [Kind::Coils, Kind::Craft, Kind::Coils, Kind::Site, Kind::Coils, Kind::Pair];
    let length = length(number);
    let campaign =
        scenes::campaign(kinds[number % kinds.len()], length, number.is_multiple_of(2), None, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let labels = Set::RecordedClean.labels(seed, number, 0.0, length);
    written(case::make(&campaign, noise, Vec::new(), labels, draw), draw)
}
