//! The sets of cases, each from its seed.

pub mod held;
mod long;
mod removed;
mod set;

pub use set::{Set, neutral};

use rayon::prelude::*;

use crate::ambiguous;
use crate::case::{self, Case, Concealed};
use crate::draw::Draw;
use crate::groups::Group;
use crate::kinds::{self, Single};
use crate::noise::Noise;
use crate::outside;
use crate::scene::SceneKind;
use crate::scenes::{self, Length};

/// Times the noise.
pub const STRENGTHS: [f64; 3] = [3.0, 1.0, 0.3];

impl Set {
    /// Cases of a whole round: each kind at each strength once, each design once.
    pub fn round(self) -> usize {
        match self {
            Set::Clean => 50,
            Set::Old => 10,
            Set::Single => kinds::ALL.len() * STRENGTHS.len(),
            Set::Pairs => 20,
            Set::Triples => 8,
            Set::Ambiguous => 2 * ambiguous::ALL.len(),
            Set::Outside => 2 * outside::ALL.len(),
            Set::LongSingle => kinds::ALL.len() * long::STRENGTHS.len(),
            Set::LongSeveral => 24,
            Set::LongOutside => outside::ALL.len() * long::BEYOND.len(),
            Set::LongClean => 24,
            Set::Develop => held::kinds_of(Group::Develop).len() * held::STRENGTHS.len(),
            Set::DevelopOutside => held::outside_of(Group::Develop).len() * held::BEYOND.len(),
            Set::Choose => held::kinds_of(Group::Choose).len() * held::STRENGTHS.len(),
            // Four of the six strengths for each kind: a whole release stays below two hundred and fifty
            // cases.
            Set::Score => held::kinds_of(Group::Score).len() * 4,
            Set::DevelopSeveral | Set::ChooseSeveral | Set::ScoreSeveral | Set::RecordedClean => 24,
            Set::Removed => removed::names().len(),
            Set::ChooseOutside => held::outside_of(Group::Choose).len() * held::BEYOND.len(),
            Set::ScoreOutside => held::outside_of(Group::Score).len() * held::BEYOND.len(),
        }
    }

    /// The first `count` cases of a seed, the same however many there are.
    pub fn cases(self, seed: u64, count: usize) -> Vec<Case> {
        (0..count).into_par_iter().map(|number| self.case(seed, number)).collect()
    }

    /// One of them.
    pub fn case(self, seed: u64, number: usize) -> Case {
        let mut draw = Draw::new(&format!("{}/{number}", self.word()), seed);
        match self {
            Set::Clean | Set::Old | Set::LongClean => clean(self, seed, number, &mut draw),
            Set::Single => single(seed, number, &mut draw),
            Set::Pairs => several(self, 2, seed, number, &mut draw),
            Set::Triples => several(self, 3, seed, number, &mut draw),
            Set::Ambiguous => undecided(seed, number, &mut draw),
            Set::Outside => beyond(seed, number, &mut draw),
            Set::LongSingle => long::single(seed, number, &mut draw),
            Set::LongSeveral => long::several(seed, number, &mut draw),
            Set::LongOutside => long::beyond(seed, number, &mut draw),
            Set::Develop => held::single(self, Group::Develop, seed, number, &mut draw),
            Set::DevelopSeveral => held::several(self, Group::Develop, seed, number, &mut draw),
            Set::DevelopOutside => held::beyond(self, Group::Develop, seed, number, &mut draw),
            Set::Choose => held::single(self, Group::Choose, seed, number, &mut draw),
            Set::ChooseSeveral => held::several(self, Group::Choose, seed, number, &mut draw),
            Set::ChooseOutside => held::beyond(self, Group::Choose, seed, number, &mut draw),
            Set::Score => held::single(self, Group::Score, seed, number, &mut draw),
            Set::ScoreSeveral => held::several(self, Group::Score, seed, number, &mut draw),
            Set::ScoreOutside => held::beyond(self, Group::Score, seed, number, &mut draw),
            Set::RecordedClean => held::clean(seed, number, &mut draw),
            Set::Removed => removed::case(seed, number, &mut draw),
        }
    }
}

/// What is as weak as a third of the noise is looked for in the longer recordings alone.
fn length_for(strength: f64, number: usize) -> Length {
    if strength < 1.0 { [Length::Medium, Length::Long][number % 2] } else { Length::ALL[number % 3] }
}

fn clean(set: Set, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let kinds = [
        SceneKind::Coils,
        SceneKind::Coils,
        SceneKind::Craft,
        SceneKind::Coils,
        SceneKind::Site,
        SceneKind::Coils,
        SceneKind::Pair,
        SceneKind::Fast,
    ];
    let length = if set == Set::LongClean { long::length(number) } else { Length::ALL[number % 3] };
    let campaign =
        scenes::campaign(kinds[number % kinds.len()], length, number.is_multiple_of(2), None, draw);
    let step_s = campaign.runs[0].step_s();
    let old = |draw| Noise { old: true, ..case::flicker(draw) };
    let noise = if set == Set::Old { old(draw) } else { case::noise_of(draw, step_s) };
    case::make(&campaign, noise, Vec::new(), set.labels(seed, number, 0.0, length), draw)
}

fn single(seed: u64, number: usize, draw: &mut Draw) -> Case {
    // Kinds go slowest, so that the first cases have every strength.
    let strength = STRENGTHS[number % 3];
    let round = number / 3;
    let which: Single = kinds::ALL[round % kinds::ALL.len()];
    let length = length_for(strength, round + round / kinds::ALL.len() + number % 3);
    let apart = (round + number).is_multiple_of(2);
    let campaign = scenes::campaign(which.scene, length, apart, which.step_s, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let concealed = Concealed {
        name: which.name.into(),
        effect: (which.make)(&campaign, draw),
        strength,
        form_error: 0.0,
    };
    case::make(&campaign, noise, vec![concealed], Set::Single.labels(seed, number, strength, length), draw)
}

/// Several unlike effects in runs in coils, each one to three times the noise.
fn several(set: Set, count: usize, seed: u64, number: usize, draw: &mut Draw) -> Case {
    let length = [Length::Medium, Length::Long][number % 2];
    let campaign = scenes::campaign(SceneKind::Coils, length, number % 4 < 2, None, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let mut kinds = kinds::in_coils();
    let mut concealed = Vec::new();
    while concealed.len() < count {
        let which = kinds.swap_remove(draw.below(kinds.len()));
        let strength = draw.between(1.0, 3.0);
        concealed.push(Concealed {
            name: which.name.into(),
            effect: (which.make)(&campaign, draw),
            strength,
            form_error: 0.0,
        });
    }
    case::make(&campaign, noise, concealed, set.labels(seed, number, 2.0, length), draw)
}

fn undecided(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let (name, design) = ambiguous::ALL[number % ambiguous::ALL.len()];
    let length = Length::ALL[(number / ambiguous::ALL.len()) % 3];
    let strength = [3.0, 1.0][number / ambiguous::ALL.len() % 2];
    let (campaign, effect) = design(length, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let concealed = Concealed { name: name.into(), effect, strength, form_error: 0.0 };
    case::make(&campaign, noise, vec![concealed], Set::Ambiguous.labels(seed, number, strength, length), draw)
}

fn beyond(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let (name, make) = outside::ALL[number % outside::ALL.len()];
    let round = number / outside::ALL.len();
    let (length, strength) = (Length::ALL[(number + round) % 3], [3.0, 1.0][round % 2]);
    let campaign = scenes::campaign(SceneKind::Coils, length, number.is_multiple_of(2), None, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let concealed = Concealed { name: name.into(), effect: make(&campaign, draw), strength, form_error: 0.0 };
    case::make(&campaign, noise, vec![concealed], Set::Outside.labels(seed, number, strength, length), draw)
}
