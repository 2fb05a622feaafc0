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
        "{}; standard uncertainty of a circle reading {}″",
        counted(count, "measurement"),
        significant(found.circle_arcsec, 2)
    )];
    for set in found.sets.iter().take(LISTED) {
        let baseline: Vec<String> = set
            .baseline
            .iter()
            .map(|(key, value)| match key.split_once('_') {
                Some((name, "deg")) => format!("{}0 {value}°", name.to_uppercase()),
                Some((name, _)) => format!("{}0 {value} nT", name.to_uppercase()),
                None => format!("{key} {value}"),
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
    for set in &found.sets {
        lines.extend(set.findings.iter().map(|finding| format!("  \"{}\": {finding}", set.recording)));
    }
    lines.extend(found.findings.iter().map(|finding| format!("  {finding}")));
    lines.join("\n")
}
