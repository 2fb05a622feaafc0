//! What each finding does to the result, by numbers that the document holds.
//!
//! A stage says a finding as a sentence. A rule knows it by a phrase, and takes its effect from the part of
//! the document that the finding is about.

pub mod axes;
pub mod differential;
pub mod sensors;

use crate::{Effect, Finding};

/// It says how well something is known.
pub const UNCERTAINTY: Effect = Effect::Unstated("uncertainties only");
/// The recordings leave it open.
pub const NOT_SHOWN: Effect = Effect::Unstated("not determined by the readings");
/// Several explanations fit.
pub const UNDECIDED: Effect = Effect::Unstated("the readings do not decide");
/// The result is stated without what it is about.
pub const LEFT_OUT: Effect = Effect::Unstated("left out of the result");
/// Chance would do as much.
pub const NOT_SIGNIFICANT: Effect = Effect::Unstated("not significant");

/// A phrase of a finding, and what such a finding does to the result.
pub type Rule<T> = (&'static str, fn(&T, &str) -> Effect);

/// Findings about a part of a document, each led by whose it is.
pub fn findings<T>(whose: &str, said: &[String], rules: &[Rule<T>], part: &T) -> Vec<Finding> {
    let lead = if whose.is_empty() { String::new() } else { format!("{whose}: ") };
    said.iter().map(|words| Finding::of(format!("{lead}{words}"), effect(words, rules, part))).collect()
}

fn effect<T>(words: &str, rules: &[Rule<T>], part: &T) -> Effect {
    let rule = rules.iter().find(|(phrase, _)| words.contains(phrase));
    rule.map_or(Effect::NOT_HELD, |(_, effect)| effect(part, words))
}

/// The largest of some numbers in size; None of none.
fn largest(all: impl IntoIterator<Item = f64>) -> Option<f64> {
    all.into_iter().map(f64::abs).filter(|size| size.is_finite()).reduce(f64::max)
}

/// The number that stands in a finding right before some words.
fn before(words: &str, follow: &str) -> Option<f64> {
    let ahead = words.split_once(follow)?.0.trim_end();
    ahead.rsplit(' ').next()?.replace('−', "-").parse().ok()
}

/// The largest parameter of the departures that were found and are named in a finding, in its standard
/// uncertainties.
fn departure(departures: &[common::Departure], words: &str) -> Effect {
    let named = |one: &&common::Departure| {
        one.found && words.replace(' ', "_").contains(&one.departure.replace(' ', "_"))
    };
    let values = departures.iter().filter(named).flat_map(|one| one.parameter.values());
    Effect::std(largest(values.filter_map(|value| Some(value.value() / value.std()?))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn every_phrase_is_said_by_its_stage() {
        said_by("axescal", &axes::RULES);
        said_by("coilcal", &sensors::COIL);
        said_by("diffmag", &differential::FIT);
        said_by("diffmag", &differential::STABILITY);
        said_by("diffmag", &differential::REFERENCE);
        said_by("scalarcal", &axes::SCALAR);
        said_by("sensorcal", &sensors::SENSITIVITY);
        said_by("sensorcal", &sensors::REVERSAL);
        said_by("sensorcal", &sensors::DRIFT);
        said_by("sensorcal", &sensors::NOISE);
        said_by("sensorcal", &sensors::TEMPERATURE);
        said_by("sensorcal", &sensors::CROSS_FIELD);
    }

    /// Holds the phrases of rules to the sources of the stage that says them, without the breaks of their
    /// lines.
    fn said_by<T>(stage: &str, rules: &[Rule<T>]) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(stage).join("src");
        let mut all = String::new();
        collect(&folder, &mut all);
        for (phrase, _) in rules {
            assert!(all.contains(phrase), "no finding of {stage} has the phrase {phrase:?}");
        }
    }

    fn collect(folder: &Path, all: &mut String) {
        for entry in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path())
        {
            if entry.is_dir() {
                collect(&entry, all);
            } else {
                let text = std::fs::read_to_string(&entry).expect("a source");
                let mut parts = text.split("\\\n");
                all.push_str(parts.next().unwrap_or_default());
                parts.for_each(|part| all.push_str(part.trim_start()));
            }
        }
    }

    #[test]
    fn a_number_before_words() {
        assert_eq!(before("pull it 5.3 standard uncertainties away", " standard"), Some(5.3));
        assert_eq!(before("by −4.25 nT", " nT"), Some(-4.25));
        assert_eq!(before("by much nT", " nT"), None);
        assert_eq!(before("nothing of it", " nT"), None);
    }
}
