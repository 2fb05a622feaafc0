//! What plain regressions predict of the readings that the names predict, and what the names are worth then.

use common::number::significant;
use common::{PlainRegression, Residual, Verdict};

use crate::Outcome;
use crate::decide::PARTLY;

/// Judges names by the readings that were left out. Names explain where they leave what noise leaves and predict as well
/// as a plain regression. Names that explain a part lower the mean square by that part of what the best regression takes
/// of it, or they are taken back; whether they were.
pub fn judge(outcome: &mut Outcome, fit: &Residual) -> bool {
    match outcome.verdict {
        Verdict::Explained if outcome.last.rest.is_beyond() || better(fit).is_some() => {
            outcome.verdict = Verdict::PartlyExplained;
        }
        _ => {}
    }
    let square = |nt: f64| nt * nt;
    let named = square(fit.held_out_before_nt) - square(fit.held_out_after_nt);
    let least = fit.plain.iter().map(|plain| plain.held_out_nt).fold(fit.held_out_after_nt, f64::min);
    let most = square(fit.held_out_before_nt) - square(least);
    let part = matches!(outcome.verdict, Verdict::PartlyExplained | Verdict::Ambiguous);
    let taken_back = part && !outcome.found.is_empty() && named < PARTLY * most;
    if taken_back {
        outcome.without_names("readings that were left out are not predicted that much better with it");
    }
    taken_back
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
