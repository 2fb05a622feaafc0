//! The score as tables.

use concealed::kinds;
use concealed::sets::{STRENGTHS, Set};
use std::collections::{BTreeMap, BTreeSet};

use crate::score::Score;
use crate::verdict::{Class, Outcome};
use crate::wilson::Share;

/// The goals.
pub fn goals(score: &Score) -> String {
    let mut text = String::from("## Goals\n\n| goal | wanted | found | |\n| --- | --- | --- | --- |\n");
    for goal in score.goals() {
        text +=
            &format!("| {} | {} | {} | {} |\n", goal.what, goal.wanted(), goal.found.words(), goal.verdict());
    }
    text
}

/// What came of each set.
pub fn sets(score: &Score) -> String {
    let mut text = String::from("## What came of it\n\n| set | cases |");
    text += &Class::ALL.map(|class| format!(" {} |", class.words())).concat();
    text += &format!("\n| --- | --- |{}\n", " --- |".repeat(Class::ALL.len()));
    for set in Set::ALL {
        let classes = Score::classes(score.set(set.word()));
        let cells = Class::ALL.map(|class| format!(" {} |", classes.get(&class).copied().unwrap_or(0)));
        text += &format!("| {} | {} |{}\n", set.word(), score.set(set.word()).count(), cells.concat());
    }
    text + "\n`clean`: nothing was concealed; right is to claim nothing. `old`: the same in noise that did not begin with the recordings, as the format \
            would have it, but long before, as real noise does: outside the goals. `ambiguous`: the same readings follow from either of two effects; right is the set of \
            both, and a single name says more than can be known, even where it is one of the two. `outside`: the catalogue has no name; right is `unexplained`.\n"
}

/// Single effects by strength, length and covariates.
pub fn strengths(score: &Score) -> String {
    let mut text = String::from(
        "## Single effects by strength, length and collinearity\n\n| | cases | named right | right, or in the set | wrong name |\n| --- | --- | --- | --- | --- |\n",
    );
    let mut line = |what: String, so: &dyn Fn(&Outcome) -> bool| {
        let those: Vec<&Outcome> = score.set("single").filter(|o| so(o)).collect();
        let share = |so: fn(Class) -> bool| Share::of(&those, |o| so(o.class)).words();
        let right = share(|class| class == Class::Right);
        let set = share(|class| matches!(class, Class::Right | Class::InSet));
        let wrong = share(|class| class == Class::Wrong);
        text += &format!("| {what} | {} | {right} | {set} | {wrong} |\n", those.len());
    };
    for strength in STRENGTHS {
        line(format!("{strength} × noise"), &|o| o.truth.strength == strength);
    }
    for length in ["short", "medium", "long"] {
        line(format!("{length} recordings, 1 × and 3 ×"), &|o| {
            o.truth.length == length && o.truth.strength >= 1.0
        });
    }
    for covariates in ["apart", "together"] {
        line(format!("temperatures {covariates}"), &|o| o.truth.covariates == covariates);
    }
    text + "\nShort, medium, long: about 300, 540, 960 rows of three sensors; at 0.3 × the noise medium and long alone. Together: the thermometers of electronics and \
            coil follow the sensor's for the greater part.\n"
}

/// Each kind of single effect.
pub fn kinds(score: &Score) -> String {
    let mut text = String::from("## Kind by kind\n\n| effect |");
    text += &STRENGTHS.map(|strength| format!(" {strength} × noise |")).concat();
    text += &format!("\n| --- |{}\n", " --- |".repeat(STRENGTHS.len()));
    for kind in kinds::ALL {
        let cell = |strength: f64| {
            let those = score.set("single").filter(|o| o.truth.strength == strength);
            let words: Vec<String> = those
                .filter(|o| o.truth.effects.iter().any(|e| e.name == kind.name))
                .map(in_a_word)
                .collect();
            words.join("; ")
        };
        text += &format!("| `{}` |{}\n", kind.name, STRENGTHS.map(|s| format!(" {} |", cell(s))).concat());
    }
    text
}

fn in_a_word(outcome: &Outcome) -> String {
    match outcome.class {
        Class::Right if outcome.verdict == "partly_explained" => "right, something left".into(),
        Class::InSet => {
            let most = outcome.claims.iter().map(Vec::len).max().unwrap_or(0);
            format!("one of {most}")
        }
        class => class.words().into(),
    }
}

/// Places, parameters and what is left.
pub fn figures(score: &Score) -> String {
    let found: Vec<&Outcome> = score.outcomes.iter().filter(|o| !o.truth.effects.is_empty()).collect();
    let located = Share::of(found.iter().filter(|o| o.located.is_some()), |o| o.located == Some(true));
    let outside =
        Share::of(score.set("outside").filter(|o| o.located.is_some()), |o| o.located == Some(true));
    let mut text = String::from("## Places, parameters, what is left\n\n| | |\n| --- | --- |\n");
    text += &format!("| located right, of all that is told | {} |\n", located.words());
    text += &format!("| located right, outside the catalogue | {} |\n", outside.words());
    let mut ratios: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let clean =
        score.set("clean").filter(|o| o.verdict == "agrees").map(|o| ("clean, `agrees`".to_string(), o));
    for (what, outcome) in found.iter().map(|o| (format!("`{}`", o.verdict), *o)).chain(clean) {
        ratios.entry(what).or_default().push(outcome.over_floor());
    }
    for (what, ratios) in &mut ratios {
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| ratios[((ratios.len() - 1) as f64 * share).round() as usize];
        text += &format!(
            "| readings left out over the noise drawn, {what} | {:.3} (5 % of cases below {:.3}, 5 % above {:.3}) |\n",
            at(0.5),
            at(0.05),
            at(0.95)
        );
    }
    let mut before: Vec<f64> = found.iter().map(|o| o.rms_nt[0] / o.truth.noise_nt).collect();
    before.sort_by(f64::total_cmp);
    if let Some(middle) = before.get(before.len() / 2) {
        text += &format!(
            "| rms as it came, with the earlier calibration, over the noise drawn, median | {middle:.2} |\n"
        );
    }
    text + "\nLocated: the sensors told are those that show it; for what is in the field, GEO or several sensors are told. Parameters are those for which the finer \
            physics has a counterpart (a coefficient for slow changes, a lag as the mean lag): a lag that is really two is met by none exactly. Readings left out \
            carry the uncertainty of two dozen constants beside the noise: the line of the clean data says what can be had.\n"
}

/// What stepwise regression and thresholded least squares choose on the same cases.
pub fn baselines(score: &Score) -> String {
    let mut text = String::from(
        "## Beside it\n\n| | diagnose | stepwise BIC | thresholded least squares |\n| --- | --- | --- | --- |\n",
    );
    let mut line = |what: &str,
                    set: &str,
                    ours: fn(&Outcome) -> bool,
                    theirs: fn(&Outcome, &BTreeSet<String>) -> bool| {
        let of = |which: usize| Share::of(score.set(set), |o| theirs(o, &o.truth.baselines[which])).words();
        text += &format!(
            "| {what} | {} | {} | {} |\n",
            Share::of(score.set(set), |o| ours(o)).words(),
            of(0),
            of(1)
        );
    };
    line(
        "single: the truth, alone",
        "single",
        |o| o.class == Class::Right,
        |o, chosen| {
            !chosen.is_empty()
                && chosen.iter().all(|name| o.truth.effects.iter().any(|e| e.accepted.contains(name)))
        },
    );
    line(
        "single: something that is not there",
        "single",
        |o| o.class == Class::Wrong,
        |o, chosen| chosen.iter().any(|name| !o.truth.effects.iter().any(|e| e.accepted.contains(name))),
    );
    line("clean: something claimed", "clean", |o| o.class != Class::Right, |_, chosen| !chosen.is_empty());
    line("outside: something named", "outside", |o| o.class == Class::Wrong, |_, chosen| !chosen.is_empty());
    text + "\nThe two are given the true calibration for their model, and some 25 simple regressors a sensor (`crates/testkit/src/baselines`). Many kinds have no \
            regressor of theirs: those they cannot name.\n"
}
