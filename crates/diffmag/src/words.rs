//! The result in a few lines for people.

use common::number::{
    as_known, bare, counted, duration, figures, p_value, plural, signed, significant, uncertain,
};
use common::{
    Axis, DifferentialFit, Document, Drift, DriftForm, EventInstrument, EventKind, FourteenParameters,
    KeptOut, Magnetometer, OneMatrix,
};
use std::fmt::Write;

use crate::events::CONFIRMED;
use crate::regression::p_of;
use crate::{delays, reference_noise, segments};

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
            "the errors have memory: intervals as if the samples were independent would be up to {} times too narrow",
            significant(ratio, 2)
        ));
    }
    for (axis, of) in fit.axes.iter() {
        if of.goodness_p < UNLIKE_BELOW {
            findings.push(format!(
                "axis {axis}: the difference is not A/f^α and white noise ({}); something else is in it. `weighted_std` takes \
                 that form as true; by what is left itself it would be up to {} times as wide",
                p_value(of.goodness_p),
                significant(wider[axis.index()], 2)
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
            findings.push(format!("the clocks differ ({}): {mend}", p_value(late)));
        }
        if fast < told_below {
            findings.push(format!("the clocks run at different rates ({}): {mend}", p_value(fast)));
        }
        findings.extend(segments::findings(clock));
        findings.extend(delays::findings(clock));
        if clock.corrected {
            findings.push(moved());
        }
    }
    findings.extend(kept_out(&fit.kept_out));
    if fit.missing > 0 {
        findings.push(format!(
            "{} without a reading or taken out; the most likely reading under the fitted noise stands in each place",
            counted(fit.missing, "sample")
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
            "kept out of the fit: {} (fitted with it), {} and {} (taken out); `kept_out` lists them",
            counted(steps, "step"),
            counted(spikes, "spike"),
            counted(intervals, "disturbed interval")
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
    let both = [
        (steps, counted(steps, "step")),
        (
            others,
            format!(
                "{others} {}",
                plural(others, "spike or disturbed interval", "spikes or disturbed intervals")
            ),
        ),
    ];
    let what: Vec<String> =
        both.into_iter().filter(|(count, _)| *count > 0).map(|(_, words)| words).collect();
    let what = what.join(" and ");
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

/// Which drift the readings demand.
fn drift(of: &Drift) -> Option<String> {
    let straight = || format!("by {:+} nT a day ({})", of.straight_nt_per_day, p_value(of.straight_p));
    let exponential = || {
        let joint = of.joint.as_ref()?;
        let [low, high] = joint.time_constant_interval_s.map(|end| significant(end, 3));
        let limit = if joint.time_constant_at_limit { ", at the limit of what is sought" } else { "" };
        Some(format!(
            "exponentially, {:+} nT at the beginning with a time constant of {} s ({low} to {high}{limit}; {})",
            joint.amplitude_nt,
            significant(joint.time_constant_s.value(), 3),
            p_value(of.exponential_p)
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

/// What was found, with ± and units.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    let found = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let Some(fit) = found.and_then(|found| found.fit.as_ref()) else { return text };
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "diffmag: \"{}\", {} of {} s",
        fit.recordings.join("\", \""),
        counted(fit.samples, "sample"),
        bare(fit.step_s)
    );
    for axis in Axis::ALL {
        let row: Vec<String> = Axis::ALL
            .iter()
            .filter_map(|from| fit.elements.get(&format!("{from}{axis}")))
            .map(|element| signed(&uncertain(element.weighted, element.weighted_std)))
            .collect();
        let _ = writeln!(text, "  test {axis} from the reference's x, y, z: {}", row.join(", "));
    }
    for (axis, of) in fit.axes.iter() {
        let offset = found.and_then(|found| found.offset_nt.as_ref()?.get(axis));
        let (day, month) = (&of.drift.per_day, &of.drift.per_month);
        let per_day = day.as_ref().map_or(&of.drift.straight_nt_per_day, |day| &day.drift_nt);
        let per_month = month.as_ref().map(|month| format!(", {:+} nT a month", month.drift_nt));
        let density = &of.density_at_1hz_nt_per_sqrt_hz;
        let _ = writeln!(
            text,
            "  test {axis}: offset {} nT, rms {} nT, {} pT/√Hz at 1 Hz, as 1/f^α with α = {}, drift {per_day:+} nT a day{}",
            offset.map_or("missing".into(), |offset| format!("{offset:+}")),
            significant(of.rms_nt, 3),
            uncertain(1e3 * density.value(), 1e3 * density.std().unwrap_or(0.0)),
            of.flicker_exponent,
            per_month.unwrap_or_default()
        );
    }
    if let Some(clock) = &fit.clock {
        let _ = writeln!(
            text,
            "  clock of the test instrument: {:+} s late, {:+} ppm",
            clock.offset_s, clock.rate_ppm
        );
        if let (Some(offset), Some(rate)) = (&clock.left_offset_s, &clock.left_rate_ppm) {
            let _ = writeln!(text, "  corrected; left: {offset:+} s, {rate:+} ppm");
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
        .map(|(name, angle)| {
            let degrees = as_known(angle.value_deg, angle.std_arcsec / 3600.0);
            format!("{name} {degrees}° ± {}″", figures(angle.std_arcsec, 2))
        })
        .collect();
    let _ = writeln!(text, "    {}", angles.join(", "));
    let ratios: Vec<String> = fourteen
        .ratios
        .iter()
        .filter(|(_, ratio)| ratio.std() != Some(0.0))
        .map(|(name, ratio)| format!("{} {ratio}", name.replace('_', "/")))
        .collect();
    let _ = writeln!(text, "    scales {}", ratios.join(", "));
    let (whose, angles) = match fourteen.known {
        Magnetometer::Reference => ("test instrument", &fourteen.test_non_orthogonality_arcsec),
        Magnetometer::Test => ("reference", &fourteen.reference_non_orthogonality_arcsec),
    };
    let angles: Vec<String> = angles.iter().map(|(pair, angle)| format!("{pair} {angle:+}″")).collect();
    let _ = writeln!(text, "    {whose} off right angles: {}", angles.join(", "));
    text
}
