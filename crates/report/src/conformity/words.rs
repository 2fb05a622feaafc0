use crate::page::number::{bare, uncertain};
use crate::page::template::{self, part};
use crate::page::{Cell, Effect, Finding, Section};
use common::{Document, Error};
use minijinja::{Value, context};
use std::collections::HashMap;

use crate::conformity::verdict::{Missing, Rule, ShownValue, Side, Verdict};
use crate::conformity::{Judged, Requirement, Spec, judge};

const VERDICT: Effect = Effect::Unstated("a verdict on the result");

/// The statement of conformity: its first sentence counts the verdicts.
///
/// # Errors
///
/// Those of [`judge`].
pub fn section(document: &Document, spec: &Spec) -> Result<Section, Error> {
    let rule = Rule { factor: spec.guard_factor };
    let judged = judge(document, spec)?;
    let count = |verdict: Verdict| {
        format!("{} {}", judged.iter().filter(|one| one.verdict == verdict).count(), verdict.word())
    };
    let context = context! {
        instrument => part(&document.instrument),
        spec => context! { title => spec.title, source => spec.source },
        verdicts => [Verdict::Pass, Verdict::Fail, Verdict::NotShown].map(count),
        judged => judged.iter().map(|one| of(one, rule)).collect::<Vec<Value>>(),
        rule => context! {
            one_side => rule.factor(Side::Below),
            both_sides => rule.factor(Side::Within),
            probability => rule.probability(),
        },
    };
    let sections = template::sections(
        template::environment(),
        include_str!("statement.jinja"),
        context,
        HashMap::new(),
    )?;
    let mut section = sections.into_iter().next().unwrap_or_default();
    section.complete();
    let failed = judged.iter().filter(|one| one.verdict == Verdict::Fail);
    section.warnings = failed.map(|one| Finding::of(failure(one), VERDICT)).collect();
    Ok(section)
}

/// A requirement with its verdict, its values, what they lack and what is missing.
fn of(one: &Judged<'_>, rule: Rule) -> Value {
    let (asked, decisive) = (one.requirement, decisive(one));
    let margin = decisive.map(|found| rule.margin(asked.kind.side(), asked.limit, found));
    let found = one.shown.iter().flatten();
    let mut gaps: Vec<&str> = Vec::new();
    for gap in found.clone().flat_map(|found| &found.gaps) {
        if !gaps.contains(&gap.as_str()) {
            gaps.push(gap);
        }
    }
    let found = found.map(|found| context! { of => found.of, value => value(found), how => found.how });
    let lacking: Vec<&Missing> = one.shown.iter().filter_map(|shown| shown.as_ref().err()).collect();
    let same = lacking.iter().all(|missing| missing.why == lacking[0].why);
    context! {
        asked => Value::from_serialize(asked),
        limit => limit(asked),
        value => decisive.map(value),
        margin,
        unit => asked.kind.unit(),
        verdict => one.verdict.word(),
        found => found.collect::<Vec<Value>>(),
        gaps,
        lacks_all => same && !lacking.is_empty() && lacking.len() == one.shown.len(),
        lacking,
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
fn value(found: &ShownValue) -> Value {
    let least = if found.std > 0.0 { uncertain(found.value, found.std) } else { bare(found.value) };
    Value::from_object(match found.gaps.is_empty() {
        true => Cell::Uncertain { value: found.value, std: found.std },
        false => Cell::Text(format!("at least {least}")),
    })
}

fn failure(one: &Judged<'_>) -> String {
    let (asked, unit) = (one.requirement, one.requirement.kind.unit());
    let found = decisive(one).map_or(String::new(), |found| {
        format!(": {} {} {unit}", found.of, uncertain(found.value, found.std))
    });
    let source = asked.source.as_ref().map_or(String::new(), |source| format!(" ({source})"));
    format!("{}{source} fails{found}; the limit is {} {unit}.", asked.title, limit(asked))
}
