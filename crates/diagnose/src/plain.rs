//! What names are worth: shapes that no instrument and nothing near one has, and what plain regressions predict of the
//! readings that the names predict.

use common::number::significant;
use common::{PlainRegression, Residual, Verdict};

use crate::Outcome;
use crate::decide::PARTLY;
use crate::model::Model;

/// Judges names by the readings that were left out; whether they were taken back. Codes that the readings show by
/// themselves, which no reading is predicted by, stay.
pub fn judge(outcome: &mut Outcome, fit: &Residual) -> bool {
    if outcome.found.iter().any(|found| found.share == 0.0) {
        return false;
    }
    let verdict = judged(outcome.verdict, outcome.now.look.rest.is_beyond(), fit);
    let taken_back = verdict == Verdict::Unexplained && !outcome.found.is_empty();
    outcome.verdict = verdict;
    if taken_back {
        outcome.without_names("readings that were left out are not predicted that much better with it");
    }
    taken_back
}

/// Names explain where they leave what noise leaves and predict as well as a plain regression. Names that explain a
/// part lower the mean square by that part of what the best regression takes of it.
fn judged(verdict: Verdict, beyond: bool, fit: &Residual) -> Verdict {
    let verdict = match verdict {
        Verdict::Explained if beyond || better(fit).is_some() => Verdict::PartlyExplained,
        verdict => verdict,
    };
    let square = |nt: f64| nt * nt;
    let lowered = |nt: f64| square(fit.held_out_before_nt) - square(nt);
    let least = fit.plain.iter().map(|plain| plain.held_out_nt).fold(fit.held_out_after_nt, f64::min);
    let part = matches!(verdict, Verdict::PartlyExplained | Verdict::Ambiguous);
    if part && lowered(fit.held_out_after_nt) < PARTLY * lowered(least) {
        Verdict::Unexplained
    } else {
        verdict
    }
}

/// The regression that predicts held-out readings better than the names, where one does.
pub fn better(fit: &Residual) -> Option<&PlainRegression> {
    PlainRegression::better(&fit.plain, fit.held_out_after_nt)
}

/// The same as the end of a sentence; empty where the names predict as well.
pub fn in_words(fit: &Residual) -> String {
    better(fit).map_or(String::new(), |plain| format!("; {}", plain.predicts_better(fit.held_out_after_nt)))
}

pub fn reasons(fit: &Residual) -> Vec<String> {
    let of = |plain: &PlainRegression| {
        let note = if better(fit) == Some(plain) { "note: " } else { "" };
        format!(
            "{note}{} with {} leaves {} nT of held-out readings, the names {} nT",
            plain.name,
            plain.in_words(),
            significant(plain.held_out_nt, 4),
            significant(fit.held_out_after_nt, 4)
        )
    };
    fit.plain.iter().map(of).collect()
}

/// A shape may be this factor beyond its plausible range, and by so many standard uncertainties.
const BEYOND: f64 = 2.0;
const SURELY: f64 = 2.0;

/// Takes back the names where one has a shape that is surely not plausible: it is something else.
pub fn judge_shapes(model: &Model<'_>, outcome: &mut Outcome) {
    let fit = &outcome.now.fit;
    let base = model.unknowns.len();
    let why = model.free(&fit.state).into_iter().enumerate().find_map(|(place, (effect, parameter))| {
        let effect = &fit.state.effects[effect];
        let (info, value) = (&effect.kind.parameters()[parameter], effect.parameters[parameter]);
        // Of its logarithm.
        let std = fit.covariance[(base + place, base + place)].sqrt();
        let beyond = is_beyond(value, std, [info.low, info.high]);
        (info.is_shape_at(value) && beyond).then(|| {
            let (name, kind, value) = (info.name, effect.kind.name(), significant(value, 3));
            format!("{kind} would need {name} = {value}; plausible values are {} to {}", info.low, info.high)
        })
    });
    if let Some(why) = why.filter(|_| !outcome.found.is_empty()) {
        outcome.without_names(&why);
    }
}

/// Whether a shape is surely outside its plausible range, by the standard uncertainty of its logarithm.
fn is_beyond(value: f64, std: f64, [low, high]: [f64; 2]) -> bool {
    let surely = |factor: f64| factor.ln() - SURELY * std > BEYOND.ln();
    surely(value / high) || surely(low / value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_worth_what_they_predict() {
        let fit = |after: f64, plain: f64| Residual {
            held_out_before_nt: 10.0,
            held_out_after_nt: after,
            plain: vec![PlainRegression { held_out_nt: plain, ..PlainRegression::default() }],
            ..Residual::default()
        };
        let explained = |after, plain, beyond| judged(Verdict::Explained, beyond, &fit(after, plain));
        assert_eq!(explained(1.0, 1.0, false), Verdict::Explained);
        // Something is left beside the noise, or for a plain regression.
        assert_eq!(explained(1.0, 1.0, true), Verdict::PartlyExplained);
        assert_eq!(explained(2.0, 1.0, false), Verdict::PartlyExplained);
        // Three tenths of 100 − 1 nT² are 29.7.
        let partly = |after| judged(Verdict::PartlyExplained, true, &fit(after, 1.0));
        assert_eq!([8.3, 8.5].map(partly), [Verdict::PartlyExplained, Verdict::Unexplained]);
        assert_eq!(judged(Verdict::Agrees, false, &fit(10.0, 1.0)), Verdict::Agrees);
    }

    #[test]
    fn a_shape_is_implausible_where_it_surely_is() {
        let range = [1.0, 1000.0];
        let cases = [
            (4870.0, 0.12, true),
            (4870.0, 0.6, false),
            (1900.0, 0.01, false),
            (0.4, 0.1, true),
            (30.0, 0.1, false),
        ];
        for (value, std, beyond) in cases {
            assert_eq!(is_beyond(value, std, range), beyond, "{value} ± {std}");
        }
        // What is not determined is not implausible.
        assert!(!is_beyond(1e4, f64::INFINITY, range));
    }
}
