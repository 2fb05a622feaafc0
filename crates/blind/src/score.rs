//! The scorecard of a folder whose answers are in.

use std::collections::BTreeMap;
use std::path::Path;

use concealed::case::Truth;

use crate::Error;
use crate::folder;
use crate::verdict::{Class, Outcome};
use crate::wilson::Share;

/// All outcomes of a folder, and the digest of its seals.
#[derive(Clone, Debug)]
pub struct Score {
    /// By set, seed and number.
    pub outcomes: Vec<Outcome>,
    /// SHA-256 of the file of seals.
    pub seal: String,
}

impl Score {
    /// Holds answers against opened truths.
    pub fn of(truths: Vec<Truth>, answers: &Path, seal: String) -> Result<Self, Error> {
        let one = |truth: Truth| -> Result<Outcome, Error> {
            let answer = folder::value(&answers.join(format!("{}.json", truth.case)))?;
            Ok(Outcome::of(truth, &answer))
        };
        let mut outcomes: Vec<Outcome> = truths.into_iter().map(one).collect::<Result<_, Error>>()?;
        outcomes.sort_by(|a, b| {
            let key = |o: &Outcome| (o.truth.set.clone(), o.truth.seed, o.truth.number);
            key(a).cmp(&key(b))
        });
        Ok(Self { outcomes, seal })
    }

    /// Those of a set.
    pub fn set<'a>(&'a self, set: &'a str) -> impl Iterator<Item = &'a Outcome> + Clone {
        self.outcomes.iter().filter(move |outcome| outcome.truth.set == set)
    }

    /// How many of each class.
    pub fn classes<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> BTreeMap<Class, usize> {
        let mut counts = BTreeMap::new();
        outcomes.for_each(|outcome| *counts.entry(outcome.class).or_default() += 1);
        counts
    }

    /// The goals, each with what was reached.
    pub fn goals(&self) -> Vec<Goal> {
        let single = |strong: bool| {
            let wanted = move |o: &&Outcome| (o.truth.strength >= 1.0) == strong;
            Share::of(self.set("single").filter(wanted), |o| o.class == Class::Right)
        };
        let of = |set: &'static str, class: Class| Share::of(self.set(set), move |o| o.class == class);
        let at_least = |what, wanted, found| Goal { what, wanted, at_least: true, found };
        let at_most = |what, wanted, found| Goal { what, wanted, at_least: false, found };
        let explained =
            self.outcomes.iter().filter(|o| o.verdict == "explained" && !o.truth.effects.is_empty());
        vec![
            at_least("single effects at 3 and 1 times the noise, named right", 0.95, single(true)),
            at_least("single effects at 0.3 times the noise, named right", 0.80, single(false)),
            at_most("single effects, a wrong name", 0.02, of("single", Class::Wrong)),
            at_most(
                "clean data, anything claimed",
                0.01,
                Share::of(self.set("clean"), |o| o.class != Class::Right),
            ),
            at_most("outside the catalogue, a wrong name", 0.05, of("outside", Class::Wrong)),
            at_least("two effects at once, both named right", 0.85, of("pairs", Class::Right)),
            at_least(
                "explained, and readings left out within 5 % of the floor",
                0.95,
                Share::of(explained, |o| (o.over_floor() - 1.0).abs() <= 0.05),
            ),
        ]
    }
}

/// What was wanted and what was reached.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// In words.
    pub what: &'static str,
    /// Share wanted.
    pub wanted: f64,
    /// Whether at least or at most that share.
    pub at_least: bool,
    /// Share reached.
    pub found: Share,
}

impl Goal {
    /// `met`, `missed`, or `within the interval`: missed by a figure whose interval holds what was wanted.
    pub fn verdict(&self) -> &'static str {
        let value = self.found.value();
        let [low, high] = self.found.interval();
        match if self.at_least { value >= self.wanted } else { value <= self.wanted } {
            true => "met",
            false if (low..=high).contains(&self.wanted) => "missed, within the interval",
            false => "missed",
        }
    }

    /// `at least 95 %`.
    pub fn wanted(&self) -> String {
        format!("{} {:.0} %", if self.at_least { "at least" } else { "at most" }, 100.0 * self.wanted)
    }
}
