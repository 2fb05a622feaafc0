//! What is said of the clocks.

use common::number::{bare, duration, p_value, signed, significant, uncertain};
use common::{ClockDifference, ClockJump, Code, DelayForm, Finding, JumpVerdict, Quantity};

use crate::{TOLD_BELOW, p_of};

/// Jumps of the times, and what parts and bands say of the offset.
pub fn findings(clock: &ClockDifference) -> Vec<Finding> {
    let jumps = clock.jumps.iter().map(|jump| Code::TimesJump.said(said(jump)));
    let mut findings: Vec<Finding> = jumps.collect();
    let whose = |of: &Quantity| if of.value() < 0.0 { "reference" } else { "test instrument" };
    let size = |of: &Quantity| uncertain(of.value().abs(), of.std().unwrap_or(0.0));
    if let Some(parts) = clock.parts.as_ref().filter(|parts| parts.p < TOLD_BELOW) {
        findings.push(Code::ClockNotConstant.said(format!(
            "the clock offset is not constant over the recording: {} parts scatter by {} s, {} times their uncertainties ({}); this scatter is taken as its uncertainty",
            parts.count,
            significant(parts.between_s, 2),
            significant(parts.birge_ratio, 2),
            p_value(parts.p)
        )));
    }
    if let Some(length) = clock.bands.as_ref().and_then(|bands| bands.average_s.as_ref()) {
        findings.push(Code::AveragedReadings.said(format!(
            "the response against period is that of readings of the {} averaged over {} s, unlike the other's; half of that is in the clock offset if the averages are time-stamped at their beginning or end",
            whose(length),
            size(length)
        )));
    }
    let Some(bands) = clock.bands.as_ref().filter(|bands| bands.scatter.p < TOLD_BELOW) else {
        return findings;
    };
    let ends = [bands.bands.first(), bands.bands.last()].map(|band| {
        band.map_or_else(String::new, |band| {
            format!(
                "{} at periods of {} to {}",
                band.delay_in_words(),
                duration(band.shortest_s),
                duration(band.longest_s)
            )
        })
    });
    let form = match (bands.form, &bands.time_constant_s) {
        (DelayForm::LowPass, Some(time)) => format!(
            "as with a first-order low-pass filter in the {}, with a time constant of {} s",
            whose(time),
            size(time)
        ),
        _ => "not as with a first-order low-pass filter".into(),
    };
    findings.push(Code::DelayDependsOnPeriod.said(format!(
        "the delay depends on the period ({}): {} and {}, {form}. This is a filter effect: shifting the times cannot correct it",
        p_value(bands.scatter.p),
        ends[0],
        ends[1]
    )));
    findings
}

fn said(jump: &ClockJump) -> String {
    let with =
        |of: &Quantity| signed(&of.std().map_or_else(|| of.to_string(), |std| uncertain(of.value(), std)));
    let pause = jump.by_s.value() == 0.0;
    let what = if pause {
        "skip rows before".to_string()
    } else {
        format!("jump by {} s in", signed(&significant(jump.by_s.value(), 3)))
    };
    let place =
        format!("the times of \"{}\" {what} row {} ({} s)", jump.recording, jump.row, bare(jump.time_s));
    let Some(name) = &jump.instrument else {
        return format!(
            "{place}: both instruments share these times, so the field cannot show whether the sampling jumped with them; the series was split there"
        );
    };
    let change = jump.offset_change_s.as_ref();
    let of_field = change.map_or_else(
        || "there are too few readings nearby to determine an offset".to_string(),
        |change| format!("the offset of the {name} instrument's clock changes by {} s there", with(change)),
    );
    let says = match jump.verdict {
        JumpVerdict::Contradicted if pause => {
            "the field contradicts the gap: the clock was reset while the sampling went on"
        }
        JumpVerdict::Other if pause => "the clock was reset there; check the logger",
        JumpVerdict::Confirmed => "the field confirms it: the sampling jumped with the times",
        JumpVerdict::Contradicted => {
            "the field contradicts it: only the times jumped while the sampling went on"
        }
        JumpVerdict::Other => "the field disagrees with the times; check the logger there",
        JumpVerdict::Unclear => "the field cannot show whether the sampling jumped with the times",
    };
    let p = change.filter(|_| jump.verdict == JumpVerdict::Other);
    let p = p.map(|change| format!(" ({})", p_value(p_of(change)))).unwrap_or_default();
    format!("{place}: {of_field}{p}; {says}")
}
