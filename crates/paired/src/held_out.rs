//! What is predicted of readings that were left out, in the document's terms.

use common::PlainRegression;
use common::number::duration;
use explain::{Cause, Explained, Form};

/// How late a form is, and which power of the column it has, in words.
pub fn lateness(form: &Form) -> String {
    let late =
        if form.late_s > 0.0 { format!(" with a lag of {}", duration(form.late_s)) } else { String::new() };
    let rows = match form.rows {
        0 => String::new(),
        1 => ", logged a row late".into(),
        -1 => ", logged a row early".into(),
        rows if rows > 0 => format!(", logged {rows} rows late"),
        rows => format!(", logged {} rows early", -rows),
    };
    let power = form.power.map_or(String::new(), |power| format!(" to the power {power:.2}"));
    format!("{power}{late}{rows}")
}

/// The plain regressions beside an explanation; `name` has the name of a cause.
pub fn regressions(explained: &Explained, name: &dyn Fn(Cause) -> String) -> Vec<PlainRegression> {
    let term = |number: &usize| {
        let (cause, form) = explained.offered[*number];
        let bent = if form.bent { ", squared" } else { "" };
        format!("{}{}{bent}", name(cause), lateness(&form))
    };
    let of = |plain: &explain::Plain| PlainRegression {
        name: plain.name.into(),
        held_out_nt: estimate::stats::rms(&plain.rms),
        terms: plain.terms.iter().map(term).collect(),
    };
    explained.held_out.rivals.iter().map(of).collect()
}

/// The name of a cause among the covariates of such names.
pub fn named(cause: Cause, covariates: &[String]) -> String {
    match cause {
        Cause::Covariate(number) => covariates[number].clone(),
        Cause::Time => "time".into(),
        Cause::Clock => "clock".into(),
        Cause::Course(_) => "what was not recorded".into(),
    }
}
