//! Every failure, a line each.

use concealed::case::TrueEffect;

use crate::score::{Score, Sort};
use crate::verdict::{Class, Outcome};

/// Longest answer that is shown whole.
const MOST: usize = 200;

/// Whether an outcome is not as it should be.
fn fails(outcome: &Outcome) -> bool {
    match Sort::of(outcome) {
        Sort::Ambiguous => outcome.class != Class::InSet,
        _ => !matches!(outcome.class, Class::Right | Class::InSet),
    }
}

/// The list, the worst first.
pub fn section(score: &Score) -> String {
    let failed = || score.outcomes.iter().filter(|outcome| fails(outcome));
    let mut text = format!(
        "## Every failure\n\n{} of {} cases. Each line has set and number, recording conditions, the concealed effect with its size over \
        the noise, and the answer.\n",
        failed().count(),
        score.outcomes.len()
    );
    for class in Class::ALL.into_iter().rev() {
        let own: Vec<&Outcome> = failed().filter(|outcome| outcome.class == class).collect();
        if own.is_empty() {
            continue;
        }
        text += &format!("\n**{}** ({})\n\n", class.words(), own.len());
        own.into_iter().for_each(|outcome| text += &line(outcome));
    }
    text
}

fn line(outcome: &Outcome) -> String {
    let truth = &outcome.truth;
    let one = |effect: &TrueEffect| {
        format!("{} ({}) {:.1} ×", effect.name, effect.physics, effect.left_nt / truth.noise_nt)
    };
    let names: Vec<String> = truth.effects.iter().map(one).collect();
    let what = if names.is_empty() { "nothing".to_string() } else { names.join(" and ") };
    let how: Vec<&str> = [&*truth.length, &*truth.scene]
        .into_iter()
        .chain(truth.recorded.iter().map(String::as_str))
        .collect();
    let said = outcome.said();
    let kept: String = said.chars().take(MOST).collect();
    let rest = if kept.len() < said.len() { " …" } else { "" };
    format!(
        "- {} {} ({}, `{}`): {what}: {kept}{rest}.\n",
        truth.set,
        truth.number,
        how.join(", "),
        truth.case
    )
}
