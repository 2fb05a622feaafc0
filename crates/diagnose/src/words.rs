//! The result in a few lines for people.

use common::number::{p_value, probability, signed, significant};
use common::{Diagnosis, Document, ExplainedEffect, ListedEffect, Quantity};
use std::fmt::Write;

/// Most parameters of an effect, or parts of a list, that are said.
const PARAMETERS: usize = 12;

/// What was found, with ± and units.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    for entry in document.diagnosis.iter().flatten() {
        one(&mut text, entry);
    }
    text
}

/// How sure a name is and how much it explains.
fn weight(effect: &ExplainedEffect) -> String {
    let sure = effect.probability.map(|own| format!("probability {}", probability(own)));
    let share =
        effect.share.map(|share| format!("{} % of what can be explained", significant(100.0 * share, 2)));
    [sure, share, Some(p_value(effect.p_adjusted))].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The parameters of an effect; of a list, those of each part.
fn parameters(effect: &ExplainedEffect) -> String {
    let told = |(name, value): (&String, &Quantity)| format!("{name} = {value}");
    let parts: Vec<String> = if effect.list.is_empty() {
        effect.parameters.iter().map(told).collect()
    } else {
        let of = |part: &ListedEffect| part.parameters.iter().map(told).collect::<Vec<_>>().join(" at ");
        effect.list.iter().map(of).collect()
    };
    let more = parts.len().saturating_sub(PARAMETERS);
    let more = if more > 0 { format!(" and {more} more in the document") } else { String::new() };
    format!("{}{more}", parts[..parts.len().min(PARAMETERS)].join(", "))
}

fn one(text: &mut String, entry: &Diagnosis) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "diagnose: {}", entry.verdict.word().replace('_', " "));
    if let Some(fit) = &entry.fit {
        let _ = writeln!(
            text,
            "  rms {} nT as it came, {} with the calibration fitted again, {} with what was found; left out {}, noise {} ({})",
            significant(fit.rms_before_nt, 4),
            significant(fit.rms_refitted_nt, 4),
            significant(fit.rms_after_nt, 4),
            significant(fit.held_out_after_nt, 4),
            significant(fit.noise_floor_nt, 4),
            fit.noise_source
        );
    }
    for effect in &entry.effects {
        let target = effect.sensor.map(|axis| format!(" of sensor {axis}"));
        let target =
            target.or_else(|| effect.coil.map(|axis| format!(" of coil {axis}"))).unwrap_or_default();
        let times = match effect.list.len() {
            0 => String::new(),
            count => format!(", {count} times"),
        };
        let _ = writeln!(text, "  {}{target}: {}{times} ({})", effect.effect, effect.title, weight(effect));
        let _ = writeln!(text, "    {}", parameters(effect));
        for rival in &effect.rivals {
            let _ = writeln!(text, "    not {}: {}", rival.effect, rival.why_not);
        }
    }
    for moved in &entry.calibration_moved {
        let or = moved.alternatives.iter().map(|other| format!(" or {other}")).collect::<String>();
        let _ = writeln!(
            text,
            "  the calibration as stated no longer holds: {}{or} moved by {}, {} times its stated uncertainty ({})",
            moved.parameter,
            moved.shift,
            significant(moved.shift.value().abs() / moved.stated_std, 2),
            p_value(moved.p_adjusted)
        );
    }
    if !entry.ambiguity.is_empty() {
        let sets: Vec<String> = entry.ambiguity.iter().map(|set| set.join(" with ")).collect();
        let _ = writeln!(text, "  cannot be told apart here: {}", sets.join("; "));
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
        let lag = structure.lag_s.map(|lag| format!(", {} s back", significant(lag, 2))).unwrap_or_default();
        let _ = writeln!(
            text,
            "  without a name: {sensor}follows {}{parity}{lag} ({} % of what can be explained)",
            structure.follows,
            significant(100.0 * structure.share, 2)
        );
    }
    if let Some(remaining) = entry.remaining.as_ref().filter(|remaining| !remaining.white) {
        let _ = writeln!(text, "  left: {}", remaining.structure);
    }
    let told = |reason: &&String| reason.starts_with("not ") || reason.starts_with("left aside: ");
    for reason in entry.reasons.iter().filter(told) {
        let _ = writeln!(text, "  {reason}");
    }
    if let Some(next) = &entry.next_experiment {
        let _ = writeln!(text, "  next: {next}");
    }
}
