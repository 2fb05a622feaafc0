//! What plain regressions predict of the readings that the names predict, and what the names are worth then.

use common::number::significant;
use common::{PlainRegression, Residual, Verdict};

use crate::Outcome;
use crate::decide::PARTLY;

/// Judges names by the readings that were left out; whether they were taken back. Codes that the readings show by
/// themselves, which no reading is predicted by, stay.
pub fn judge(outcome: &mut Outcome, fit: &Residual) -> bool {
    if outcome.found.iter().any(|found| found.share == 0.0) {
        return false;
    }
    let verdict = judged(outcome.verdict, outcome.last.rest.is_beyond(), fit);
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

/// A reason for each regression.
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
}
