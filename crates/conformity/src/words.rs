use common::{Document, Error};
use page::number::{bare, counted, significant, uncertain};
use page::{Cell, Effect, Finding, Item, Section, Table};

use crate::verdict::{Missing, Rule, ShownValue, Side, Verdict};
use crate::{ID, Judged, Requirement, RequirementKind, Spec, judge};

const VERDICT: Effect = Effect::Unstated("a verdict on the result");

/// The statement of conformity: its first sentence counts the verdicts.
///
/// # Errors
///
/// Those of [`judge`].
pub fn section(document: &Document, spec: &Spec) -> Result<Section, Error> {
    let rule = Rule { factor: spec.guard_factor };
    let judged = judge(document, spec)?;
    let mut section = Section::new(ID, format!("Conformity: {}", spec.title));
    section.words = head(document, spec, &judged);
    let failed = judged.iter().filter(|one| one.verdict == Verdict::Fail);
    section.warnings = failed.map(|one| Finding::of(failure(one), VERDICT)).collect();
    let mut table = Table::new("Requirements", "requirement | limit | value ± u | margin | unit | verdict");
    for one in &judged {
        let (asked, found) = (one.requirement, decisive(one));
        let (unit, verdict) = (asked.kind.unit(), one.verdict.word());
        let margin = found.map(|found| rule.margin(asked.kind.side(), asked.limit, found));
        let value = found.map(value);
        table.row((titled(asked), limit(asked), value, Cell::figures(margin, 3), unit, verdict));
    }
    section.table(table);
    section.items.push(Item::Heading("Decision rule".into()));
    section.say(decision(rule));
    section.items.push(Item::Heading("How each was found".into()));
    for one in &judged {
        section.say(found_how(one));
    }
    let all = judged.iter().flat_map(|one| one.shown.iter().flatten().map(|found| (one.requirement, found)));
    let values =
        all.map(|(asked, found)| (&asked.title, &found.of, value(found), asked.kind.unit(), &found.how));
    section.rows("Every value", "requirement | of | value ± u | unit | what it is", values);
    Ok(section)
}

fn head(document: &Document, spec: &Spec, judged: &[Judged<'_>]) -> Vec<String> {
    let count = |verdict: Verdict| judged.iter().filter(|one| one.verdict == verdict).count();
    let source = spec.source.as_ref().map_or(String::new(), |source| format!(" ({source})"));
    let instrument = document.instrument.as_ref().and_then(|instrument| instrument.name.as_deref());
    vec![
        format!(
            "{}: {} pass, {} fail, {} not shown.",
            counted(judged.len(), "requirement"),
            count(Verdict::Pass),
            count(Verdict::Fail),
            count(Verdict::NotShown)
        ),
        format!("Specification: {}{source}.", spec.title),
        format!("Instrument: {}.", instrument.unwrap_or("the document gives it no name")),
        "No clock is in this statement: the same document and specification give the same bytes.".into(),
    ]
}

/// Title with its source.
fn titled(requirement: &Requirement) -> String {
    match &requirement.source {
        Some(source) => format!("{} ({source})", requirement.title),
        None => requirement.title.clone(),
    }
}

fn limit(requirement: &Requirement) -> String {
    let sign = match requirement.kind.side() {
        Side::Below => "≤",
        Side::Within => "±",
        Side::Above => "≥",
    };
    format!("{sign} {}", bare(requirement.limit))
}

fn decisive<'a>(one: &'a Judged<'_>) -> Option<&'a ShownValue> {
    one.shown.get(one.decisive?)?.as_ref().ok()
}

/// A value that may be larger than what was seen says so.
fn value(found: &ShownValue) -> Cell {
    if found.gaps.is_empty() {
        Cell::Uncertain { value: found.value, std: found.std }
    } else if found.std > 0.0 {
        Cell::Text(format!("at least {}", uncertain(found.value, found.std)))
    } else {
        Cell::Text(format!("at least {}", bare(found.value)))
    }
}

fn failure(one: &Judged<'_>) -> String {
    let requirement = one.requirement;
    let unit = requirement.kind.unit();
    let found = decisive(one).map_or(String::new(), |found| {
        format!(": {} {} {unit}", found.of, uncertain(found.value, found.std))
    });
    format!("{} fails{found}; the limit is {} {unit}.", titled(requirement), limit(requirement))
}

/// The decision rule with its numbers.
fn decision(rule: Rule) -> String {
    format!(
        "Guard band of k standard uncertainties u (JCGM 106:2012, 8.3; ILAC-G8:09/2019), k = {} where a value can miss its limit on one side, {} \
         where it can on both: either way a verdict of pass or fail is right with a probability of {} % or more where errors are normal and u is right, for each sensor by itself. \
         Pass: |value| + k u is within the limit. Fail: |value| − k u is beyond it. Not shown: neither, or the document lacks what is needed. \
         A limit that must be exceeded is read the other way round. The margin is what is left to the limit after k u. A value that is \
         \"at least\" so large can fail a limit from above, and pass one from below, and no more. Of several sensors or directions the worst decides; it is the one in the table.",
        significant(rule.factor(Side::Below), 4),
        significant(rule.factor(Side::Within), 4),
        significant(100.0 * rule.probability(), 3)
    )
}

/// What a value is, what it lacks and what is missing.
fn found_how(one: &Judged<'_>) -> String {
    let mut sentences = vec![format!("{}: {}.", titled(one.requirement), method(one.requirement))];
    let mut gaps: Vec<&str> = Vec::new();
    for gap in one.shown.iter().flatten().flat_map(|found| &found.gaps) {
        if !gaps.contains(&gap.as_str()) {
            gaps.push(gap);
        }
    }
    if !gaps.is_empty() {
        sentences.push(format!("Not covered: {}.", gaps.join("; ")));
    }
    let lacking: Vec<&Missing> = one.shown.iter().filter_map(|shown| shown.as_ref().err()).collect();
    let same = lacking.iter().all(|missing| missing.why == lacking[0].why);
    match lacking.as_slice() {
        [first, ..] if same && lacking.len() == one.shown.len() => {
            sentences.push(format!("Not shown: {}.", first.why))
        }
        some => sentences
            .extend(some.iter().map(|missing| format!("Not shown of {}: {}.", missing.of, missing.why))),
    }
    sentences.join(" ")
}

/// What a value is, in a sentence.
fn method(requirement: &Requirement) -> String {
    match requirement.kind {
        RequirementKind::OrthogonalityDeg => "90° less the angle between two sensors, u from the covariance of their directions".into(),
        RequirementKind::AxesArcsec => {
            "largest standard uncertainty of a direction over all ways that it may turn; u is that of a standard deviation with the fit's degrees of freedom".into()
        }
        RequirementKind::AxesFromNominalArcsec => "angle between a sensor and its nominal direction".into(),
        RequirementKind::AxesOverTemperatureArcsec => "turn between the reference temperature and the farther end of the range".into(),
        RequirementKind::RangeNt => "largest field that a sensor followed in its calibration, in either direction".into(),
        RequirementKind::ResolutionNt => "width of a code of the converter".into(),
        RequirementKind::BandwidthHz => "frequency up to which a sensor follows the field".into(),
        RequirementKind::NoiseZeroToPeakNt => {
            let [low, high] = requirement.band_hz.unwrap_or_default();
            format!(
                "expected largest departure from the mean in {} s, in either direction and between samples too, of Gaussian noise with the spectrum that was fitted, \
                 from {} to {} Hz",
                bare(requirement.over_s.unwrap_or_default()),
                bare(low),
                bare(high)
            )
        }
        RequirementKind::OffsetStabilityNt => {
            let warm = requirement.sensor_temperature_c.is_some() || requirement.electronics_temperature_c.is_some();
            let warm = warm.then_some("over the temperatures, from that at the reference");
            let years = requirement.years.map(|years| match years {
                1.0 => "in a year".to_string(),
                years => format!("in {} years", bare(years)),
            });
            let over: Vec<&str> = warm.into_iter().chain(years.as_deref()).collect();
            format!("largest change of the offset {}", over.join(", and "))
        }
        RequirementKind::AbsoluteAccuracyNt => format!(
            "error of a component in SEN of the field as it is corrected with this calibration, for fields in every direction up to {} nT; the value is what is known and \
             not corrected, u all the rest",
            bare(requirement.range_nt.unwrap_or_default())
        ),
    }
}
