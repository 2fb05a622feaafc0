//! The answer in one sentence: what, where, how large, from what rms to what rms.

use common::number::{duration, significant, uncertain};
use common::{Diagnosis, ExplainedEffect, Quantity, Verdict};
use explain::Form;

/// Most effects that the sentence names.
const HEAD: usize = 3;

/// How late a form is.
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
    format!("{late}{rows}")
}

/// The answer.
pub fn answer(diagnosis: &Diagnosis, what: &str) -> String {
    let Some(fit) = &diagnosis.fit else { return String::new() };
    let rms = |nt: f64| significant(nt, 3);
    let falls = format!("the rms falls from {} to {} nT", rms(fit.rms_refitted_nt), rms(fit.rms_after_nt));
    let with = if diagnosis.effects.len() > 1 { "with these" } else { "with this" };
    match diagnosis.verdict {
        Verdict::Agrees => format!(
            "nothing recorded explains what {what} reads beside its fit; {} nT rms are noise",
            rms(fit.rms_after_nt)
        ),
        Verdict::Ambiguous => {
            let sets: Vec<String> = diagnosis.ambiguity.iter().map(|set| set.join(" with ")).collect();
            format!("{} explain it equally well: {}; {with}, {falls}", what, sets.join(" or "))
        }
        _ => {
            let named: Vec<String> = diagnosis.effects.iter().take(HEAD).map(sized).collect();
            let more = diagnosis.effects.len().saturating_sub(HEAD);
            let more = if more > 0 { format!(", and {more} more in the document") } else { String::new() };
            let held = match diagnosis.verdict {
                Verdict::PartlyExplained => {
                    let best = fit.plain.iter().min_by(|a, b| a.held_out_nt.total_cmp(&b.held_out_nt));
                    best.map_or(String::new(), |plain| {
                        format!(
                            "; {} ({}) predicts held-out readings better: {} nT, not {}",
                            plain.name,
                            plain.terms.join(", "),
                            rms(plain.held_out_nt),
                            rms(fit.held_out_after_nt)
                        )
                    })
                }
                _ => String::new(),
            };
            format!("{}{more}; {with}, {falls}{held}", named.join(", and "))
        }
    }
}

/// An effect with its size.
fn sized(effect: &ExplainedEffect) -> String {
    if effect.list.len() > 1 {
        return format!("{} {} times", effect.title, effect.list.len());
    }
    let told = |(name, value): (&String, &Quantity)| match value.std() {
        Some(std) => format!("{} {}", short(name), uncertain(value.value(), std)),
        None => format!("{} {}", short(name), significant(value.value(), 6)),
    };
    let parts: Vec<String> = effect.parameters.iter().take(4).map(told).collect();
    let unit = effect.parameters.keys().next().map_or(String::new(), |name| words(name));
    format!("{} ({}{unit})", effect.title, parts.join(", "))
}

/// What a parameter is of, without its unit.
fn short(name: &str) -> &str {
    let (first, _) = name.split_once('_').unwrap_or((name, ""));
    match first {
        "x" | "y" | "z" => first,
        "along" => "along the field",
        _ => name,
    }
}

/// The unit of a coefficient of an axis: "x_nt_per_am2" is in nT/(A m²).
fn words(name: &str) -> String {
    let Some((_, unit)) = name.split_once("nt_per_") else {
        return if name.ends_with("_nt") { " nT".into() } else { String::new() };
    };
    let unit = match unit {
        "a" => "A",
        "am2" => "(A m²)",
        "k" => "K",
        "v" => "V",
        "w" => "W",
        "hz" => "Hz",
        "percent" => "%",
        "ohm" => "Ω",
        "pa" => "Pa",
        "arcsec" => "″",
        other => other,
    };
    format!(" nT/{unit}")
}
