//! The result in a few lines for people.

use common::{
    Axis, DifferentialFit, Document, Drift, DriftForm, EventInstrument, EventKind, FourteenParameters,
    KeptOut, Magnetometer, OneMatrix, Quantity,
};
use std::fmt::Write;

use crate::events::CONFIRMED;
use crate::reference_noise;
use crate::regression::p_of;

/// Spectra that agree worse than this by chance are not of the form that is fitted.
const UNLIKE_BELOW: f64 = 1e-3;
/// Tests of whether the matrix holds still are told below this probability.
pub const TOLD_BELOW: f64 = 0.01;
/// The independent interval is too narrow when the honest one is wider by this.
const NARROW: f64 = 1.5;

/// Which interval to quote.
pub fn quoted() -> String {
    "the weighted elements with `weighted_std`: both rest on the spectrum of the difference, flicker noise included; least \
     squares with N − 4 degrees of freedom takes the samples as independent"
        .into()
}

/// What looks wrong, or is worth knowing. `wider`: of each axis, how many times as wide its intervals are by what is left itself.
pub fn findings(fit: &DifferentialFit, told_below: f64, wider: &[f64; 3]) -> Vec<String> {
    let mut findings = Vec::new();
    let ratio = fit.elements.values().map(|e| e.std_noise / e.std_independent).fold(0.0, f64::max);
    if ratio > NARROW {
        findings.push(format!(
            "the errors have memory: intervals as if the samples were independent would be up to {ratio:.1} times too narrow"
        ));
    }
    for (axis, of) in fit.axes.iter() {
        if of.goodness_p < UNLIKE_BELOW {
            findings.push(format!(
                "axis {axis}: the difference is not A/f^α and white noise (p = {:.1e}); something else is in it. `weighted_std` takes \
                 that form as true; by what is left itself it would be up to {:.1} times as wide",
                of.goodness_p,
                wider[axis.index()]
            ));
        }
        if let Some(highest) = of.weighted_up_to_hz {
            findings.push(format!(
                "axis {axis}: the matrix rests on periods above {}; at shorter ones the instruments do not answer alike (filters, or noise of the reference)",
                duration(1.0 / highest)
            ));
        }
        findings.extend(drift(&of.drift).map(|text| format!("axis {axis}: the difference drifts {text}")));
    }
    if let Some(clock) = &fit.clock {
        let (late, fast) = (p_of(&clock.offset_s), p_of(&clock.rate_ppm));
        let mend =
            if clock.corrected { "corrected for" } else { "the matrix suffers; ask for --correct-clock" };
        if late < told_below {
            findings.push(format!("the clocks differ (p = {late:.1e}): {mend}"));
        }
        if fast < told_below {
            findings.push(format!("the clocks run at different rates (p = {fast:.1e}): {mend}"));
        }
        if clock.corrected {
            findings.push(moved());
        }
    }
    findings.extend(kept_out(&fit.kept_out));
    if fit.missing > 0 {
        findings.push(format!(
            "{} samples lack a reading or were taken out; in their places stand the most likely readings under the fitted noise",
            fit.missing
        ));
    }
    findings
}

fn kept_out(kept_out: &KeptOut) -> Vec<String> {
    let of = |kind: EventKind| kept_out.events.iter().filter(|event| event.kind == kind).count();
    let (steps, spikes, intervals) = (of(EventKind::Step), of(EventKind::Spike), of(EventKind::Interval));
    let mut findings = Vec::new();
    if steps + spikes + intervals > 0 {
        findings.push(format!(
            "kept out of the fit: {steps} steps (fitted with it), {spikes} spikes and {intervals} disturbed intervals (taken out); \
             `kept_out` lists them"
        ));
    }
    if kept_out.events.iter().any(|event| event.instrument == EventInstrument::Either) {
        findings.push(
            "of some events it cannot be told in which instrument they are: the axes lie too close".into(),
        );
    }
    if kept_out.more {
        findings.push("there are more steps and spikes than are looked for: the noise is not of the form that is fitted".into());
    }
    findings
}

/// Events that were found and are none.
pub fn unconfirmed([steps, others]: [usize; 2]) -> Option<String> {
    let counted = |count: usize, one: &str| match count {
        0 => None,
        1 => Some(format!("one {one}")),
        _ => Some(format!("{count} {one}s")),
    };
    let both = [counted(steps, "step"), counted(others, "spike or disturbed interval")];
    let what = both.into_iter().flatten().collect::<Vec<_>>().join(" and ");
    (!what.is_empty()).then(|| {
        format!(
            "the search took the readings for {what} that the final fit does not confirm: below {CONFIRMED} uncertainties of its size; \
             left in"
        )
    })
}

fn moved() -> String {
    "the test instrument's readings were moved in time by a filter: its white noise is lower near half the sampling rate, and the \
     noise is told from the band below"
        .into()
}

/// A third instrument.
pub fn third() -> String {
    "the third instrument's readings are in no regression of `fit`; they take the pull of the reference's noise off `matrix`, and \
     `three_cornered` has the noise of each of the three by them"
        .into()
}

/// Times that are not quite even.
pub fn scattered(id: &str, by_s: f64) -> String {
    format!("\"{id}\": its times scatter by up to {by_s:.3} s about even ones and are taken as even")
}

/// Times that were made even.
pub fn uneven(id: &str, step_s: f64) -> String {
    format!(
        "\"{id}\": its times are uneven; its readings were interpolated to steps of {step_s:.6} s, which lowers their noise unevenly"
    )
}

/// An instrument that was brought to another grid.
pub fn filtered(instrument: &str, from_s: f64, to_s: f64, white: f64) -> String {
    format!(
        "the {instrument} instrument's readings, {from_s} s apart, were filtered to the grid of {to_s} s: {:.0} % of the rms of its white \
         noise pass, and the noise is told from the band below 0.9 of half the sampling rate",
        100.0 * white
    )
}

/// Which drift the readings demand.
fn drift(of: &Drift) -> Option<String> {
    let straight = || {
        let rate = plus_minus(&of.straight_nt_per_day, 4);
        format!("by {rate} nT a day (p = {:.1e})", of.straight_p)
    };
    let exponential = || {
        let joint = of.joint.as_ref()?;
        let limit = if joint.time_constant_at_limit { ", at the limit of what is sought" } else { "" };
        Some(format!(
            "exponentially, {} nT at the beginning with a time constant of {:.0} s ({:.0} to {:.0}{limit}; p = {:.1e})",
            plus_minus(&joint.amplitude_nt, 3),
            joint.time_constant_s.value(),
            joint.time_constant_interval_s[0],
            joint.time_constant_interval_s[1],
            of.exponential_p
        ))
    };
    match of.demanded {
        DriftForm::None => None,
        DriftForm::Straight => Some(straight()),
        DriftForm::Exponential => exponential(),
        DriftForm::Both => exponential().map(|text| format!("{text}, and {}", straight())),
    }
}

/// Probability of estimates so far apart, by the axes together or by one of them: twice and six times the least.
pub fn p_of_one(test: &OneMatrix) -> f64 {
    let axes = test.axes.iter().map(|(_, axis)| 6.0 * axis.p);
    axes.fold(2.0 * test.p, f64::min).min(1.0)
}

/// A time or a period in the unit that suits it.
pub fn duration(seconds: f64) -> String {
    match seconds.abs() {
        s if s < 120.0 => format!("{seconds:.3} s"),
        s if s < 7_200.0 => format!("{:.1} min", seconds / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", seconds / 3_600.0),
        _ => format!("{:.2} days", seconds / 86_400.0),
    }
}

fn plus_minus(quantity: &Quantity, digits: usize) -> String {
    format!("{:+.digits$} ± {:.digits$}", quantity.value(), quantity.std().unwrap_or(0.0))
}

/// What was found, with ± and units.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    let found = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let Some(fit) = found.and_then(|found| found.fit.as_ref()) else { return text };
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "diffmag: \"{}\", {} samples of {} s",
        fit.recordings.join("\", \""),
        fit.samples,
        fit.step_s
    );
    for axis in Axis::ALL {
        let row: Vec<String> = Axis::ALL
            .iter()
            .filter_map(|from| fit.elements.get(&format!("{from}{axis}")))
            .map(|element| format!("{:+.6} ± {:.6}", element.weighted, element.weighted_std))
            .collect();
        let _ = writeln!(text, "  test {axis} from the reference's x, y, z: {}", row.join(", "));
    }
    for (axis, of) in fit.axes.iter() {
        let offset = found.and_then(|found| found.offset_nt.as_ref()?.get(axis));
        let (day, month) = (&of.drift.per_day, &of.drift.per_month);
        let per_day = day.as_ref().map_or(&of.drift.straight_nt_per_day, |day| &day.drift_nt);
        let per_month =
            month.as_ref().map(|month| format!(", {} nT a month", plus_minus(&month.drift_nt, 3)));
        let _ = writeln!(
            text,
            "  test {axis}: offset {} nT, rms {:.3} nT, {:.2} ± {:.2} pT/√Hz at 1 Hz as f^{:.2}, drift {} nT a day{}",
            offset.map_or(String::new(), |offset| plus_minus(offset, 3)),
            of.rms_nt,
            1e3 * of.density_at_1hz_nt_per_sqrt_hz.value(),
            1e3 * of.density_at_1hz_nt_per_sqrt_hz.std().unwrap_or(0.0),
            -of.flicker_exponent.value(),
            plus_minus(per_day, 4),
            per_month.unwrap_or_default()
        );
    }
    if let Some(clock) = &fit.clock {
        let _ = writeln!(
            text,
            "  clock of the test instrument: {} s late, {} ppm",
            plus_minus(&clock.offset_s, 4),
            plus_minus(&clock.rate_ppm, 3)
        );
        if let (Some(offset), Some(rate)) = (&clock.left_offset_s, &clock.left_rate_ppm) {
            let _ =
                writeln!(text, "  corrected; left: {} s, {} ppm", plus_minus(offset, 4), plus_minus(rate, 3));
        }
    }
    let of_reference = fit.reference_noise.as_ref();
    for line in of_reference.map(reference_noise::lines).unwrap_or_default() {
        let _ = writeln!(text, "  {line}");
    }
    if let Some(fourteen) = found.and_then(|found| found.fourteen.as_ref()) {
        text += &mutual(fourteen);
    }
    let of_reference = of_reference.map(|noise| noise.findings.as_slice()).unwrap_or_default();
    let moved = fit.stability.iter().flat_map(|stability| &stability.findings);
    for finding in fit.findings.iter().chain(of_reference).chain(moved) {
        let _ = writeln!(text, "    {finding}");
    }
    text
}

/// How the instruments stand to each other.
fn mutual(fourteen: &FourteenParameters) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = match (fourteen.known, fourteen.assumed) {
        (_, true) => {
            writeln!(text, "  if the reference is orthogonal with equal scales (nobody said; see `known`):")
        }
        (Magnetometer::Reference, false) => writeln!(text, "  with the reference as known:"),
        (Magnetometer::Test, false) => writeln!(text, "  with the test instrument as known:"),
    };
    let angles: Vec<String> = fourteen
        .angles
        .iter()
        .filter(|(name, angle)| angle.std_arcsec > 0.0 && !fourteen.undetermined.contains(name))
        .map(|(name, angle)| format!("{name} {:.5}° ± {:.2}″", angle.value_deg, angle.std_arcsec))
        .collect();
    let _ = writeln!(text, "    {}", angles.join(", "));
    let ratios: Vec<String> = fourteen
        .ratios
        .iter()
        .filter(|(_, ratio)| ratio.std() != Some(0.0))
        .map(|(name, ratio)| {
            format!("{} {:.6} ± {:.6}", name.replace('_', "/"), ratio.value(), ratio.std().unwrap_or(0.0))
        })
        .collect();
    let _ = writeln!(text, "    scales {}", ratios.join(", "));
    let (whose, angles) = match fourteen.known {
        Magnetometer::Reference => ("test instrument", &fourteen.test_non_orthogonality_arcsec),
        Magnetometer::Test => ("reference", &fourteen.reference_non_orthogonality_arcsec),
    };
    let angles: Vec<String> =
        angles.iter().map(|(pair, angle)| format!("{pair} {}″", plus_minus(angle, 1))).collect();
    let _ = writeln!(text, "    {whose} off right angles: {}", angles.join(", "));
    text
}
