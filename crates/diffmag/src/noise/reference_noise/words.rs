//! Sentences about noise of the reference.

use common::number::{figures, p_value, uncertain};
use common::{
    Axis, Code, Findings, OwnNoise, PerAxis, Quantity, ReferenceNoise, ReferenceNoiseSource, ThreeCornered,
};

/// Which interval to quote where the matrix is corrected.
pub fn quoted(from: ReferenceNoiseSource) -> String {
    let by = match from {
        ReferenceNoiseSource::ThirdInstrument => "with the third instrument",
        ReferenceNoiseSource::Declared => "with its declared noise",
        _ => "with its noise as estimated from the spectra",
    };
    format!(
        "`matrix` with `covariance`: noise of the reference biases least squares and the weighted elements toward zero; `matrix` is corrected for this bias (listed in `reference_noise.elements`) {by}"
    )
}

/// The share below which the pull is under half of each uncertainty.
fn harmless_share(report: &ReferenceNoise) -> f64 {
    let worst = report.elements.values().map(|element| element.largest_pull_over_std).fold(0.0, f64::max);
    0.5 / worst
}

/// Whose noise the difference is, and why.
pub fn ascribed(report: &ReferenceNoise, three: Option<&ThreeCornered>) -> String {
    if let Some(three) = three {
        return format!("noise of each instrument, separated with the third: {}", split(three));
    }
    let shares = report.share.as_ref().map(of_axes);
    match (report.known_from, shares) {
        (from @ (ReferenceNoiseSource::Declared | ReferenceNoiseSource::Spectrum), Some(shares)) => {
            let by =
                if from == ReferenceNoiseSource::Declared { "its declared noise" } else { "the spectra" };
            format!(
                "according to {by} the reference contributes {shares} of the power of the difference; the rest is attributed to the test instrument"
            )
        }
        _ => {
            let harmless = harmless_share(report);
            let enough = if harmless < 1.0 {
                format!(
                    "the bias of the matrix is below half of each uncertainty if the reference contributes less than {} % of \
                     that power",
                    figures(100.0 * harmless, 2)
                )
            } else {
                "whichever instrument it belongs to, the bias of the matrix is below half of each uncertainty"
                    .into()
            };
            format!(
                "the difference is attributed to the test instrument, because the noise of the reference is unknown and assumed to be the smaller: the noise stated for the test instrument is an upper bound, and {enough}"
            )
        }
    }
}

pub fn findings(report: &ReferenceNoise, three: Option<&ThreeCornered>, told_below: f64) -> Findings {
    let mut findings = Findings::default();
    let worst = |of: &dyn Fn(&common::PulledElement) -> f64| {
        report.elements.iter().map(|(name, element)| (name, of(element))).max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let pulled = |element: &common::PulledElement| element.pull.map_or(0.0, f64::abs) / element.pulled_std;
    match worst(&pulled) {
        Some((name, pull)) if pull > 0.5 => findings.push(Code::BiasedByReference.about(name).said(format!(
            "noise of the reference had biased the matrix by up to {} standard uncertainties ({name})",
            figures(pull, 2)
        ))),
        _ => {}
    }
    let corrected = report.elements.values().any(|element| element.corrected.is_some());
    if !corrected && report.known_from == ReferenceNoiseSource::Declared {
        findings.push(
            Code::FieldTooQuiet.said("the declared noise of the reference is more than half the variance of its readings along some direction, or the corrected matrix fits worse than offsets alone. The field varied too little and the matrix is not corrected: record when the field is more active"),
        );
    } else if !corrected
        && let Some((name, most)) = worst(&|element| element.largest_pull_over_std)
        && most > 0.5
    {
        findings.push(Code::PossiblyBiasedByReference.about(name).said(format!(
            "noise of the reference may have biased the matrix by up to {} standard uncertainties ({name}); declare it in \
             `conditions.reference_noise`, or record a third instrument as `third_x_nt`, …",
            figures(most, 2)
        )));
    }
    if let Some(spectrum) = &report.in_spectrum {
        let told = spectrum.p < told_below;
        if spectrum.used {
            findings.push(
                Code::NoiseOfReference.said("the coefficients decrease where the field varies little, as expected of noise of the reference; a test instrument with a weaker response to fast changes would look nearly the same"),
            );
        } else if told && report.known_from == ReferenceNoiseSource::Unknown {
            findings.push(Code::ResponsesDiffer.said(format!(
                "the coefficients decrease where the field varies little, but not as expected of noise of the reference ({}): the responses of the two instruments differ with frequency",
                p_value(spectrum.consistency_p)
            )));
        }
    }
    if let Some(three) = three.filter(|three| three.goodness_p < told_below) {
        findings.push(Code::NoisesNotIndependent.said(format!(
            "the noises of the three instruments are not independent, or not of the form A/f^α plus white ({}): two of them share a disturbance, and their separation is unreliable",
            p_value(three.goodness_p)
        )));
    }
    findings
}

pub fn lines(report: &ReferenceNoise) -> Vec<String> {
    let own = report.test.as_ref();
    let own = own.map(|test| format!("the test instrument's own noise: {}", of_instrument(test)));
    std::iter::once(report.ascribed.clone()).chain(own).collect()
}

fn split(three: &ThreeCornered) -> String {
    let all = [("reference", &three.reference), ("test instrument", &three.test), ("third", &three.third)];
    all.map(|(name, noise)| format!("{name} {}", of_instrument(noise))).join("; ")
}

/// White noise and density at 1 Hz of the three axes.
fn of_instrument(noise: &PerAxis<OwnNoise>) -> String {
    let of = |unit: &str, factor: f64, value: &dyn Fn(&OwnNoise) -> (f64, f64)| {
        let each = Axis::ALL.iter().filter_map(|axis| noise.get(*axis)).map(|own| {
            let (value, high) = value(own);
            if value > 0.0 { figures(factor * value, 2) } else { format!("< {}", figures(factor * high, 2)) }
        });
        format!("{} {unit}", each.collect::<Vec<_>>().join(", "))
    };
    let white = |own: &OwnNoise| (own.white_rms_nt.value(), own.white_interval_nt[1]);
    let flicker =
        |own: &OwnNoise| (own.density_at_1hz_nt_per_sqrt_hz.value(), own.density_interval_nt_per_sqrt_hz[1]);
    format!("{} white, {} at 1 Hz (x, y, z)", of("nT", 1.0, &white), of("pT/√Hz", 1e3, &flicker))
}

fn of_axes(shares: &PerAxis<Quantity>) -> String {
    let percent = |share: &Quantity| uncertain(100.0 * share.value(), 100.0 * share.std().unwrap_or(0.0));
    let each: Vec<String> = Axis::ALL.iter().filter_map(|axis| shares.get(*axis)).map(percent).collect();
    format!("{} % (x, y, z)", each.join(", "))
}
