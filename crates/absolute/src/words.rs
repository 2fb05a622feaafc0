//! The result in a few lines for people.

use common::Document;
use common::number::{counted, significant};

/// Most measurements that are listed.
const LISTED: usize = 12;

/// The field and the baseline of every measurement, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let calibration = document.calibration.as_ref().and_then(|calibration| calibration.absolute.as_ref());
    let Some(found) = calibration else { return String::new() };
    let count = found.sets.len();
    let mut lines = vec![format!(
        "absolute: {}; standard uncertainty of a circle reading {}″",
        counted(count, "measurement"),
        significant(found.circle_arcsec, 2)
    )];
    for set in found.sets.iter().take(LISTED) {
        let baseline: Vec<String> = set
            .baseline
            .iter()
            .map(|(key, value)| {
                let (name, unit) = named(key);
                format!("{name} {value}{unit}")
            })
            .collect();
        let magnitude = set.f_nt.as_ref().map_or_else(String::new, |f| format!(", F {f} nT"));
        lines.push(format!(
            "  {} D {}°, I {}°{magnitude}",
            set.time, set.declination_deg, set.inclination_deg
        ));
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
        let mut words = format!(
            "  adopted {name}: {} (probability {}), leave-one-out residuals {}{unit} rms",
            one.trend,
            significant(share, 2),
            significant(one.left_out_rms, 2)
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
