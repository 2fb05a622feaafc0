//! Every failure, and a word on each kind.

use std::collections::BTreeMap;

use crate::score::Score;
use crate::verdict::{Class, Outcome};

/// Whether an outcome is as it should be.
fn fails(outcome: &Outcome) -> bool {
    match outcome.truth.set.as_str() {
        "ambiguous" => outcome.class != Class::InSet,
        _ => !matches!(outcome.class, Class::Right | Class::InSet),
    }
}

/// The list.
pub fn section(score: &Score) -> String {
    let failed: Vec<&Outcome> = score.outcomes.iter().filter(|o| fails(o)).collect();
    let mut text = format!("## What fails\n\n{} of {} cases.\n\n", failed.len(), score.outcomes.len());
    let mut kinds: BTreeMap<(&str, &'static str), Vec<&Outcome>> = BTreeMap::new();
    for outcome in &failed {
        kinds.entry((outcome.truth.set.as_str(), kind(outcome))).or_default().push(outcome);
    }
    for ((set, kind), outcomes) in kinds {
        text += &format!("**{set}: {kind}** ({})\n\n", outcomes.len());
        for outcome in outcomes {
            let truth = &outcome.truth;
            let names: Vec<&str> = truth.effects.iter().map(|effect| effect.name.as_str()).collect();
            let what = if names.is_empty() { "nothing".to_string() } else { names.join(" and ") };
            let size =
                if truth.strength > 0.0 { format!(" at {} ×", truth.strength) } else { String::new() };
            text += &format!(
                "- {} {} (seed {}, {}, {}, `{}`): {what}{size}. Said: {}.\n",
                truth.set,
                truth.number,
                truth.seed,
                truth.length,
                truth.scene,
                truth.case,
                shortened(&outcome.said())
            );
        }
        text += "\n";
    }
    text
}

/// A long answer's beginning.
fn shortened(said: &str) -> String {
    const MOST: usize = 220;
    let kept: String = said.chars().take(MOST).collect();
    if kept.len() < said.len() { format!("{kept} …") } else { kept }
}

/// What went wrong, in words.
fn kind(outcome: &Outcome) -> &'static str {
    let accepted = |name: &String| outcome.truth.effects.iter().any(|e| e.accepted.contains(name));
    let right = outcome.claims.iter().any(|names| names.iter().any(accepted));
    let stray = || outcome.claims.iter().filter(|names| !names.iter().any(accepted)).flatten();
    let local = |name: &String| {
        name.starts_with("reading_step") || name.starts_with("spike") || name.starts_with("ageing")
    };
    match outcome.class {
        Class::Right => "one name where two are equally good",
        Class::InSet => "in the set",
        Class::Incomplete => "a part is named, the rest is not seen",
        Class::Unexplained => "structure is seen, and no name given",
        Class::Missed if outcome.truth.set == "outside" => "nothing is seen",
        Class::Missed => "nothing is seen: too weak for the level at which anything is claimed",
        Class::Wrong | Class::WrongSet if right && stray().all(local) => {
            "beside what is right a step, a spike or a drift, made of slow noise or of what the catalogue's form leaves"
        }
        Class::Wrong | Class::WrongSet if right => {
            "beside what is right something else, made of what the catalogue's form leaves"
        }
        Class::Wrong | Class::WrongSet if stray().all(local) => {
            "a step, a spike or a drift made of slow noise"
        }
        Class::Wrong => "another name",
        Class::WrongSet => "a set that has other names alone",
    }
}
