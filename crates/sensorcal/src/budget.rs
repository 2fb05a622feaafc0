//! What a measured field is uncertain by (JCGM 100), with the report's worst case beside it (NASA eq. 16).

use common::covariance::{between, matrix};
use common::{BudgetTerm, ErrorBudget, SensorCalibration};

use crate::Options;
use crate::conditions::Conditions;
use crate::sensitivity::Constants;

/// Where coefficients of temperature are known, the budget is also made so far from the reference, K.
const WARMER_K: f64 = 10.0;
/// Size of a field across for which the budget holds, nT.
const ACROSS_NT: f64 = 50_000.0;
/// Lowest and highest frequency of the noise of a reading: a day, and a reading each second.
const BAND_HZ: [f64; 2] = [1.0 / 86_400.0, 0.5];

/// One budget for each field and temperature that is asked for, of a sensor as the document has it.
pub fn budget(
    sensor: &SensorCalibration,
    constants: &Constants,
    conditions: &Conditions,
    options: &Options,
) -> Vec<ErrorBudget> {
    let largest = constants.largest_nt;
    let fields = if options.budget_field_nt.is_empty() {
        vec![0.0, largest / 2.0, largest]
    } else {
        options.budget_field_nt.clone()
    };
    let warmer = match (options.budget_warmer_k.as_slice(), conditions.effects.is_empty()) {
        ([], true) => vec![0.0],
        ([], false) => vec![0.0, WARMER_K],
        (asked, _) => asked.to_vec(),
    };
    let all = warmer.iter().flat_map(|warmer| fields.iter().map(move |field| (*field, *warmer)));
    all.map(|(field, warmer_k)| one(sensor, constants, conditions, field, warmer_k)).collect()
}

fn one(
    sensor: &SensorCalibration,
    constants: &Constants,
    conditions: &Conditions,
    field: f64,
    warmer_k: f64,
) -> ErrorBudget {
    let mut all: Vec<(&str, f64)> = Vec::new();
    let reading = field / constants.sensitivity;
    // As the document has it, where it has one.
    let [[kk, ko], [_, oo]] = match sensor.covariance.as_deref() {
        Some([first, second]) => [[first[0], first[1]], [second[0], second[1]]],
        _ => constants.covariance,
    };
    let common = reading.abs() * constants.common[0][0].sqrt();
    let joint = reading * reading * kk;
    all.push(("coil constant (common)", common.min(joint.sqrt())));
    all.push(("sensitivity (scatter)", (joint - common * common).max(0.0).sqrt()));
    all.push(("offset", oo.sqrt()));
    for (kind, size) in &constants.nonlinearity {
        let power = if *kind == physics::Kind::QuadraticNonlinearity { 2 } else { 3 };
        let share = (field / ACROSS_NT).powi(power).abs();
        all.push(("nonlinearity", share * size.std().unwrap_or(0.0)));
    }
    if warmer_k != 0.0 && !conditions.effects.is_empty() {
        all.push(("temperature coefficients", temperature(conditions, field, warmer_k)));
    }
    if let Some(noise) = &sensor.noise {
        let measured = crate::noise::as_noise(noise);
        all.push(("noise of a reading", measured.rms_nt(1.0 / BAND_HZ[0], 0.5 / BAND_HZ[1])));
        let code = noise.series.iter().filter_map(|series| series.code_nt).reduce(f64::max);
        all.extend(code.map(|code| ("rounding", code / 12f64.sqrt())));
    }
    if let Some(cross) = &sensor.cross_field {
        let share = |key: &str| if key.starts_with("sensitivity.") { field / ACROSS_NT } else { 1.0 };
        let by: Vec<f64> = cross.covariance_order.iter().map(|key| share(key)).collect();
        let variance = between(&matrix(&cross.covariance), &by, &by);
        all.push(("transverse field of 50000 nT", variance.max(0.0).sqrt()));
    }
    if let Some(drift) = &sensor.drift {
        all.push(("offset drift in a year", drift.own_rms_nt));
    }
    if let Some(reversal) = &sensor.reversal {
        // A bound, as a rectangular distribution.
        all.push(("turn of the reversals", reversal.imperfect_turn.bound_nt / 3f64.sqrt()));
    }
    let together = 2.0 * reading * ko;
    let variance = (all.iter().map(|(_, std)| std * std).sum::<f64>() + together).max(0.0);
    let worst_case_nt = all.iter().map(|(_, std)| 2.0 * std).sum();
    let term = |(term, std_nt): (&str, f64)| {
        let share = std_nt * std_nt / variance;
        BudgetTerm { term: term.into(), std_nt, share }
    };
    let mut terms: Vec<BudgetTerm> = all.into_iter().filter(|(_, std)| *std > 0.0).map(term).collect();
    terms.sort_by(|a, b| b.std_nt.total_cmp(&a.std_nt));
    ErrorBudget { field_nt: field, warmer_k, standard_nt: variance.sqrt(), worst_case_nt, terms }
}

/// Standard uncertainty of what a temperature adds: the sensor's and the electronics' alike.
fn temperature(conditions: &Conditions, field: f64, warmer_k: f64) -> f64 {
    let infos = conditions.effects.iter().flat_map(|effect| effect.kind.parameters());
    let by = infos.map(|info| {
        let scale = if info.name.contains("ppm") { field * 1e-6 } else { 1.0 };
        match info.name {
            name if name.ends_with("per_k") => scale * warmer_k,
            name if name.ends_with("per_k2") => scale * warmer_k * warmer_k,
            // In equilibrium a lag has no part.
            _ => 0.0,
        }
    });
    let by: Vec<f64> = by.collect();
    conditions.variance(&by).max(0.0).sqrt()
}
