//! Long recordings: thousands of rows, in which what is small against the noise of a reading is large against
//! that of them all, and in which no formula is quite that of the effect.

use super::set::Set;
use crate::case::{self, Case, Concealed};
use crate::draw::Draw;
use crate::form;
use crate::kinds;
use crate::outside;
use crate::scene::{Campaign, SceneKind};
use crate::scenes::{self, Length};

/// Times the noise, of single effects.
pub const STRENGTHS: [f64; 5] = [100.0, 10.0, 3.0, 1.0, 0.3];
/// Times the noise, of what is outside the catalogue.
pub const BEYOND: [f64; 4] = [10.0, 3.0, 100.0, 1.0];
/// Times the noise, of each of several effects: least and most.
const SEVERAL: [f64; 2] = [1.0, 10.0];

/// Every third is a day's.
pub(super) fn length(turn: usize) -> Length {
    if turn % 3 == 2 { Length::Day } else { Length::Campaign }
}

fn concealed(
    name: &str,
    make: fn(&Campaign, &mut Draw) -> crate::effect::Effect,
    campaign: &Campaign,
    strength: f64,
    draw: &mut Draw,
) -> Concealed {
    let (effect, form_error) = form::inexact(name, make(campaign, draw), campaign, draw);
    Concealed { name: name.into(), effect, strength, form_error }
}

/// Kinds go fastest and strengths with them: few cases have many kinds, and every strength.
pub(super) fn single(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let (kind, round) = (number % kinds::ALL.len(), number / kinds::ALL.len());
    let which = kinds::ALL[kind];
    let strength = STRENGTHS[(kind + round) % STRENGTHS.len()];
    let length = length(kind / STRENGTHS.len() + round);
    let apart = (kind + round).is_multiple_of(2);
    let campaign = scenes::campaign(which.scene, length, apart, which.step_s, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let concealed = concealed(which.name, which.make, &campaign, strength, draw);
    let labels = Set::LongSingle.labels(seed, number, strength, length);
    case::make(&campaign, noise, vec![concealed], labels, draw)
}

/// Two or three unlike effects in runs in coils.
pub(super) fn several(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let (count, length) = (2 + number % 2, length(number / 2));
    let campaign = scenes::campaign(SceneKind::Coils, length, number % 4 < 2, None, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let mut kinds = kinds::in_coils();
    let all = (0..count)
        .map(|_| {
            let which = kinds.swap_remove(draw.below(kinds.len()));
            let strength = draw.octaves(SEVERAL[0], SEVERAL[1]);
            concealed(which.name, which.make, &campaign, strength, draw)
        })
        .collect();
    let labels = Set::LongSeveral.labels(seed, number, (SEVERAL[0] * SEVERAL[1]).sqrt(), length);
    case::make(&campaign, noise, all, labels, draw)
}

/// What the catalogue has no name for, in runs in coils.
pub(super) fn beyond(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let (kind, round) = (number % outside::ALL.len(), number / outside::ALL.len());
    let (name, make) = outside::ALL[kind];
    let strength = BEYOND[(kind + round) % BEYOND.len()];
    let length = length(kind / BEYOND.len() + round);
    let campaign = scenes::campaign(SceneKind::Coils, length, (kind + round).is_multiple_of(2), None, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let concealed = concealed(name, make, &campaign, strength, draw);
    let labels = Set::LongOutside.labels(seed, number, strength, length);
    case::make(&campaign, noise, vec![concealed], labels, draw)
}
