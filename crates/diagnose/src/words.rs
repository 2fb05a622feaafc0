//! The result in a few lines for people.

use common::number::{p_value, probability, signed, significant};
use common::{
    Axis, Diagnosis, Document, ExplainedEffect, ExplainedFamily, FamilyMember, ListedEffect, MovedConstant,
    Quantity, Verdict,
};
use indexmap::IndexMap;
use std::fmt::Write;

use crate::decide::{AS_MUCH, SURE};
use crate::families::LEAST;
use crate::plain;

/// Most parameters of an effect, or parts of a list, that are said.
const PARAMETERS: usize = 12;
/// Most reasons and rejected names that are said; the others are in the document.
const REASONS: usize = 3;
/// The same in the first line.
const HEAD: usize = 3;

/// What was found, with ± and units.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    for entry in document.diagnosis.iter().flatten() {
        one(&mut text, entry);
    }
    text
}

/// The constants that moved, those of one cause together.
fn moved(constants: &[MovedConstant]) -> String {
    let mut told: IndexMap<Option<&str>, Vec<String>> = IndexMap::new();
    for one in constants {
        let words = format!("{} changed by {}", one.parameter, one.shift);
        told.entry(one.cause.as_deref()).or_default().push(words);
    }
    let told = told.into_iter().map(|(cause, constants)| match cause {
        Some(cause) => format!("{cause} ({})", constants.join(", ")),
        None => constants.join(", "),
    });
    told.collect::<Vec<_>>().join(", ")
}

/// The answer in one sentence, with its size and what it does to the residuals.
pub fn answer(entry: &Diagnosis) -> String {
    let rms = |nt: f64| significant(nt, 3);
    let Some(fit) = &entry.fit else { return String::new() };
    if fit.is_absurd() {
        return format!(
            "the fit increases the residual to {} nT rms, from {}: it failed, and its results are invalid",
            rms(fit.rms_refitted_nt.max(fit.rms_after_nt)),
            rms(fit.rms_before_nt)
        );
    }
    let refitted = format!(
        "{} nT rms with the stated calibration, {} after refitting it",
        rms(fit.rms_before_nt),
        rms(fit.rms_refitted_nt)
    );
    let falls = format!("the rms falls from {} to {} nT", rms(fit.rms_refitted_nt), rms(fit.rms_after_nt));
    let noise = format!("noise {} nT", rms(fit.noise_floor_nt));
    let with = if entry.effects.len() > 1 { "with these" } else { "with this" };
    let said = match entry.verdict {
        Verdict::Agrees => {
            format!("the model agrees with the recordings to their noise: {refitted}, {noise}")
        }
        Verdict::Explained if entry.effects.is_empty() => {
            format!("{}: {refitted}, {noise}", moved(&entry.calibration_moved))
        }
        Verdict::Explained => format!("{}; {with}, {falls} ({noise})", names(entry)),
        Verdict::PartlyExplained => {
            format!("{}; {with}, {falls}, still above the {noise}", names(entry))
        }
        Verdict::Ambiguous => {
            let sets = sets(entry).join(" or ");
            format!("{sets}: indistinguishable in these recordings; with either, {falls} ({noise})")
        }
        Verdict::Unexplained => match entry.families.first() {
            Some(first) if first.probability >= SURE && first.share >= AS_MUCH => {
                format!("{}; {refitted}, {noise}", family(first))
            }
            _ => {
                let left = entry.remaining.as_ref().map_or("unidentified structure", |left| &left.structure);
                format!("{refitted}, {noise}; no effect explains the residual: {left}")
            }
        },
    };
    said + &adopted(entry) + &plain::in_words(fit)
}

/// The effects in the catalogue's words, with the sizes of the first, the one that does most.
fn names(entry: &Diagnosis) -> String {
    let [first, others @ ..] = entry.effects.as_slice() else { return "no effect of the catalogue".into() };
    let titled = |effect: &ExplainedEffect| match acts_on(effect) {
        Some(target) => format!("{}: {}", target, effect.title),
        None => effect.title.clone(),
    };
    let others: Vec<String> = others.iter().map(titled).collect();
    let others = if others.is_empty() { String::new() } else { format!(", and {}", others.join(", ")) };
    format!("{} ({}){others}", titled(first), parameters(first, HEAD))
}

fn adopted(entry: &Diagnosis) -> String {
    let (Some(first), Some(last)) = (entry.empirical.first(), entry.empirical.last()) else {
        return String::new();
    };
    let columns: Vec<&str> = entry.empirical.iter().map(|one| one.column.as_str()).collect();
    format!(
        "; adopted without a name: functions of {}, with which the rms of held-out readings falls from {} to {} nT",
        columns.join(", "),
        significant(first.held_out_before_nt, 3),
        significant(last.held_out_after_nt, 3)
    )
}

/// The sets of names that cannot be told apart, each in words.
pub fn sets(entry: &Diagnosis) -> Vec<String> {
    entry.ambiguity.iter().map(|set| set.join(" with ")).collect()
}

/// A kind of physics whose member is not determined, with those that may be it.
fn family(family: &ExplainedFamily) -> String {
    let sensors: Vec<String> = family.sensors.iter().map(Axis::to_string).collect();
    let sensors = match sensors.as_slice() {
        [] => String::new(),
        [one] => format!("sensor {one}: "),
        [others @ .., last] => format!("sensors {} and {last}: ", others.join(", ")),
    };
    let member = |member: &FamilyMember| format!("{} {}", member.effect, probability(member.probability));
    let mut members: Vec<String> = family.members.iter().take(HEAD).map(member).collect();
    if family.no_member >= LEAST {
        members.push(format!("another form {}", probability(family.no_member)));
    }
    let why = if family.members.first().is_some_and(|member| member.probability >= SURE) {
        "none of whose members explains enough to be named"
    } else {
        "of which no member is certain"
    };
    format!(
        "{sensors}{} (probability {}), {why} ({})",
        family.title,
        probability(family.probability),
        members.join(", ")
    )
}

/// The sensor or the coil of an effect that acts on one.
fn acts_on(effect: &ExplainedEffect) -> Option<String> {
    let sensor = effect.sensor.map(|axis| format!("sensor {axis}"));
    sensor.or_else(|| effect.coil.map(|axis| format!("coil {axis}")))
}

/// The name of an effect with what it acts on.
fn named(effect: &ExplainedEffect) -> String {
    let target = acts_on(effect).map_or_else(String::new, |target| format!(" of {target}"));
    format!("{}{target}", effect.effect)
}

/// How sure a name is and how much it explains.
fn weight(effect: &ExplainedEffect) -> String {
    let sure = effect.probability.map(|own| format!("probability {}", probability(own)));
    let share =
        effect.share.map(|share| format!("{} % of the explicable variance", significant(100.0 * share, 2)));
    [sure, share, Some(p_value(effect.p_adjusted))].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The parameters of an effect; of a list, those of each part.
fn parameters(effect: &ExplainedEffect, most: usize) -> String {
    let told = |(name, value): (&String, &Quantity)| format!("{name} = {value}");
    let parts: Vec<String> = if effect.list.is_empty() {
        effect.parameters.iter().map(told).collect()
    } else {
        let of = |part: &ListedEffect| part.parameters.iter().map(told).collect::<Vec<_>>().join(" at ");
        effect.list.iter().map(of).collect()
    };
    let more = parts.len().saturating_sub(most);
    let more = if more > 0 { format!(" and {more} more in the document") } else { String::new() };
    format!("{}{more}", parts[..parts.len().min(most)].join(", "))
}

fn one(text: &mut String, entry: &Diagnosis) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "diagnose: {}: {}", entry.verdict.word().replace('_', " "), entry.answer);
    if let Some(fit) = &entry.fit {
        let _ = writeln!(
            text,
            "  rms {} nT with the stated calibration, {} after refitting it, {} with the effects found; held out {}, noise {} ({})",
            significant(fit.rms_before_nt, 4),
            significant(fit.rms_refitted_nt, 4),
            significant(fit.rms_after_nt, 4),
            significant(fit.held_out_after_nt, 4),
            significant(fit.noise_floor_nt, 4),
            fit.noise_source
        );
    }
    for effect in &entry.effects {
        let times = match effect.list.len() {
            0 => String::new(),
            count => format!(", {count} times"),
        };
        let gain = match effect.held_out_gain_nt {
            0.0 => String::new(),
            gain => format!("; reduces the rms of held-out readings by {} nT", significant(gain, 3)),
        };
        let _ = writeln!(text, "  {}: {}{times}{gain} ({})", named(effect), effect.title, weight(effect));
        let _ = writeln!(text, "    {}", parameters(effect, PARAMETERS));
        for rival in effect.rivals.iter().take(REASONS) {
            let _ = writeln!(text, "    rejected {}: {}", rival.effect, rival.why_not);
        }
    }
    for moved in &entry.calibration_moved {
        let or = moved.alternatives.iter().map(|other| format!(" or {other}")).collect::<String>();
        let _ = writeln!(
            text,
            "  the stated calibration no longer holds: {}{or} changed by {}, {} times its stated uncertainty ({})",
            moved.parameter,
            moved.shift,
            significant(moved.shift.value().abs() / moved.stated_std, 2),
            p_value(moved.p_adjusted)
        );
    }
    if !entry.ambiguity.is_empty() {
        let _ = writeln!(text, "  indistinguishable: {}", sets(entry).join("; "));
    }
    for share in entry.places.iter().flat_map(|share| &share.readings) {
        let _ = writeln!(
            text,
            "  reading {} of {} in \"{}\" is off by {} nT",
            share.row,
            share.column,
            share.recording,
            signed(&significant(share.departure_nt.value(), 4))
        );
    }
    for structure in &entry.unnamed {
        let sensor = structure.sensor.map_or_else(String::new, |axis| format!("{axis} "));
        let parity = structure.parity.iter().map(|parity| format!(", {parity}")).collect::<String>();
        let lag =
            structure.lag_s.map(|lag| format!(", lagged {} s", significant(lag, 2))).unwrap_or_default();
        let _ = writeln!(
            text,
            "  unidentified: {sensor}follows {}{parity}{lag} ({} % of the explicable variance)",
            structure.follows,
            significant(100.0 * structure.share, 2)
        );
    }
    if let Some(remaining) = entry.remaining.as_ref().filter(|remaining| !remaining.white) {
        let _ = writeln!(text, "  residual: {}", remaining.structure);
    }
    let told = |reason: &&String| reason.starts_with("rejected ") || reason.starts_with("note: ");
    for reason in entry.reasons.iter().filter(told).take(REASONS) {
        let _ = writeln!(text, "  {reason}");
    }
    if let Some(next) = &entry.next_experiment {
        let _ = writeln!(text, "  next: {next}");
    }
}
