//! What parts and bands say of the clocks, in words.

use common::number::{duration, p_value, significant, uncertain};
use common::{ClockDifference, DelayForm};

use crate::TOLD_BELOW;

/// What parts and bands say, in words.
pub fn findings(clock: &ClockDifference) -> Vec<String> {
    let mut findings = Vec::new();
    if let Some(parts) = clock.parts.as_ref().filter(|parts| parts.p < TOLD_BELOW) {
        findings.push(format!(
            "the clocks' offset is not the same in all parts of the recording: {} parts scatter by {} s, {} times their uncertainties ({}); its \
             uncertainty is that scatter",
            parts.count,
            significant(parts.between_s, 2),
            significant(parts.birge_ratio, 2),
            p_value(parts.p)
        ));
    }
    if let Some(length) = clock.bands.as_ref().and_then(|bands| bands.average_s.as_ref()) {
        let whose = if length.value() < 0.0 { "reference" } else { "test instrument" };
        findings.push(format!(
            "the response by period is as if the readings of the {whose} were means over {} s where the other's are not; half of that is in the offset of the \
             clocks where such a mean is stamped at its beginning or end",
            uncertain(length.value().abs(), length.std().unwrap_or(0.0))
        ));
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
            format!("as of a low-pass filter of first order in the {whose}, with a time constant of {size} s")
        }
        _ => "not as of a low-pass filter of first order".into(),
    };
    findings.push(format!(
        "the delay depends on the period ({}): {} and {}, {form}. A filter is no clock: no shift of times mends it",
        p_value(bands.scatter.p),
        ends[0],
        ends[1]
    ));
    findings
}
