//! What parts and bands say of the clocks, in words.

use common::number::{duration, p_value, significant, uncertain};
use common::{ClockDifference, Code, DelayForm, Finding};

use crate::TOLD_BELOW;

/// What parts and bands say, in words.
pub fn findings(clock: &ClockDifference) -> Vec<Finding> {
    let mut findings = Vec::new();
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
        let whose = if length.value() < 0.0 { "reference" } else { "test instrument" };
        findings.push(Code::AveragedReadings.said(format!(
            "the response against period is that of readings of the {whose} averaged over {} s, unlike the other's; half of that is in the clock offset if the averages are time-stamped at their beginning or end",
            uncertain(length.value().abs(), length.std().unwrap_or(0.0))
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
        (DelayForm::LowPass, Some(time)) => {
            let whose = if time.value() < 0.0 { "reference" } else { "test instrument" };
            let size = uncertain(time.value().abs(), time.std().unwrap_or(0.0));
            format!("as with a first-order low-pass filter in the {whose}, with a time constant of {size} s")
        }
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
