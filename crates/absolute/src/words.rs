//! The result in a few lines for people.

use common::number::{counted, significant};
use common::{Document, Quantity};

const LISTED: usize = 12;

/// The field and the baseline of every measurement, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let calibration = document.calibration.as_ref().and_then(|calibration| calibration.absolute.as_ref());
    let Some(found) = calibration else { return String::new() };
    let count = found.sets.len();
    let (measured, arcsec) = (counted(count, "measurement"), significant(found.circle_arcsec, 2));
    let mut lines = vec![format!("absolute: {measured}; standard uncertainty of a circle reading {arcsec}″")];
    for set in found.sets.iter().take(LISTED) {
        let told = |(key, value): (&String, &Quantity)| {
            let (name, unit) = named(key);
            format!("{name} {value}{unit}")
        };
        let baseline: Vec<String> = set.baseline.iter().map(told).collect();
        let magnitude = set.f_nt.as_ref().map_or_else(String::new, |f| format!(", F {f} nT"));
        let (d, i) = (&set.declination_deg, &set.inclination_deg);
        lines.push(format!("  {} D {d}°, I {i}°{magnitude}", set.time));
        if !baseline.is_empty() {
            lines.push(format!("    baseline {}", baseline.join(", ")));
        }
    }
    if count > LISTED {
        lines.push(format!("  … and {} more", count - LISTED));
    }
    // Of one or two measurements there is no trend to tell.
    let adopted = found.adopted.iter().filter(|_| count > 2);
    for (key, one) in adopted.flat_map(|adopted| &adopted.components) {
        let share = one.probabilities.get(&one.trend).copied().unwrap_or_default();
        let (name, unit) = named(key);
        let (trend, share, rms) = (&one.trend, significant(share, 2), significant(one.left_out_rms, 2));
        let mut words = format!(
            "  adopted {name}: {trend} (probability {share}), leave-one-out residuals {rms}{unit} rms"
        );
        for follows in &one.follows {
            words += &format!(", follows {} by {}{unit} per unit", follows.column, follows.coefficient);
        }
        lines.push(words);
    }
    for set in &found.sets {
        lines.extend(set.findings.iter().map(|finding| format!("  \"{}\": {finding}", set.recording)));
    }
    lines.extend(found.findings.iter().map(|finding| format!("  {finding}")));
    lines.join("\n")
}

/// A baseline value and its unit as observers write them, by its key in the document.
pub fn named(key: &str) -> (String, &'static str) {
    let (letter, unit) = key.split_once('_').unwrap_or((key, ""));
    (format!("{}0", letter.to_uppercase()), if unit == "deg" { "°" } else { " nT" })
}
