//! The score as tables.

use std::collections::{BTreeMap, BTreeSet};

use crate::hosted;
use crate::score::{Score, Sort};
use crate::verdict::{Class, Outcome};
use crate::wilson::Share;

/// The goals.
pub fn goals(score: &Score) -> String {
    let mut text = String::from("## Goals\n\n| goal | wanted | found | |\n| --- | --- | --- | --- |\n");
    // What is missed comes first.
    let mut goals = [score.goals(), hosted::goals(score)].concat();
    goals.sort_by_key(|goal| !goal.verdict().starts_with("missed"));
    for goal in goals {
        text +=
            &format!("| {} | {} | {} | {} |\n", goal.what, goal.wanted(), goal.found.words(), goal.verdict());
    }
    text
}

/// What came of each set.
pub fn sets(score: &Score) -> String {
    let mut text = String::from("## Results\n\n| concealed | set | cases |");
    text += &Class::ALL.map(|class| format!(" {} |", class.words())).concat();
    text += &format!("\n| --- | --- | --- |{}\n", " --- |".repeat(Class::ALL.len()));
    for (sort, words) in Sort::ALL {
        for set in score.sets() {
            let own = || score.of_sort(sort).filter(|outcome| outcome.truth.set == set);
            if own().next().is_none() {
                continue;
            }
            let classes = Score::classes(own());
            let cells = Class::ALL.map(|class| format!(" {} |", classes.get(&class).copied().unwrap_or(0)));
            text += &format!("| {words} | {set} | {} |{}\n", own().count(), cells.concat());
        }
    }
    text + "\nIf nothing was concealed, the correct answer claims nothing. Outside the catalogue it is `unexplained` with the structure \
    described. For two indistinguishable effects it is the set of both; a single name, even one of the two, claims more than the data show.\n"
}

/// Single effects by strength, length and how they were recorded.
pub fn strengths(score: &Score) -> String {
    let mut text = String::from(
        "## Single effects by strength, length and how they were recorded\n\n| | cases | named right | right, or in the set | wrong name or set |\n| --- | --- | --- | --- | --- |\n",
    );
    let mut line = |what: String, so: &dyn Fn(&Outcome) -> bool| {
        let those: Vec<&Outcome> = score.of_sort(Sort::Single).filter(|o| so(o)).collect();
        if those.is_empty() {
            return;
        }
        let share = |so: fn(Class) -> bool| Share::of(&those, |o| so(o.class)).words();
        let right = share(|class| class == Class::Right);
        let set = share(|class| matches!(class, Class::Right | Class::InSet));
        let wrong = share(|class| matches!(class, Class::Wrong | Class::WrongSet));
        text += &format!("| {what} | {} | {right} | {set} | {wrong} |\n", those.len());
    };
    for strength in strengths_of(score) {
        line(format!("{strength} × noise"), &|o| o.truth.strength == strength);
    }
    for length in ["short", "medium", "long", "campaign", "day", "longest"] {
        line(length.into(), &|o| o.truth.length == length);
    }
    for covariates in ["apart", "together"] {
        line(format!("temperatures {covariates}"), &|o| o.truth.covariates == covariates);
    }
    for how in HOW {
        line(how.into(), &|o| o.truth.recorded.iter().any(|own| own.contains(how)));
    }
    line("as clean as can be".into(), &|o| o.truth.recorded.is_empty());
    text + "\nShort, medium, long, campaign, day, longest: below 400, 720, 1 700, 5 200, 16 000 rows of three sensors, and more. Together: \
    the thermometers of electronics and coil mostly follow that of the sensor. Noise declared: a tenth too large or too small. \
            Follows the truth: a housekeeping column that follows the cause of the effect. Correlates by chance: the one of sixty random \
            series that correlates most with the effect. Codes: a quantisation step of a third to three times the white noise, declared.\n"
}

/// What a truth says of how it was recorded.
const HOW: [&str; 12] = [
    "gaps",
    "lost rows",
    "uneven times",
    "times to 1 ms",
    "times to 1 us",
    "decoys",
    "follows the truth",
    "correlates by chance",
    "a storm",
    "codes of",
    "noise declared",
    "noise not declared",
];

/// The strengths of single effects, the largest first.
pub fn strengths_of(score: &Score) -> Vec<f64> {
    let mut all: Vec<f64> = score.of_sort(Sort::Single).map(|outcome| outcome.truth.strength).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    all.dedup();
    all
}

/// Each kind of single effect and its forms.
pub fn kinds(score: &Score) -> String {
    let strengths = strengths_of(score);
    let mut text = String::from("## Kind by kind\n\n| effect | physics |");
    strengths.iter().for_each(|strength| text += &format!(" {strength} × noise |"));
    text += &format!("\n| --- | --- |{}\n", " --- |".repeat(strengths.len()));
    let of = |outcome: &Outcome| {
        let effect = &outcome.truth.effects[0];
        (effect.name.clone(), effect.physics.clone())
    };
    let all: BTreeSet<(String, String)> = score.of_sort(Sort::Single).map(of).collect();
    for kind in all {
        let cell = |strength: &f64| {
            let those =
                score.of_sort(Sort::Single).filter(|o| o.truth.strength == *strength && of(o) == kind);
            format!(" {} |", those.map(in_a_word).collect::<Vec<_>>().join("; "))
        };
        let cells: String = strengths.iter().map(cell).collect();
        text += &format!("| `{}` | {} |{cells}\n", kind.0, kind.1);
    }
    text
}

/// Each name that was taken out of the catalogue, and what came of it.
pub fn removed(score: &Score) -> String {
    let mut text = String::from(
        "## Taken out of the catalogue\n\n| taken out | physics | times the noise | | answer | place |\n| --- | --- | --- | --- | --- | --- |\n",
    );
    for outcome in score.of_sort(Sort::Removed) {
        for effect in &outcome.truth.effects {
            let place = outcome.located.map_or("–", |right| if right { "right" } else { "wrong" });
            text += &format!(
                "| `{}` | {} | {:.1} | {} | {} | {place} |\n",
                outcome.truth.without.join("`, `"),
                effect.physics,
                effect.left_nt / outcome.truth.noise_nt,
                outcome.class.words(),
                outcome.said()
            );
        }
    }
    text + "\nEach effect of the catalogue that has a generator, in turn: `diagnose --without` excludes the correct names and their fuller \
    forms. The correct answer is `unexplained` with the structure described; any name is then that of a neighbour, though some neighbours \
    predict the same readings.\n"
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
        Share::of(score.of_sort(Sort::Outside).filter(|o| o.located.is_some()), |o| o.located == Some(true));
    let mut text = String::from("## Location, parameters, residuals\n\n| | |\n| --- | --- |\n");
    text += &format!("| located right, of all that is told | {} |\n", located.words());
    text += &format!("| located right, outside the catalogue | {} |\n", outside.words());
    let mut ratios: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let clean = score
        .of_sort(Sort::Clean)
        .filter(|o| o.verdict == "agrees")
        .map(|o| ("clean, `agrees`".to_string(), o));
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
    text + "\nLocated: the reported sensors are those affected; for an effect in the field, GEO or several sensors are reported. Parameters \
    are those with a counterpart in the finer physics (a coefficient for slow changes, a lag as the mean lag): two lags are matched exactly \
    by none. Held-out readings have the uncertainty of two dozen constants in addition to the noise; the line of the clean data shows the \
    attainable limit.\n"
}
