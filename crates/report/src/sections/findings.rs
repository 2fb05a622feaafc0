//! What looks wrong, section by section, each finding with what it does to the result by numbers that the
//! document holds: the modules below have a function of its code for each part of a document. None: the document does
//! not hold what would tell.

mod absolute;
mod axes;
mod differential;
mod sensors;

use common::{
    AxesCalibration, Code, DifferentialCalibration, Document, Findings, PerAxis, Residual, SensorCalibration,
};

use super::recordings;
use crate::{Effect, Finding, number};

/// Findings about a part of a document, each led by whose it is.
fn findings<T>(
    whose: &str,
    said: &Findings,
    part: &T,
    effect: fn(&T, Code, &str) -> Option<Effect>,
) -> Vec<Finding> {
    let lead = if whose.is_empty() { String::new() } else { format!("{whose}: ") };
    let all = said.coded().map(|(words, code, about)| {
        let effect = code.and_then(|code| effect(part, code, about));
        Finding::of(format!("{lead}{words}"), effect.unwrap_or(Effect::NOT_HELD))
    });
    all.collect()
}

/// The largest of some numbers in size; None of none.
fn largest(all: impl IntoIterator<Item = f64>) -> Option<f64> {
    all.into_iter().map(f64::abs).filter(|size| size.is_finite()).reduce(f64::max)
}

pub fn of(section: &str, document: &Document) -> Vec<Finding> {
    let calibration = document.calibration.as_ref();
    match section {
        "coils" => {
            let all = calibration.iter().flat_map(|found| &found.coils).flat_map(PerAxis::iter);
            let fits = all.filter_map(|(axis, coil)| Some((axis, coil, coil.constant.as_ref()?)));
            let said = fits.map(|(axis, coil, fit)| {
                findings(&format!("coil {axis}"), &fit.findings, coil, sensors::coil)
            });
            said.flatten().collect()
        }
        "sensors" => [of_sensors("sensors", document), of_sensors("reversals", document)].concat(),
        "noise" | "drift" | "temperature" | "cross-field" => of_sensors(section, document),
        "axes" => {
            let axes = calibration.iter().flat_map(|found| &found.axes);
            axes.flat_map(|axes| std::iter::once(axes).chain(axes.subset.as_deref()))
                .flat_map(of_axes)
                .collect()
        }
        "scalar" => {
            let all = calibration.iter().flat_map(|found| &found.scalar);
            all.flat_map(|scalar| findings("", &scalar.findings, &**scalar, axes::scalar)).collect()
        }
        "absolute" => absolute::all(document),
        "flight" => {
            let all = calibration.iter().flat_map(|found| &found.flight);
            all.flat_map(|flight| {
                findings("", &flight.findings, &**flight, |_, code, _| Some(Effect::Unstated(code.effect())))
            })
            .collect()
        }
        "differential" => {
            let all = calibration.iter().flat_map(|found| &found.differential);
            all.flat_map(of_difference).collect()
        }
        "diagnosis" => of_diagnosis(document),
        "corrected" => recordings::flagged(document),
        _ => Vec::new(),
    }
}

/// The findings on a part of each sensor, where it was found.
fn of_sensors(part: &str, document: &Document) -> Vec<Finding> {
    fn said<'a>(part: &str, sensor: &'a SensorCalibration) -> Option<&'a Findings> {
        Some(match part {
            "sensors" => &sensor.sensitivity.as_ref()?.findings,
            "reversals" => &sensor.reversal.as_ref()?.findings,
            "noise" => &sensor.noise.as_ref()?.findings,
            "drift" => &sensor.drift.as_ref()?.findings,
            "temperature" => &sensor.temperature.as_ref()?.findings,
            _ => &sensor.cross_field.as_ref()?.findings,
        })
    }
    let of = if part == "reversals" { ", reversals" } else { "" };
    let all = document.calibration.iter().flat_map(|found| &found.sensors).flat_map(PerAxis::iter);
    let all = all.filter_map(|(axis, sensor)| {
        Some(findings(&format!("sensor {axis}{of}"), said(part, sensor)?, sensor, sensors::sensor))
    });
    all.flatten().collect()
}

fn of_axes(axes: &AxesCalibration) -> Vec<Finding> {
    let doubtful = axes.doubtful.iter().map(|one| {
        let words = format!(
            "orientation {} (\"{}\", row {}), coil {}, sensor {}: {} nT from the prediction of the others (p = {})",
            one.orientation,
            one.recording,
            one.row,
            one.coil,
            one.sensor,
            number::figures(one.leave_one_out_nt, 4),
            number::probability(one.p_adjusted)
        );
        Finding::of(words, axes::doubtful(axes, one).unwrap_or(Effect::NOT_HELD))
    });
    findings("", &axes.findings, axes, axes::directions).into_iter().chain(doubtful).collect()
}

fn of_difference(found: &DifferentialCalibration) -> Vec<Finding> {
    let Some(fit) = found.fit.as_deref() else { return Vec::new() };
    let stability = fit.stability.as_ref().filter(|_| found.matrix.is_some());
    let parts = [
        Some(&fit.findings),
        stability.map(|stability| &stability.findings),
        fit.reference_noise.as_ref().map(|noise| &noise.findings),
    ];
    parts.into_iter().flatten().flat_map(|said| findings("", said, fit, differential::difference)).collect()
}

fn of_diagnosis(document: &Document) -> Vec<Finding> {
    let each = document.diagnosis.iter().flatten().flat_map(|diagnosis| {
        let fit = diagnosis.fit.as_ref();
        let remaining = diagnosis.remaining.as_ref().filter(|remaining| !remaining.white).map(|remaining| {
            let words = format!("The residuals are not noise alone: {}", remaining.structure);
            // What the noise does not explain.
            let beyond =
                |fit: &Residual| (fit.rms_after_nt.powi(2) - fit.noise_floor_nt.powi(2)).max(0.0).sqrt();
            Finding::of(words, Effect::nt(fit.map(beyond)))
        });
        // A fit that leaves more than there was.
        let absurd = fit.filter(|fit| fit.is_absurd()).map(|fit| {
            let [before, refitted, after] = [fit.rms_before_nt, fit.rms_refitted_nt, fit.rms_after_nt]
                .map(|rms| number::significant(rms, 3));
            let words = format!(
                "The fit increases the residual: rms {before} nT with the stated calibration, {refitted} nT after refitting it, {after} nT with the effects found. Do not use it."
            );
            Finding::of(words, Effect::nt(fit.rms_refitted_nt.max(fit.rms_after_nt) - fit.rms_before_nt))
        });
        absurd.into_iter().chain(remaining)
    });
    each.collect()
}
