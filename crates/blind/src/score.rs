//! The scorecard of a folder whose answers are in.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use concealed::case::Truth;

use crate::Error;
use crate::folder;
use crate::reliability;
use crate::verdict::{Class, Outcome};
use crate::wilson::Share;

/// All outcomes of a folder, and the digest of its seals.
#[derive(Clone, Debug)]
pub struct Score {
    /// By set, seed and number.
    pub outcomes: Vec<Outcome>,
    /// Those of effects in real recordings, and of the recordings themselves: no goal of the others counts
    /// them.
    pub real: Vec<Outcome>,
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
        let (real, outcomes) = outcomes.into_iter().partition(|outcome| outcome.truth.set == injected::SET);
        Ok(Self { outcomes, real, seal })
    }

    /// How many cases there are.
    pub fn cases(&self) -> usize {
        self.outcomes.len() + self.real.len()
    }

    /// Those in which something of a sort was concealed.
    pub fn of_sort(&self, sort: Sort) -> impl Iterator<Item = &Outcome> + Clone {
        self.outcomes.iter().filter(move |outcome| Sort::of(outcome) == sort)
    }

    /// The sets, in the order of their names.
    pub fn sets(&self) -> BTreeSet<&str> {
        self.outcomes.iter().map(|outcome| outcome.truth.set.as_str()).collect()
    }

    /// How many of each class.
    pub fn classes<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> BTreeMap<Class, usize> {
        let mut counts = BTreeMap::new();
        outcomes.for_each(|outcome| *counts.entry(outcome.class).or_default() += 1);
        counts
    }

    /// The goals, each with what was reached.
    pub fn goals(&self) -> Vec<Goal> {
        let single = |strengths: &[f64]| {
            let wanted = |o: &&Outcome| strengths.contains(&o.truth.strength);
            Share::of(self.of_sort(Sort::Single).filter(wanted), |o| o.class == Class::Right)
        };
        let wrong =
            |sort: Sort| Share::of(self.of_sort(sort), |o| matches!(o.class, Class::Wrong | Class::WrongSet));
        let not_wrong = |sort: Sort| {
            Share::of(self.of_sort(sort), |o| !matches!(o.class, Class::Wrong | Class::WrongSet))
        };
        let at_least = |what, wanted, found| Goal { what, wanted, at_least: true, found };
        let at_most = |what, wanted, found| Goal { what, wanted, at_least: false, found };
        let explained =
            self.outcomes.iter().filter(|o| o.verdict == "explained" && !o.truth.effects.is_empty());
        let undecided = self
            .outcomes
            .iter()
            .filter(|o| o.verdict == "ambiguous" && o.truth.effects.iter().any(|e| !e.accepted.is_empty()));
        let named = |from: f64, to: f64| {
            let all = self.outcomes.iter().flat_map(|o| &o.names);
            Share::of(all.filter(|(p, _)| *p >= from && *p < to), |(_, right)| *right)
        };
        let held = reliability::of_intervals(self.outcomes.iter());
        let held = held.iter().find(|(level, _)| *level == 0.95).map(|(_, share)| *share).unwrap_or_default();
        vec![
            at_least("single effects at 1 and 3 times the noise, named right", 0.95, single(&[1.0, 3.0])),
            at_least("single effects at 0.3 times the noise, named right", 0.80, single(&[0.3])),
            at_least(
                "single effects at 10 and 100 times the noise, named right",
                0.95,
                single(&[10.0, 100.0]),
            ),
            at_most("single effects, a wrong name or a wrong set", 0.02, wrong(Sort::Single)),
            at_least(
                "several effects at once, all named right",
                0.85,
                Share::of(self.of_sort(Sort::Several), |o| o.class == Class::Right),
            ),
            at_most(
                "clean data, anything claimed",
                0.01,
                Share::of(self.of_sort(Sort::Clean), |o| o.class != Class::Right),
            ),
            at_least("outside the catalogue, no wrong name", 0.95, not_wrong(Sort::Outside)),
            at_least("taken out of the catalogue, no neighbour named", 0.95, not_wrong(Sort::Removed)),
            at_least(
                "explained, and readings left out within 5 % of the floor",
                0.95,
                Share::of(explained, |o| (o.over_floor() - 1.0).abs() <= 0.05),
            ),
            at_least(
                "told as undecided, the truth in the set",
                0.95,
                Share::of(undecided, |o| matches!(o.class, Class::Right | Class::InSet)),
            ),
            at_least("intervals of 95 % of parameters that hold", 0.93, held),
            at_least("names printed with 0.9 to 0.99, right", 0.9, named(0.9, 0.99)),
            at_least("names printed with more than 0.99, right", 0.99, named(0.99, f64::INFINITY)),
        ]
    }
}

/// What was concealed, by how an answer to it is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sort {
    /// Nothing.
    Clean,
    /// Nothing, in noise older than the recordings: no goal counts it.
    Old,
    /// One effect of the catalogue.
    Single,
    /// Several of them.
    Several,
    /// One that cannot be told from another.
    Ambiguous,
    /// What the catalogue does not have.
    Outside,
    /// What was taken out of the catalogue.
    Removed,
}

impl Sort {
    /// All of them with their words.
    pub const ALL: [(Sort, &'static str); 7] = [
        (Sort::Single, "one effect"),
        (Sort::Several, "several effects"),
        (Sort::Outside, "outside the catalogue"),
        (Sort::Removed, "taken out of the catalogue"),
        (Sort::Clean, "nothing"),
        (Sort::Old, "nothing, in older noise"),
        (Sort::Ambiguous, "one of two that cannot be told apart"),
    ];

    /// That of an outcome.
    pub fn of(outcome: &Outcome) -> Self {
        let truth = &outcome.truth;
        match (truth.set.as_str(), &truth.effects[..]) {
            ("old", _) => Sort::Old,
            ("ambiguous", _) => Sort::Ambiguous,
            _ if !truth.without.is_empty() => Sort::Removed,
            (_, []) => Sort::Clean,
            (_, effects) if effects.iter().all(|effect| effect.accepted.is_empty()) => Sort::Outside,
            (_, [_]) => Sort::Single,
            _ => Sort::Several,
        }
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
        if self.found.trials == 0 {
            return "no case";
        }
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
