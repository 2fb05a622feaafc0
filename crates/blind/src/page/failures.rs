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

/// The list, by what lies behind.
pub fn section(score: &Score) -> String {
    let failed: Vec<&Outcome> = score.outcomes.iter().filter(|o| fails(o)).collect();
    let mut text = format!(
        "## What fails, and why\n\n{} of {} cases. Each line: set and number, what was concealed and at how many times the noise, the answer's kind, the answer.\n\n",
        failed.len(),
        score.outcomes.len()
    );
    let mut causes: BTreeMap<Cause, Vec<&Outcome>> = BTreeMap::new();
    for outcome in &failed {
        causes.entry(Cause::of(outcome)).or_default().push(outcome);
    }
    for (cause, outcomes) in causes {
        text += &format!("**{}** ({}). {}\n\n", cause.title(), outcomes.len(), cause.words());
        outcomes.iter().for_each(|outcome| text += &line(outcome));
        text += "\n";
    }
    text
}

fn line(outcome: &Outcome) -> String {
    const MOST: usize = 200;
    let truth = &outcome.truth;
    let size = |effect: &concealed::case::TrueEffect| format!("{:.1}", effect.left_nt / truth.noise_nt);
    let names: Vec<String> =
        truth.effects.iter().map(|effect| format!("{} {} ×", effect.name, size(effect))).collect();
    let what = if names.is_empty() { "nothing".to_string() } else { names.join(" and ") };
    let said = outcome.said();
    let kept: String = said.chars().take(MOST).collect();
    let rest = if kept.len() < said.len() { " …" } else { "" };
    format!(
        "- {} {} ({}, {}, `{}`): {what}. {}: {kept}{rest}.\n",
        truth.set,
        truth.number,
        truth.length,
        truth.scene,
        truth.case,
        outcome.class.words()
    )
}

/// What lies behind a failure, as far as it was looked into.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Cause {
    OldNoise,
    Clean,
    TooWeak,
    Converter,
    Hysteresis,
    Diffusion,
    Plates,
    Hours,
    CoilHeating,
    Outside,
    Decided,
    Several,
    Form,
}

impl Cause {
    fn of(outcome: &Outcome) -> Self {
        let conceals =
            |names: &[&str]| outcome.truth.effects.iter().any(|effect| names.contains(&effect.name.as_str()));
        match outcome.truth.set.as_str() {
            "old" => Cause::OldNoise,
            "clean" => Cause::Clean,
            "outside" => Cause::Outside,
            "ambiguous" => Cause::Decided,
            _ if outcome.class == Class::Missed => Cause::TooWeak,
            _ if conceals(&["quantisation", "differential_nonlinearity"]) => Cause::Converter,
            _ if conceals(&["hysteresis"]) => Cause::Hysteresis,
            _ if conceals(&["induction_difference"]) => Cause::Diffusion,
            _ if conceals(&["sun_thermoelectric"]) => Cause::Plates,
            _ if conceals(&["working_hours"]) => Cause::Hours,
            _ if conceals(&["coil_heating"]) => Cause::CoilHeating,
            "pairs" | "triples" => Cause::Several,
            _ => Cause::Form,
        }
    }

    fn title(self) -> &'static str {
        match self {
            Cause::OldNoise => "Noise older than the recordings",
            Cause::Clean => "Claims on clean data",
            Cause::TooWeak => "Not seen",
            Cause::Converter => "Converters",
            Cause::Hysteresis => "Preisach's hysteresis",
            Cause::Diffusion => "Induction by diffusion",
            Cause::Plates => "The Sun on plates",
            Cause::Hours => "Machines switched by hand",
            Cause::CoilHeating => "Coils that heat themselves",
            Cause::Outside => "Outside the catalogue",
            Cause::Decided => "Decided where nobody can",
            Cause::Several => "Several at once",
            Cause::Form => "Others",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Cause::OldNoise => {
                "Where flicker noise is declared, `diagnose` lets it go on below one over the record's length, to an eighth of one over the campaign's: levels and trends are allowed for. What is \
                 slower still is now and then taken for an effect. No goal counts these cases; who has real recordings should."
            }
            Cause::Clean => {
                "The level is 1 % for all candidates together: of a hundred clean campaigns one is to be expected. The noise here does not repeat with its record, as the covariance that whitens it has it."
            }
            Cause::TooWeak => {
                "Below the level at which anything is claimed among all candidates (1 %), in the readings that there are."
            }
            Cause::Converter => {
                "Uneven codes leave structure along the own reading, or single readings that a spike explains as well. Then the name falls, or a spike stands beside it as an equal; in \
                 sets the other names of the sensor fall with it."
            }
            Cause::Hysteresis => {
                "Preisach's model with interaction fields as wide as the range is a sum of play operators, and the catalogue's `perming` is one such operator: it fits better \
                 than the catalogue's `hysteresis`. Sealed as right was `hysteresis` alone; the name found is wrong, the physics near."
            }
            Cause::Diffusion => {
                "Diffusion goes with the root of frequency, the catalogue's lag with one time constant: what that leaves has another name, or, in short recordings whose noise is not \
                 declared, a drift has it all."
            }
            Cause::Plates => {
                "Lambert's law cuts off at a plate's edge. Twelve coefficients and more cost much by Bayes' criterion: a step that says a part is found first, and beside it the Sun no longer \
                 predicts what is left out."
            }
            Cause::Hours => {
                "Minutes by which the hours are missed differ from day to day; the catalogue has one slack for all."
            }
            Cause::CoilHeating => {
                "Winding and former warm each other, where the catalogue has one time constant: what that leaves takes names back that were found beside it."
            }
            Cause::Outside => {
                "Several names together take up what none of them is, or one that is near does: a slow memory is a lag, a delay or perming, and what goes over at one temperature is a slope where \
                 the recording is short."
            }
            Cause::Decided => {
                "One of the two would need a size that the catalogue has as implausible (a drift of 500 nT a day), and by that it is decided, not by the readings. Where the \
                 other was concealed, the answer is wrong."
            }
            Cause::Several => {
                "Where one of them is not taken whole by the catalogue's form, something else takes up the rest, or all names fall together."
            }
            Cause::Form => {
                "What the catalogue's form leaves of the finer physics is taken up by further names, or keeps the right one from being told. At 0.3 times the noise a lag is told as none, for that \
                 says the same with less; of the mains the line is found but lies farther from 50 Hz than grids are taken to go."
            }
        }
    }
}
