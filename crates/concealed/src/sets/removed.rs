//! A catalogue with the entry removed: one effect of every name in turn, its name and those that would be
//! right as well taken out.

use super::set::Set;
use crate::case::{self, Case, Concealed};
use crate::draw::Draw;
use crate::form;
use crate::groups::{self, Group};
use crate::kinds::{self, Single};
use crate::scenes::{self, Length};

/// Times the noise, in the rounds one after the other.
const STRENGTHS: [f64; 3] = [3.0, 10.0, 1.0];

/// A kind of every name: of several forms one that may be looked at.
pub(super) fn names() -> Vec<Single> {
    let mut all: Vec<Single> = kinds::ALL.into_iter().chain(kinds::FURTHER).collect();
    all.sort_by_key(|kind| groups::of(kind.name, kind.form) != Group::Develop);
    let mut names: Vec<Single> = Vec::new();
    for kind in all {
        if names.iter().all(|own| own.name != kind.name) {
            names.push(kind);
        }
    }
    names
}

/// One of them in three thousand rows.
pub(super) fn case(seed: u64, number: usize, draw: &mut Draw) -> Case {
    let names = names();
    let (which, round) = (names[number % names.len()], number / names.len());
    let (length, strength) = (Length::Campaign, STRENGTHS[round % STRENGTHS.len()]);
    let campaign = scenes::campaign(which.scene, length, number.is_multiple_of(2), which.step_s, draw);
    let noise = case::noise_of(draw, campaign.runs[0].step_s());
    let (effect, form_error) = form::inexact(which.name, (which.make)(&campaign, draw), &campaign, draw);
    let concealed = Concealed { name: which.name.into(), effect, strength, form_error };
    let labels = Set::Removed.labels(seed, number, strength, length);
    let mut case = case::make(&campaign, noise, vec![concealed], labels, draw);
    case.truth.take_names();
    case
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_would_be_right_and_each_is_taken_out_once() {
        let mut taken: Vec<String> = Vec::new();
        for number in 0..names().len() {
            let Case { truth, .. } = case(4, number, &mut Draw::new("removed", number as u64));
            assert!(truth.effects[0].accepted.is_empty(), "{}", truth.effects[0].name);
            assert!(truth.without.contains(&truth.effects[0].name), "{:?}", truth.without);
            taken.push(truth.effects[0].name.clone());
        }
        taken.sort();
        taken.dedup();
        assert!(taken.len() == names().len() && taken.len() >= 40, "{}", taken.len());
    }
}
