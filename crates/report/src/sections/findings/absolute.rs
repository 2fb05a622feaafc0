//! Findings of absolute.

use common::{AbsoluteSet, Code, Document};

use super::findings;
use crate::sections::absolute::{found, origin, unix_s};
use crate::{Effect, Finding};

/// The findings on all measurements, each where it is in time, and on the adopted baselines.
pub fn all(document: &Document) -> Vec<Finding> {
    let Some(found) = found(document) else { return Vec::new() };
    let origin = origin(document, found);
    let within = |finding: Finding, moments: [Option<f64>; 2]| match (&origin, moments) {
        (Some((recording, epoch_s)), [Some(from), Some(to)]) => {
            finding.within(recording, [from - epoch_s, to - epoch_s])
        }
        _ => finding,
    };
    let time = |recording: &str| {
        let set = found.sets.iter().find(|set| set.recording == recording);
        set.and_then(|set| unix_s(&set.time))
    };
    let of_sets = found.sets.iter().flat_map(|set| {
        let own = findings(&set.recording, &set.findings, set, measurement);
        own.into_iter().map(|finding| within(finding, [unix_s(&set.time); 2]))
    });
    // Of one component they are told in their order.
    let mut told: Vec<String> = Vec::new();
    let mut step = |name: &str| {
        let before = told.iter().filter(|other| **other == name).count();
        told.push(name.into());
        found.adopted.as_ref()?.components.get(name)?.steps.get(before)
    };
    let of_baselines = found.findings.coded().map(|(words, code, about)| match code {
        Some(Code::BaselineSteps) => {
            let Some(step) = step(about) else {
                return Finding::of(words, Effect::NOT_HELD);
            };
            let size = step.size.value();
            let effect =
                if about.ends_with("_deg") { Effect::arcsec(3600.0 * size) } else { Effect::nt(size) };
            within(Finding::of(words, effect), [time(&step.after), time(&step.before)])
        }
        Some(Code::Outliers) => {
            within(Finding::of(words, Effect::Unstated("left out of the result")), [time(about); 2])
        }
        code => Finding::of(words, code.map_or(Effect::NOT_HELD, |code| Effect::Unstated(code.effect()))),
    });
    of_sets.chain(of_baselines).collect()
}

/// What findings on a measurement do: a circle that is misread moves what is said of itself by its share in that.
fn measurement(set: &AbsoluteSet, code: Code, _: &str) -> Option<Effect> {
    if code != Code::Outliers {
        return Some(Effect::Unstated(code.effect()));
    }
    let most = set.readings.iter().max_by(|a, b| a.t.abs().total_cmp(&b.t.abs()))?;
    Some(Effect::arcsec(most.leave_one_out_arcsec - most.residual_arcsec))
}
