//! What the bands say of the matrix, in words.

use common::number::{duration, p_value, signed, significant, uncertain};
use common::{Axis, Code, Finding, TransferBand, TransferBands};

use super::LONG_S;
use crate::words::p_of_one;
use paired::{TOLD_BELOW, p_of};

struct Element<'a> {
    band: &'a TransferBand,
    value: f64,
    std: f64,
}

pub fn findings(found: &TransferBands) -> Vec<Finding> {
    let mut findings = Vec::new();
    let told = |band: &TransferBand| format!("{} ({})", periods(band), significant(band.freedom, 2));
    let few: Vec<String> = found.bands.iter().filter(|band| !band.tested).map(told).collect();
    if !few.is_empty() {
        let words = format!("period bands with too few degrees of freedom to be tested: {}", few.join(", "));
        findings.push(Code::TooFewDegreesOfFreedom.said(words));
    }
    let clock = p_of(&found.clock.offset_s);
    if clock < TOLD_BELOW && found.clock.alike_p >= TOLD_BELOW {
        findings.push(Code::ClockOffset.said(format!(
            "the phase between the instruments grows with frequency, equally on all axes: the test instrument's clock is {} by \
             {} s ({})",
            if found.clock.offset_s.value() > 0.0 { "late" } else { "early" },
            uncertain(found.clock.offset_s.value().abs(), found.clock.offset_s.std().unwrap_or(0.0)),
            p_value(clock)
        )));
    }
    let p = p_of_one(&found.one_matrix_with_clock);
    if p >= TOLD_BELOW {
        return findings;
    }
    let short = found.one_matrix_short_periods.as_ref().is_some_and(|test| p_of_one(test) < TOLD_BELOW);
    let (pair, cause) = if short {
        let pair = farthest(found, |a, b| a.from_period_s < LONG_S || b.from_period_s < LONG_S);
        (
            pair,
            "induced currents that differ between the sites would cause this, mostly at short periods and in z",
        )
    } else {
        let pair = farthest(found, |a, b| (a.to_period_s < LONG_S) != (b.to_period_s < LONG_S));
        (
            pair,
            "periods below half a day agree with each other, which points to the daily cycle: a tilting pillar or a temperature. Induction with a time constant of hours would look the same",
        )
    };
    let Some((name, a, b)) = pair else { return findings };
    findings.push(Code::DependsOnPeriod.said(format!(
        "the matrix depends on the period ({}): {} {name} is {}, {} {}; {cause}",
        p_value(p),
        periods(a.band),
        signed(&uncertain(a.value, a.std)),
        periods(b.band),
        signed(&uncertain(b.value, b.std))
    )));
    findings
}

/// The part of an element, real or imaginary, that differs most for its uncertainty between two bands.
fn farthest<'a>(
    found: &'a TransferBands,
    allowed: impl Fn(&TransferBand, &TransferBand) -> bool,
) -> Option<(String, Element<'a>, Element<'a>)> {
    let tested: Vec<&TransferBand> = found.bands.iter().filter(|band| band.tested).collect();
    let mut best: Option<(f64, String, Element<'a>, Element<'a>)> = None;
    for (number, short) in tested.iter().enumerate().rev() {
        for long in tested[..number].iter().filter(|long| allowed(short, long)) {
            for (from, to) in Axis::ALL.into_iter().flat_map(|from| Axis::ALL.map(|to| (from, to))) {
                let (i, j) = (from.index(), to.index());
                for imaginary in [false, true] {
                    let of = |band: &'a TransferBand| {
                        let (values, std) = if imaginary {
                            (&band.imaginary, &band.imaginary_std)
                        } else {
                            (&band.real, &band.real_std)
                        };
                        Element { band, value: values[i][j], std: std[i][j] }
                    };
                    let (a, b) = (of(short), of(long));
                    let significance = (a.value - b.value).abs() / a.std.hypot(b.std);
                    if best.as_ref().is_none_or(|best| significance > best.0) {
                        let part = if imaginary { ", out of phase," } else { "" };
                        best = Some((significance, format!("{to} from {from}{part}"), a, b));
                    }
                }
            }
        }
    }
    best.map(|(_, name, a, b)| (name, a, b))
}

fn periods(band: &TransferBand) -> String {
    format!("from {} to {}", duration(band.from_period_s), duration(band.to_period_s))
}
