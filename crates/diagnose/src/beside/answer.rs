//! The answer in one sentence: what, where, how large, from what rms to what rms.

use common::number::{significant, uncertain};
use common::{Diagnosis, ExplainedEffect, Quantity, Verdict};

use crate::{plain, words};

/// Most effects that the sentence names.
const HEAD: usize = 3;

pub fn answer(diagnosis: &Diagnosis, what: &str) -> String {
    let Some(fit) = &diagnosis.fit else { return String::new() };
    let rms = |nt: f64| significant(nt, 3);
    let falls = format!("the rms falls from {} to {} nT", rms(fit.rms_refitted_nt), rms(fit.rms_after_nt));
    let with = if diagnosis.effects.len() > 1 { "with these" } else { "with this" };
    let said = match diagnosis.verdict {
        Verdict::Agrees => format!(
            "nothing recorded explains what {what} reads beside its fit; {} nT rms are noise",
            rms(fit.rms_after_nt)
        ),
        Verdict::Unexplained => format!(
            "nothing recorded explains what {what} reads beside its fit: {} nT rms, where {} nT of noise are declared",
            rms(fit.rms_after_nt),
            rms(fit.noise_floor_nt)
        ),
        Verdict::Ambiguous => {
            let sets = words::sets(diagnosis).join(" or ");
            format!("what {what} reads has several explanations: {sets}; {with}, {falls}")
        }
        _ => {
            let named: Vec<String> = diagnosis.effects.iter().take(HEAD).map(sized).collect();
            let more = diagnosis.effects.len().saturating_sub(HEAD);
            let more = if more > 0 { format!(", and {more} more in the document") } else { String::new() };
            format!("{}{more}; {with}, {falls}", named.join(", and "))
        }
    };
    said + &plain::in_words(fit)
}

/// An effect with its size: the axes in the unit of the first, the rest by name.
fn sized(effect: &ExplainedEffect) -> String {
    if effect.list.len() > 1 {
        return format!("{} {} times", effect.title, effect.list.len());
    }
    let size = |value: &Quantity| match value.std() {
        Some(std) => uncertain(value.value(), std),
        None => significant(value.value(), 6),
    };
    let axis = |name: &str| match name.split_once('_') {
        Some((axis @ ("x" | "y" | "z"), _)) => Some(axis.to_string()),
        Some(("along", _)) => Some("along the field".into()),
        _ => None,
    };
    let straight = |(name, _): &(&String, &Quantity)| axis(name).is_some() && !name.ends_with("_2");
    let axes: Vec<(&String, &Quantity)> = effect.parameters.iter().filter(straight).collect();
    let unit = axes.first().map_or(String::new(), |(name, _)| {
        let (_, unit) = name.split_once("nt_per_").unwrap_or(("", ""));
        match (&effect.column, unit) {
            (Some(column), _) => format!(" nT/{}", common::unit::in_words(column)),
            (None, "") => " nT".into(),
            (None, unit) => format!(" nT/{unit}"),
        }
    });
    let of_axis =
        |(name, value): &(&String, &Quantity)| format!("{} {}", axis(name).unwrap_or_default(), size(value));
    let of_axes: Vec<String> = axes.iter().map(of_axis).collect();
    let others = effect.parameters.iter().filter(|(name, _)| axis(name).is_none()).map(|(name, value)| {
        match name.strip_suffix("_s") {
            Some("time") => format!("at {} s", size(value)),
            Some(name) => format!("{name} {} s", size(value)),
            None => format!("{} {}", name.replace('_', " "), size(value)),
        }
    });
    let of_axes = (!of_axes.is_empty()).then(|| format!("{}{unit}", of_axes.join(", ")));
    let parts: Vec<String> = of_axes.into_iter().chain(others).collect();
    format!("{} ({})", effect.title, parts.join("; "))
}
