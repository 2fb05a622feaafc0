//! What came of effects in real recordings: named, sized, and removed.

use std::collections::BTreeMap;

use crate::score::{Goal, Score};
use crate::verdict::{Class, HALF_95, Outcome};
use crate::wilson::Share;

/// Readings left out are predicted as before the injection within this, relative.
pub const CLOSE: f64 = 0.05;

/// An effect in a real recording.
#[derive(Clone, Copy, Debug)]
pub struct Hosted<'o> {
    /// What came of it.
    pub outcome: &'o Outcome,
    /// Rms of readings left out after diagnose, over that of the host as it came.
    pub held_out: f64,
}

impl<'o> Hosted<'o> {
    /// All of a score, host by host in the order of their names, the largest first.
    pub fn all(score: &'o Score) -> Vec<Self> {
        let hosts: BTreeMap<&str, f64> =
            untouched(score).map(|host| (host.truth.scene.as_str(), host.rms_nt[2])).collect();
        let injected = score.real.iter().filter(|outcome| !outcome.truth.effects.is_empty());
        let mut all: Vec<Self> = injected
            .map(|outcome| {
                let own = hosts.get(outcome.truth.scene.as_str()).copied().unwrap_or(f64::NAN);
                Self { outcome, held_out: outcome.rms_nt[2] / own }
            })
            .collect();
        all.sort_by(|a, b| {
            let (a, b) = (&a.outcome.truth, &b.outcome.truth);
            a.scene.cmp(&b.scene).then(b.strength.total_cmp(&a.strength)).then(a.number.cmp(&b.number))
        });
        all
    }

    /// Whether the name is right.
    pub fn named(&self) -> bool {
        self.outcome.class == Class::Right
    }

    /// Whether all parameters that are told of it hold; None where the name is not right or the truth has
    /// none to hold against.
    pub fn sized(&self) -> Option<bool> {
        let off = &self.outcome.parameters;
        (!off.is_empty()).then(|| off.iter().all(|one| one.off.abs() <= HALF_95))
    }

    /// Whether readings left out are predicted as before the injection.
    pub fn removed(&self) -> bool {
        (self.held_out - 1.0).abs() <= CLOSE
    }
}

/// The hosts as they came, by name.
pub fn untouched(score: &Score) -> impl Iterator<Item = &Outcome> {
    let mut hosts: Vec<&Outcome> = score.real.iter().filter(|one| one.truth.effects.is_empty()).collect();
    hosts.sort_by(|a, b| a.truth.scene.cmp(&b.truth.scene));
    hosts.into_iter()
}

/// The goals, analogous to those of what is made up; none where there are no real recordings.
pub fn goals(score: &Score) -> Vec<Goal> {
    if score.real.is_empty() {
        return Vec::new();
    }
    let all = Hosted::all(score);
    let at = |so: fn(f64) -> bool| all.iter().filter(move |one| so(one.outcome.truth.strength));
    let named = |those: &mut dyn Iterator<Item = &Hosted>| Share::of(those, |one| one.named());
    let wrong = |one: &&Hosted| matches!(one.outcome.class, Class::Wrong | Class::WrongSet);
    let right = || all.iter().filter(|one| one.named());
    let parameters = || right().flat_map(|one| &one.outcome.parameters).filter(|one| !one.at_least);
    let at_least = |what, wanted, found| Goal { what, wanted, at_least: true, found };
    let at_most = |what, wanted, found| Goal { what, wanted, at_least: false, found };
    vec![
        at_least(
            "in real recordings, at 1 to 10 times the scatter, named right",
            0.95,
            named(&mut at(|s| s >= 1.0)),
        ),
        at_least(
            "in real recordings, at 0.3 times the scatter, named right",
            0.80,
            named(&mut at(|s| s < 1.0)),
        ),
        at_most("in real recordings, a wrong name or a wrong set", 0.02, Share::of(&all, wrong)),
        at_least(
            "in real recordings, intervals of 95 % of parameters that hold",
            0.93,
            Share::of(parameters(), |one| one.off.abs() <= HALF_95),
        ),
        at_least(
            "in real recordings, named right, and readings left out predicted within 5 % as before the injection",
            0.95,
            Share::of(right(), |one| one.removed()),
        ),
        at_most(
            "real recordings as they came, anything claimed",
            0.01,
            Share::of(untouched(score), |outcome| outcome.class != Class::Right),
        ),
    ]
}
