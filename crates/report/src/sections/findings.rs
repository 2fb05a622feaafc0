//! What looks wrong, section by section, each finding with what it does to the result.

use common::{AxesCalibration, DifferentialCalibration, Document, PerAxis, Residual, SensorCalibration};

use super::effects::{axes, differential, findings, sensors};
use super::recordings;
use crate::{Effect, Finding, number};

/// The findings of a section.
pub fn of(section: &str, document: &Document) -> Vec<Finding> {
    let calibration = document.calibration.as_ref();
    // The findings on a part of each sensor, where it was found.
    let each = |of: &dyn Fn(&str, &SensorCalibration) -> Option<Vec<Finding>>| -> Vec<Finding> {
        let all = calibration.iter().flat_map(|found| &found.sensors).flat_map(PerAxis::iter);
        all.filter_map(|(axis, sensor)| of(&format!("sensor {axis}"), sensor)).flatten().collect()
    };
    let one = |of: &dyn Fn(&common::Calibration) -> Option<Vec<Finding>>| -> Vec<Finding> {
        calibration.and_then(of).unwrap_or_default()
    };
    match section {
        "coils" => {
            let all = calibration.iter().flat_map(|found| &found.coils).flat_map(PerAxis::iter);
            let fits = all.filter_map(|(axis, coil)| Some((axis, coil, coil.constant.as_ref()?)));
            let said = fits.map(|(axis, coil, fit)| {
                findings(&format!("coil {axis}"), &fit.findings, &sensors::COIL, coil)
            });
            said.flatten().collect()
        }
        "sensors" => {
            let mut all = each(&|name, sensor| {
                let fit = sensor.sensitivity.as_ref()?;
                Some(findings(name, &fit.findings, &sensors::SENSITIVITY, sensor))
            });
            all.extend(each(&|name, sensor| {
                let fit = sensor.reversal.as_deref()?;
                Some(findings(&format!("{name}, reversals"), &fit.findings, &sensors::REVERSAL, fit))
            }));
            all
        }
        "noise" => {
            each(&|name, sensor| Some(findings(name, &sensor.noise.as_ref()?.findings, &sensors::NOISE, &())))
        }
        "drift" => each(&|name, sensor| {
            let drift = sensor.drift.as_deref()?;
            Some(findings(name, &drift.findings, &sensors::DRIFT, drift))
        }),
        "temperature" => each(&|name, sensor| {
            let fit = sensor.temperature.as_deref()?;
            Some(findings(name, &fit.findings, &sensors::TEMPERATURE, fit))
        }),
        "cross-field" => each(&|name, sensor| {
            let fit = sensor.cross_field.as_deref()?;
            Some(findings(name, &fit.findings, &sensors::CROSS_FIELD, fit))
        }),
        "axes" => one(&|found| {
            let axes = found.axes.as_ref()?;
            Some([Some(axes), axes.subset.as_deref()].into_iter().flatten().flat_map(of_axes).collect())
        }),
        "scalar" => one(&|found| {
            let scalar = found.scalar.as_deref()?;
            Some(findings("", &scalar.findings, &axes::SCALAR, scalar))
        }),
        "differential" => one(&|found| found.differential.as_ref().and_then(of_difference)),
        "diagnosis" => of_diagnosis(document),
        "corrected" => recordings::flagged(document),
        _ => Vec::new(),
    }
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
        Finding::of(words, axes::doubtful(axes, one))
    });
    findings("", &axes.findings, &axes::RULES, axes).into_iter().chain(doubtful).collect()
}

fn of_difference(found: &DifferentialCalibration) -> Option<Vec<Finding>> {
    let fit = found.fit.as_ref()?;
    let mut all = differential::of_fit(fit);
    if let Some(stability) = fit.stability.as_ref().filter(|_| found.matrix.is_some()) {
        all.extend(findings("", &stability.findings, &differential::STABILITY, stability));
    }
    if let Some(noise) = &fit.reference_noise {
        all.extend(findings("", &noise.findings, &differential::REFERENCE, noise));
    }
    Some(all)
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
        fit.and_then(absurd).into_iter().chain(remaining)
    });
    each.collect()
}

/// That a fit leaves more than there was.
fn absurd(fit: &Residual) -> Option<Finding> {
    fit.is_absurd().then(|| {
        let words = format!(
            "The fit increases the residual: rms {} nT with the stated calibration, {} nT after refitting it, {} nT with the effects found. Do not use it.",
            number::significant(fit.rms_before_nt, 3),
            number::significant(fit.rms_refitted_nt, 3),
            number::significant(fit.rms_after_nt, 3)
        );
        Finding::of(words, Effect::nt(fit.rms_refitted_nt.max(fit.rms_after_nt) - fit.rms_before_nt))
    })
}
