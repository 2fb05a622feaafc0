//! How it was calibrated: the laboratory's procedure, its sources, the programs and the document.

use common::{Certificate, Document};

use crate::Asked;
use crate::sheet::Sheet;

const NASA: &str = "NASA CR-156638: R. L. McPherron, A Procedure for Accurate Calibration of the Orientation of the Three Sensors in a Vector \
                    Magnetometer, June 1977";
const MERAYO: &str = "J. M. G. Merayo et al., Scalar calibration of vector magnetometers, Meas. Sci. Technol. 11 (2000) 120–132";
const DIFFERENTIAL: &str = "Comparison with a reference magnetometer in one field, T = R η + d";
const GUM: &str = "Uncertainties: JCGM 100:2008 (GUM)";

/// Method, sampling and deviations.
pub fn part(sheet: &mut Sheet, document: &Document, data: &Certificate, asked: &Asked<'_>) {
    sheet.begin("Method", "7.8.2.1 f, k, n, 7.8.4.2");
    let method = data.method.as_ref();
    sheet.required("Procedure", "7.8.2.1 f", method.and_then(|method| method.procedure.as_deref()));
    sheet.required("Version", "7.8.2.1 f", method.and_then(|method| method.version.as_deref()));
    sheet.required("Sources", "7.8.2.1 f", Some(&sources(document).join("\n")));
    sheet.required("Evaluated by", "7.8.2.1 f", Some(&programs(document).join("\n")));
    let digest = |of: &str, sha256: Option<&str>| sha256.map(|hash| format!("{of}: {hash}"));
    let digests = [
        digest("document", asked.document_sha256),
        digest("administrative data beside it", asked.data_sha256),
        digest("specification", asked.spec.and_then(|(_, hash)| hash)),
    ];
    let digests: Vec<String> = digests.into_iter().flatten().collect();
    sheet.required("SHA-256", "7.8.2.1 f", Some(&digests.join("\n")));
    sheet.stated("Additions, deviations, exclusions", "7.8.2.1 n", data.deviations.as_deref());
    sheet.stated("Sampling plan and method", "7.8.2.1 k", data.sampling.as_deref());
    sampled(sheet, data);
}

/// What the laboratory sampled: nothing, where there is neither plan nor method.
fn sampled(sheet: &mut Sheet, data: &Certificate) {
    let no_plan = data.sampling.as_ref().is_some_and(|plan| plan.trim().is_empty());
    let all = data.sampled.as_deref().or(no_plan.then_some(&[]));
    if all.is_none_or(<[_]>::is_empty) {
        sheet.listed("Sampling by the laboratory", "7.8.4.2", all.map(|_| &[][..]));
    }
    for one in all.into_iter().flatten() {
        for (label, clause, text) in [
            ("Sampled on", "7.8.5 a", &one.date),
            ("Sampled item", "7.8.5 b", &one.item),
            ("Place of the sampling", "7.8.5 c", &one.location),
            ("Plan and method of the sampling", "7.8.5 d", &one.method),
            ("Conditions during the sampling", "7.8.5 e", &one.conditions),
            ("For the uncertainty of later results", "7.8.5 f", &one.uncertainty),
        ] {
            sheet.stated(label, clause, text.as_deref());
        }
    }
}

/// What the procedures follow, by what stands in the document.
fn sources(document: &Document) -> Vec<&'static str> {
    let Some(calibration) = &document.calibration else { return vec![GUM] };
    let coils = calibration.coils.iter().flat_map(|coils| coils.iter());
    let coils = coils.into_iter().any(|(_, coil)| coil.constant.is_some() || !coil.surveys.is_empty());
    let sensors = calibration.sensors.iter().flat_map(|sensors| sensors.iter());
    let sensors = sensors.into_iter().any(|(_, one)| {
        one.sensitivity.is_some()
            || one.reversal.is_some()
            || one.noise.is_some()
            || one.drift.is_some()
            || one.temperature.is_some()
            || one.cross_field.is_some()
    });
    let axes = calibration.axes.as_ref().is_some_and(|axes| axes.fit.is_some());
    let all = [
        (coils || sensors || axes, NASA),
        (calibration.scalar.is_some(), MERAYO),
        (calibration.differential.is_some(), DIFFERENTIAL),
        (true, GUM),
    ];
    all.into_iter().filter(|(there, _)| *there).map(|(_, source)| source).collect()
}

/// The programs with version and arguments, this one last.
fn programs(document: &Document) -> Vec<String> {
    let entry = |entry: &common::HistoryEntry| {
        let words = format!("fluxcal {} {} {}", entry.stage, entry.version, entry.arguments.join(" "));
        words.trim_end().to_string()
    };
    let this = format!("fluxcal report {} (this certificate)", env!("CARGO_PKG_VERSION"));
    document.history.iter().map(entry).chain([this]).collect()
}
