//! What plain regressions predict of the readings that the names predict.

use common::number::significant;
use common::{PlainRegression, Residual};

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
