//! Coverage of a lag, of extrema of temperature, and of the error budget (FLUXCAL_CAMPAIGNS campaigns).

use common::{Axis, Document, Quantity};
use noise::Stream;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::build::{self, each, of};

/// A sensor or several in a coil; what varies is put in.
fn plan(seed: u64, sensors: &[&str], effects: Vec<Value>, procedures: Value) -> Value {
    let mut plan = build::plan(seed, sensors, &json!({"white_rms_nt": 0.1}), effects, procedures);
    plan["truth"]["offset_wander"] = json!({"white_rms_nt": 0.15});
    plan
}

fn calibrated(plan: &Value) -> Document {
    build::calibrated(build::simulated(plan).document)
}

/// One sensor, a lag of its offset, and a temperature that is followed on its way.
fn lagging(seed: u64, coefficient: f64, lag_s: f64) -> Value {
    let lag = json!({"effect": "offset_temperature_lag", "sensor": "x",
        "parameters": {"coefficient_nt_per_k": coefficient, "lag_s": lag_s}});
    let run = json!([{"procedure": "temperature_run", "id": "run", "parts": ["sensor"],
        "deviations_k": [0, 15, 0], "monitor_s": 30}]);
    plan(seed, &["x"], vec![lag], run)
}

/// Whether a 95 % interval holds the truth, with a factor for those that do not state one.
fn holds(quantity: &Quantity, truth: f64, factor: f64) -> bool {
    let factor = quantity.coverage_factor_95().unwrap_or(factor);
    (quantity.value() - truth).abs() <= factor * quantity.std().expect("a std")
}

/// Asserts that a share agrees with 93 % to `most`.
#[track_caller]
fn within(name: &str, held: &[bool], most: f64) {
    let outside = build::outside(name, held, [0.93, most], 1);
    assert!(outside.is_none(), "{}", outside.unwrap_or_default());
}

#[test]
fn a_lag_covers() {
    let truth = [0.08, 700.0];
    let run = |seed: u64| {
        let found = calibrated(&lagging(seed, truth[0], truth[1]));
        let fit = of(&found, Axis::X).temperature.as_ref().expect("temperatures");
        let part = fit.sensor.as_ref().expect("the sensor");
        let factor = fit.noise.coverage_factor_95;
        let lag = part.lag_s.as_ref()?;
        Some([holds(lag, truth[1], factor), holds(&part.offset_nt_per_k, truth[0], factor)])
    };
    let count = testkit::campaigns(40);
    let all: Vec<[bool; 2]> = (0..count).into_par_iter().filter_map(run).collect();
    // A lag is found in nearly all: what is counted is not chosen by what was found.
    assert!(all.len() as f64 > 0.98 * count as f64, "a lag in {} of {count}", all.len());
    within("lag", &all.iter().map(|held| held[0]).collect::<Vec<_>>(), 0.97);
    within("coefficient behind it", &all.iter().map(|held| held[1]).collect::<Vec<_>>(), 0.97);
}

#[test]
fn a_lag_that_is_excluded_is_not_there() {
    let truth_s = 60.0;
    let run = |seed: u64| {
        let found = calibrated(&lagging(seed, 0.02, truth_s));
        let part = of(&found, Axis::X).temperature.as_ref()?.sensor.as_ref()?;
        let words = part.lag.split("offset: no lag was detected; more than ").nth(1)?;
        words.split_once(" s is excluded")?.0.parse::<f64>().ok()
    };
    let all: Vec<f64> = (0..testkit::campaigns(40)).into_par_iter().filter_map(run).collect();
    assert!(!all.is_empty(), "no lag was detected in some");
    within("excluded", &all.iter().map(|excluded| *excluded >= truth_s).collect::<Vec<_>>(), 1.0);
}

#[test]
fn common_extrema_cover() {
    // c = −2 q (T₀ − 23 degC): all three stand still at 33 degC, more or less clearly.
    let at_c = 33.0;
    let run = |seed: u64| {
        let effect = |axis: &str, curvature: f64| {
            json!({"effect": "offset_temperature", "sensor": axis, "parameters":
                {"coefficient_nt_per_k": -2.0 * curvature * (at_c - 23.0), "curvature_nt_per_k2": curvature}})
        };
        let effects = vec![effect("x", 0.002), effect("y", -0.0012), effect("z", 0.0006)];
        let run = json!([{"procedure": "temperature_run", "id": "run", "parts": ["sensor"]}]);
        let found = calibrated(&plan(seed, &["x", "y", "z"], effects, run));
        let own = Axis::ALL.map(|axis| {
            let fit = of(&found, axis).temperature.as_ref().expect("temperatures");
            let part = fit.sensor.as_ref().expect("the sensor");
            part.extrema_c.get("offset").map(|at| holds(at, at_c, fit.noise.coverage_factor_95))
        });
        let common = &found.calibration.as_ref().expect("a calibration").common_extrema;
        let common = common.iter().find(|one| one.part == "sensor" && one.quantity == "offset");
        (own, common.map(|one| holds(&one.temperature_c, at_c, 1.96)))
    };
    let all: Vec<_> = (0..testkit::campaigns(40)).into_par_iter().map(run).collect();
    for axis in Axis::ALL {
        let held: Vec<bool> = all.iter().filter_map(|(own, _)| own[axis.index()]).collect();
        within(&format!("extremum of sensor {axis}"), &held, 0.97);
    }
    within("common extremum", &all.iter().filter_map(|(_, common)| *common).collect::<Vec<_>>(), 0.97);
}

/// Terms of the error budget beside the field that a sensor with the true constants would be taken to see.
#[test]
fn the_error_budget_covers() {
    // ppm/K, ppm/K², nT/K, nT/K² of the sensor; nT of squares across, and of the sensitivity with them.
    let (thermal, cross) = ([28.0, 0.3, 0.05, 0.002], [1.5, 0.8, 0.6, -0.5]);
    let run = |seed: u64| {
        let effect = |name: &str, values: Value| json!({"effect": name, "sensor": "x", "parameters": values});
        let effects = vec![
            effect(
                "sensitivity_temperature",
                json!({"coefficient_ppm_per_k": thermal[0], "curvature_ppm_per_k2": thermal[1]}),
            ),
            effect(
                "offset_temperature",
                json!({"coefficient_nt_per_k": thermal[2], "curvature_nt_per_k2": thermal[3]}),
            ),
            effect("cross_field", json!({"first_nt": cross[0], "second_nt": cross[1], "mixed_nt": 0.0})),
            effect("cross_field_sensitivity", json!({"first_nt": cross[2], "second_nt": cross[3]})),
        ];
        let procedures = json!([
            {"procedure": "sensor_sensitivity", "id": "sensitivity"},
            {"procedure": "sensor_offset_reversal", "id": "reversal"},
            {"procedure": "temperature_run", "id": "temperature", "parts": ["sensor"]},
            {"procedure": "cross_field", "id": "cross", "levels_nt": [-60000, -20000, 0, 20000, 60000], "to_nt": 50000, "steps": 7},
            {"procedure": "offset_drift", "id": "drift", "pairs": 6},
            {"procedure": "sensor_noise", "id": "noise", "series": [{"length_s": 1800, "step_s": 1}, {"length_s": 40, "step_s": 0.02}]}
        ]);
        let mut plan = plan(seed, &["x"], effects, procedures);
        let stated = json!({"constant_nt_per_a": {"value": 41000.0, "std": 0.05}, "offset_nt": {"value": 0.0, "std": 0.02}});
        let mut stream = Stream::new(seed, "truth");
        let coil = json!({"constant_nt_per_a": 41000.0 + 0.05 * stream.normal(), "offset_nt": 0.02 * stream.normal()});
        plan["calibration"]["coils"] = each(&stated);
        plan["truth"]["calibration"] = json!({"coils": each(&coil)});
        let found = calibrated(&plan);
        let found = of(&found, Axis::X);
        let value = |quantity: &Option<Quantity>| quantity.as_ref().expect("a quantity").value();
        let part = found.temperature.as_ref().and_then(|fit| fit.sensor.as_ref()).expect("the sensor");
        let across = found.cross_field.as_ref().expect("transverse fields");
        let fitted = [
            part.sensitivity_ppm_per_k.value(),
            value(&part.sensitivity_ppm_per_k2),
            part.offset_nt_per_k.value(),
            value(&part.offset_nt_per_k2),
        ];
        let adds = |field: f64, warmer: f64, thermal: [f64; 4], cross: [f64; 4]| {
            let by_temperature = field * 1e-6 * (thermal[0] * warmer + thermal[1] * warmer * warmer)
                + thermal[2] * warmer
                + thermal[3] * warmer * warmer;
            by_temperature + cross[0] + cross[1] + field / 50_000.0 * (cross[2] + cross[3])
        };
        let seen = ["first_nt", "second_nt"];
        let offset = seen.map(|name| across.offset[name].value());
        let scale = seen.map(|name| across.sensitivity[name].value());
        let (k, o) = (value(&found.sensitivity_nt_per_v), value(&found.offset_nt));
        let each = found.budget.iter().map(|budget| {
            let (field, warmer) = (budget.field_nt, budget.warmer_k);
            let noise = 0.1 * stream.normal() + 0.15 * stream.normal();
            let volts = (field + adds(field, warmer, thermal, cross) + noise - 0.3) / 6400.0;
            let corrected =
                k * volts + o - adds(field, warmer, fitted, [offset[0], offset[1], scale[0], scale[1]]);
            (format!("{field} nT, {warmer} K"), (corrected - field).abs() <= 1.96 * budget.standard_nt)
        });
        each.collect::<Vec<_>>()
    };
    let all: Vec<Vec<(String, bool)>> = (0..testkit::campaigns(40)).into_par_iter().map(run).collect();
    for which in 0..all[0].len() {
        let held: Vec<bool> = all.iter().map(|each| each[which].1).collect();
        within(&format!("budget at {}", all[0][which].0), &held, 0.97);
    }
}
