//! The result in a few lines for people.

use common::number::{
    as_known, bare, counted, duration, figures, p_value, plural, signed, significant, uncertain,
};
use common::unit;
use common::{
    Axis, ClockDifference, Code, Contribution, ContributionCause, DifferenceAxis, DifferentialFit, Document,
    Drift, DriftForm, EventInstrument, EventKind, Finding, Findings, Followed, FourteenParameters, KeptOut,
    KeptOutEvent, Magnetometer, OneMatrix, PlainRegression,
};

use crate::reference_noise;
use paired::events::CONFIRMED;
use paired::{TOLD_BELOW, p_of};

/// Spectra that agree worse than this by chance are not of the form that is fitted.
const UNLIKE_BELOW: f64 = 1e-3;
/// A drift of more than this probability that is not demanded is told: three to one, from where on Kass and
/// Raftery call evidence positive.
const UNDECIDED: f64 = 0.75;
/// The independent interval is too narrow when the honest one is wider by this.
const NARROW: f64 = 1.5;
/// What lowers an rms to less than this share of it is worth the first line.
const MATTERS: f64 = 0.95;

/// Which interval to quote.
pub fn quoted() -> String {
    "the weighted elements with `weighted_std`: both use the spectrum of the difference, including flicker noise; least squares with N − 4 degrees of freedom assumes independent samples"
        .into()
}

/// The answer in one sentence: the largest thing that can be mended, else what the matrix does.
pub fn answer(fit: &DifferentialFit) -> String {
    let better = better(fit).map_or(String::new(), |words| format!("; {words}"));
    mended(fit) + &better
}

/// That a plain regression predicts held-out readings better, where one does.
fn better(fit: &DifferentialFit) -> Option<String> {
    let held_out = fit.held_out.as_ref()?;
    let plain = PlainRegression::better(&held_out.plain, held_out.named_nt)?;
    Some(plain.predicts_better(held_out.named_nt))
}

/// The largest thing that can be mended, else what the matrix does.
fn mended(fit: &DifferentialFit) -> String {
    if let Some(finding) = fit.axes.iter().find_map(|(axis, of)| exceeded(axis, of)) {
        return finding.words;
    }
    let lowers = |one: &&Contribution| one.changes().any(|(_, with, without)| without < MATTERS * with);
    let mended = |one: &&Contribution| one.cause != ContributionCause::ShortPeriods;
    if let Some(one) = fit.contributions.iter().filter(mended).find(lowers) {
        return contribution(one);
    }
    let each = |of: fn(&DifferenceAxis) -> Option<f64>| -> Vec<String> {
        fit.axes.iter().filter_map(|(_, axis)| of(axis)).map(|nt| significant(nt, 3)).collect()
    };
    format!(
        "the matrix leaves {} nT (rms of x; y; z) of the {} nT by which the two differ with only their offsets removed; no correction reduces that by 5 %",
        each(|axis| Some(axis.rms_nt)).join("; "),
        each(|axis| axis.rms_of_levels_nt).join("; ")
    )
}

/// An axis of which more is left than there was.
fn exceeded(axis: Axis, of: &DifferenceAxis) -> Option<Finding> {
    let own = of.exceeded_nt()?;
    Some(Code::ResidualIncreased.about(axis).said(format!(
        "test {axis}: the residual of {} nT rms exceeds the {} nT before any fit; do not use this matrix",
        significant(of.left_nt(), 3),
        significant(own, 3)
    )))
}

/// What a contribution is and what the difference is without it.
fn contribution(one: &Contribution) -> String {
    let lead = match one.cause {
        ContributionCause::Clock => "with this corrected",
        ContributionCause::Steps => "with the steps removed",
        ContributionCause::Disturbances => "with these excluded",
        ContributionCause::Drift => "with the drift removed",
        ContributionCause::ShortPeriods => "at longer periods only",
        ContributionCause::Column => "with this removed",
    };
    let change = |(axis, with, without): (Axis, f64, f64)| {
        let verb = if without < with { "falls" } else { "rises" };
        format!("{axis} {verb} from {} to {} nT", significant(with, 3), significant(without, 3))
    };
    let changes: Vec<String> = one.changes().map(change).collect();
    let changes = if changes.is_empty() { "no axis changes by 1 %".into() } else { changes.join(", ") };
    let ask =
        if one.cause == ContributionCause::Clock && !one.taken_off { " (use --correct-clock)" } else { "" };
    format!("{}; {lead}, {changes}{ask}", one.what)
}

pub fn clock(clock: &ClockDifference) -> String {
    let offset = format!("the test instrument's timestamps are {}", clock.offset_in_words());
    let rate = clock.rate_in_words();
    match (p_of(&clock.offset_s) < TOLD_BELOW, p_of(&clock.rate_ppm) < TOLD_BELOW) {
        (true, true) => format!("{offset} in the middle of the recording, and its clock runs {rate}"),
        (false, true) => format!("the test instrument's clock runs {rate}"),
        _ => offset,
    }
}

/// Slow changes that may be a drift or noise alone.
fn undecided(fit: &DifferentialFit) -> impl Iterator<Item = Finding> {
    fit.axes.iter().filter_map(|(axis, of)| {
        let found = of.drift.explanations.as_ref()?;
        let open = of.drift.demanded == DriftForm::None && found.drift > UNDECIDED;
        open.then(|| {
            Code::DriftOrNoise.about(axis).said(format!(
                "test {axis}: a drift of {:+} nT a day (probability {}), or noise with memory and no drift ({}); a longer recording would decide",
                found.straight_nt_per_day,
                significant(found.drift, 2),
                significant(found.noise_alone, 2)
            ))
        })
    })
}

pub fn drifts(fit: &DifferentialFit) -> Option<String> {
    let one = |(axis, of): (Axis, &DifferenceAxis)| drift(&of.drift).map(|words| format!("{axis} {words}"));
    let all: Vec<String> = fit.axes.iter().filter_map(one).collect();
    (!all.is_empty()).then(|| format!("the difference drifts: {}", all.join("; ")))
}

/// Of each housekeeping column that an axis follows its name, and by how much the axes follow it: those of
/// which two standard uncertainties know it.
pub fn followed(fit: &DifferentialFit) -> Vec<(String, String)> {
    let known = |one: &&Followed| one.nt_per_unit.value().abs() > 2.0 * one.nt_per_unit.std().unwrap_or(0.0);
    let all = || {
        fit.axes
            .iter()
            .flat_map(move |(axis, of)| of.follows.iter().filter(known).map(move |one| (axis, one)))
    };
    let mut names: Vec<&str> = Vec::new();
    for (_, one) in all() {
        if !names.contains(&one.column.as_str()) {
            names.push(&one.column);
        }
    }
    let of = |name: &str| {
        let one = |(axis, one): (Axis, &Followed)| {
            let lag = one.lag_s.as_ref().map_or(String::new(), |lag| format!(", {lag} s behind it"));
            let rows = match one.late_rows {
                0 => String::new(),
                rows => {
                    let when = if rows > 0 { "late" } else { "early" };
                    format!(", logged {} {when}", counted(rows.unsigned_abs() as usize, "row"))
                }
            };
            let power = one.exponent.map_or(String::new(), |exponent| format!("^{exponent:.2}"));
            format!("{axis} by {:+} nT/{}{power}{lag}{rows}", one.nt_per_unit, unit::in_words(name))
        };
        let axes: Vec<String> = all().filter(|(_, one)| one.column == name).map(one).collect();
        (name.to_string(), format!("the difference follows `{name}`: {}", axes.join("; ")))
    };
    names.into_iter().map(of).collect()
}

pub fn steps(kept_out: &KeptOut) -> Option<String> {
    let steps = kept_out.events.iter().filter(|event| event.kind == EventKind::Step);
    let largest = largest(steps.clone())?;
    Some(format!("{}, {largest}", counted(steps.count(), "step")))
}

pub fn disturbances(kept_out: &KeptOut) -> Option<String> {
    let of = |kind: EventKind| kept_out.events.iter().filter(move |event| event.kind == kind);
    let largest = largest(kept_out.events.iter().filter(|event| event.kind != EventKind::Step))?;
    let all =
        [(of(EventKind::Spike).count(), "spike"), (of(EventKind::Interval).count(), "disturbed interval")];
    let all = all.into_iter().filter(|(count, _)| *count > 0).map(|(count, of)| counted(count, of));
    Some(format!("{}, {largest}", all.collect::<Vec<_>>().join(" and ")))
}

fn largest<'a>(events: impl Iterator<Item = &'a KeptOutEvent>) -> Option<String> {
    let size = |event: &KeptOutEvent| event.size_nt.value().abs();
    let event = events.max_by(|a, b| size(a).total_cmp(&size(b)))?;
    let instrument = match event.instrument {
        EventInstrument::Test => "test",
        EventInstrument::Reference => "reference",
        EventInstrument::Either => "test or reference",
    };
    Some(format!(
        "the largest {:+} nT in {instrument} {} at {} s",
        event.size_nt,
        event.axis,
        bare(event.time_s)
    ))
}

pub fn short_periods(fit: &DifferentialFit) -> Option<String> {
    let mut all: Vec<(String, Vec<&str>)> = Vec::new();
    for (axis, of) in fit.axes.iter() {
        let Some(period) = of.weighted_up_to_hz.map(|highest| duration(1.0 / highest)) else { continue };
        match all.iter_mut().find(|(other, _)| *other == period) {
            Some((_, axes)) => axes.push(axis.letter()),
            None => all.push((period, vec![axis.letter()])),
        }
    }
    let told = |(period, axes): &(String, Vec<&str>)| format!("{period} in {}", axes.join(" and "));
    let all: Vec<String> = all.iter().map(told).collect();
    (!all.is_empty()).then(|| {
        format!(
            "at periods below {} the responses of the instruments differ (filters, or noise of the reference); the matrix is based on longer periods",
            all.join(", ")
        )
    })
}

/// What looks wrong, or is worth knowing: what can be taken off first, the largest before the others.
/// `wider`: of each axis, how many times as wide its intervals are by what is left itself.
pub fn findings(fit: &DifferentialFit, wider: &[f64; 3]) -> Findings {
    let mut findings = Findings::default();
    findings.extend(fit.axes.iter().filter_map(|(axis, of)| exceeded(axis, of)));
    let adds = |one: &Contribution| Code::Contribution.about(one.name()).said(contribution(one));
    findings.extend(fit.contributions.iter().map(adds));
    findings.extend(better(fit).map(|words| Code::RegressionPredictsBetter.said(words)));
    let ratio = fit.elements.values().map(|e| e.std_noise / e.std_independent).fold(0.0, f64::max);
    if ratio > NARROW {
        findings.push(Code::SeriallyCorrelated.said(format!(
            "the errors are correlated in time: intervals for independent samples would be up to {} times too narrow",
            significant(ratio, 2)
        )));
    }
    for (axis, of) in fit.axes.iter().filter(|(_, of)| of.goodness_p < UNLIKE_BELOW) {
        findings.push(Code::SpectralForm.about(axis).said(format!(
            "axis {axis}: the difference is not of the form A/f^α plus white noise ({}); it contains something else. In bands that are not of that form the weights use the level of each octave; with the spectrum of the residuals `weighted_std` would be up to {} times as large",
            p_value(of.goodness_p),
            significant(wider[axis.index()], 2)
        )));
    }
    findings.extend(undecided(fit));
    if let Some(clock) = &fit.clock {
        findings.extend(paired::findings(clock));
        let shifted = "the readings of the test instrument were shifted in time by a filter, which attenuates white noise near half the sampling rate; the noise is estimated below that band";
        findings.extend(clock.corrected.then(|| Code::TimesShifted.said(shifted)));
    }
    if fit.kept_out.events.iter().any(|event| event.instrument == EventInstrument::Either) {
        let words = "some events cannot be assigned to one instrument: the axes are too nearly parallel";
        findings.push(Code::EventsUnassigned.said(words));
    }
    if fit.kept_out.more {
        let words =
            "there are more steps and spikes than the search allows: the noise is not of the fitted form";
        findings.push(Code::TooManyEvents.said(words));
    }
    if fit.missing > 0 {
        findings.push(Code::MissingSamples.said(format!(
            "{} missing or excluded; each is replaced by its most likely value under the fitted noise",
            counted(fit.missing, "sample")
        )));
    }
    findings
}

/// Events that were found and are none.
pub fn unconfirmed([steps, others]: [usize; 2]) -> Option<Finding> {
    let disturbed = plural(others, "spike or disturbed interval", "spikes or disturbed intervals");
    let both = [(steps, counted(steps, "step")), (others, format!("{others} {disturbed}"))];
    let what: Vec<String> =
        both.into_iter().filter(|(count, _)| *count > 0).map(|(_, words)| words).collect();
    let what = what.join(" and ");
    (!what.is_empty()).then(|| {
        Code::EventsNotConfirmed.said(format!(
            "the search found {what} that the final fit does not confirm (size below {CONFIRMED} standard uncertainties); not removed"
        ))
    })
}

pub fn third() -> Finding {
    Code::ThirdInstrument.said("the readings of the third instrument enter no regression of `fit`; they correct `matrix` for the attenuation by noise of the reference, and give the noise of each of the three in `three_cornered`")
}

fn drift(of: &Drift) -> Option<String> {
    let straight = || format!("by {:+} nT a day ({})", of.straight_nt_per_day, p_value(of.straight_p));
    let exponential = || {
        let joint = of.joint.as_ref()?;
        let [low, high] = joint.time_constant_interval_s.map(|end| significant(end, 3));
        let limit = if joint.time_constant_at_limit { ", at the limit of the search" } else { "" };
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

/// Probability of estimates so far apart, by the axes together or by one of them: twice and six times the
/// least.
pub fn p_of_one(test: &OneMatrix) -> f64 {
    let axes = test.axes.iter().map(|(_, axis)| 6.0 * axis.p);
    axes.fold(2.0 * test.p, f64::min).min(1.0)
}

/// What was found, with ± and units.
pub fn summary(document: &Document) -> String {
    let found = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let Some(fit) = found.and_then(|found| found.fit.as_ref()) else { return String::new() };
    let lead = if fit.answer.is_empty() { "diffmag:" } else { " " };
    let mut lines = Vec::new();
    if !fit.answer.is_empty() {
        lines.push(format!("diffmag: {}", fit.answer));
    }
    lines.push(format!(
        "{lead} \"{}\", {} of {} s",
        fit.recordings.join("\", \""),
        counted(fit.samples, "sample"),
        bare(fit.step_s)
    ));
    for axis in Axis::ALL {
        let elements = Axis::ALL.iter().filter_map(|from| fit.elements.get(&format!("{from}{axis}")));
        let row = elements.map(|element| signed(&uncertain(element.weighted, element.weighted_std)));
        let row: Vec<String> = row.collect();
        lines.push(format!("  test {axis} from the reference's x, y, z: {}", row.join(", ")));
    }
    for (axis, of) in fit.axes.iter() {
        let offset = found.and_then(|found| found.offset_nt.as_ref()?.get(axis));
        let (day, month) = (&of.drift.per_day, &of.drift.per_month);
        let per_day = day.as_ref().map_or(&of.drift.straight_nt_per_day, |day| &day.drift_nt);
        let per_month = month.as_ref().map(|month| format!(", {:+} nT a month", month.drift_nt));
        let density = &of.density_at_1hz_nt_per_sqrt_hz;
        lines.push(format!(
            "  test {axis}: offset {} nT, rms {} nT, {} pT/√Hz at 1 Hz, as 1/f^α with α = {}, drift {per_day:+} nT a day{}",
            offset.map_or("missing".into(), |offset| format!("{offset:+}")),
            significant(of.rms_nt, 3),
            uncertain(1e3 * density.value(), 1e3 * density.std().unwrap_or(0.0)),
            of.flicker_exponent,
            per_month.unwrap_or_default()
        ));
    }
    if let Some(clock) = &fit.clock {
        let words =
            |clock: &ClockDifference| format!("{}, {}", clock.offset_in_words(), clock.rate_in_words());
        lines.push(format!("  clock of the test instrument: {}", words(clock)));
        if let (Some(offset), Some(rate)) = (&clock.left_offset_s, &clock.left_rate_ppm) {
            let (offset_s, rate_ppm) = (offset.clone(), rate.clone());
            let left = ClockDifference { offset_s, rate_ppm, ..ClockDifference::default() };
            lines.push(format!("  corrected; left: {}", words(&left)));
        }
    }
    let of_reference = fit.reference_noise.as_ref();
    lines.extend(of_reference.into_iter().flat_map(reference_noise::lines).map(|line| format!("  {line}")));
    lines.extend(found.and_then(|found| found.fourteen.as_deref()).into_iter().flat_map(mutual));
    let of_reference = of_reference.map(|noise| &noise.findings[..]).unwrap_or_default();
    let moved = fit.stability.iter().flat_map(|stability| stability.findings.iter());
    let findings = fit.findings.iter().chain(of_reference).chain(moved);
    lines.extend(findings.map(|finding| format!("    {finding}")));
    lines.into_iter().map(|line| line + "\n").collect()
}

/// How the instruments stand to each other.
fn mutual(fourteen: &FourteenParameters) -> [String; 4] {
    let lead = match (fourteen.known, fourteen.assumed) {
        (_, true) => "if the reference is orthogonal with equal scale factors (assumed; see `known`):",
        (Magnetometer::Reference, false) => "with the known axes and scale factors of the reference:",
        (Magnetometer::Test, false) => "with the known axes and scale factors of the test instrument:",
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
    let ratios = fourteen.ratios.iter().filter(|(_, ratio)| ratio.std() != Some(0.0));
    let ratios = ratios.map(|(name, ratio)| format!("{} {ratio}", name.replace('_', "/")));
    let ratios: Vec<String> = ratios.collect();
    let (whose, own) = match fourteen.known {
        Magnetometer::Reference => ("test instrument", &fourteen.test_non_orthogonality_arcsec),
        Magnetometer::Test => ("reference", &fourteen.reference_non_orthogonality_arcsec),
    };
    let own: Vec<String> = own.iter().map(|(pair, angle)| format!("{pair} {angle:+}″")).collect();
    [
        format!("  {lead}"),
        format!("    {}", angles.join(", ")),
        format!("    scale factors {}", ratios.join(", ")),
        format!("    non-orthogonality of the {whose}: {}", own.join(", ")),
    ]
}
