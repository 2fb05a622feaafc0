//! What statements of conformity say of simulated campaigns, against the same statement of the truth.
//! FLUXCAL_CAMPAIGNS sets how many, FLUXCAL_FIRST the seed of the first. The programs must be built.

use common::{Axis, Document};
use report::conformity::Spec;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The plan with another seed, less what no requirement here rests on; the truth.
fn campaign(seed: u64) -> (Document, Value) {
    let mut plan: Value = serde_json::from_str(&testkit::read_fixture("plans/magsat.json")).expect("JSON");
    plan["seed"] = seed.into();
    let procedures = plan["procedures"].as_array_mut().expect("a list");
    let needed =
        "coil_constant sensor_sensitivity sensor_noise offset_drift temperature_run axes_orientation";
    procedures.retain(|procedure| needed.split(' ').any(|needed| procedure["procedure"] == needed));
    let plan = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    let simulate::Campaign { document, truth, .. } = simulate::campaign(&plan).expect("simulated");
    (document, serde_json::to_value(truth).expect("JSON"))
}

/// The document that the programs beside this one make of another.
fn calibrated(document: &Document) -> Document {
    testkit::stages(env!("CARGO_BIN_EXE_report"), &["coilcal", "sensorcal", "axescal"], document)
}

/// A document with what is true in the place of what was found.
fn true_of(found: &Document, truth: &Value) -> Document {
    let mut document = serde_json::to_value(found).expect("JSON");
    document["calibration"]["axes"]["sensors"]["matrix"] =
        truth["calibration"]["axes"]["sensors"]["matrix"].clone();
    let effects = truth["model"]["effects"].as_array().expect("effects");
    for axis in ["x", "y", "z"] {
        let of = |name: &str, parameter: &str| {
            let own = effects.iter().find(|effect| effect["effect"] == name && effect["sensor"] == axis);
            own.map_or(json!(0.0), |effect| effect["parameters"][parameter].clone())
        };
        let sensor = &mut document["calibration"]["sensors"][axis];
        for (part, sensitivity, offset) in [
            ("sensor", "sensitivity_temperature", "offset_temperature"),
            ("electronics", "sensitivity_electronics_temperature", "offset_electronics_temperature"),
        ] {
            let fit = &mut sensor["temperature"][part];
            fit["sensitivity_ppm_per_k"] = of(sensitivity, "coefficient_ppm_per_k");
            fit["sensitivity_ppm_per_k2"] = of(sensitivity, "curvature_ppm_per_k2");
            fit["offset_nt_per_k"] = of(offset, "coefficient_nt_per_k");
            fit["offset_nt_per_k2"] = of(offset, "curvature_nt_per_k2");
        }
        // An offset that ages moves the field that is read, by so much a day.
        let ageing = of("ageing", "rate_nt_per_day").as_f64().expect("a rate");
        sensor["drift"]["trend_nt_per_year"] = json!({"value": ageing * 365.25, "std": 0.0});
        sensor["drift"]["annual"] = Value::Null;
        let declared = &document["instrument"]["noise"];
        let number = |value: &Value| value.as_f64().expect("a number");
        let (white, flicker) =
            (number(&declared["white_rms_nt"]), declared["flicker_nt2_per_hz_at_1hz"].clone());
        let noise = &mut document["calibration"]["sensors"][axis]["noise"];
        noise["flicker_nt2_per_hz_at_1hz"] = flicker;
        noise["flicker_exponent"] = json!(1.0);
        for series in noise["series"].as_array_mut().expect("series") {
            let code = series["code_nt"].as_f64().unwrap_or(0.0);
            series["white_rms_nt"] = json!((white * white + code * code / 12.0).sqrt());
        }
    }
    Document::parse(&document.to_string()).expect("a document")
}

fn spec() -> Spec {
    let warm = |part: &str| json!({"kind": "offset_stability_nt", "title": part, "limit": 9.0, "sensor_temperature_c": "calibrated"});
    let spec = json!({"fluxcal": 1, "title": "coverage", "requirements": [
        {"kind": "orthogonality_deg", "title": "angles", "limit": 10.0},
        {"kind": "noise_zero_to_peak_nt", "title": "noise", "limit": 0.1, "band_hz": [0.1, 25.0], "over_s": 10.0},
        warm("offset over temperature"),
        {"kind": "offset_stability_nt", "title": "offset in a year", "limit": 9.0, "years": 1.0},
    ]});
    Spec::parse(&spec.to_string()).expect("a specification")
}

/// 95 % intervals of the statement: 93 to 97 %, and at least 93 % for the trend, which allows for a random
/// walk.
#[test]
fn statements_hold_over_campaigns() {
    let (count, first) = (testkit::campaigns(1), testkit::number("FLUXCAL_FIRST").unwrap_or(1));
    let spec = spec();
    let mut held: BTreeMap<String, Vec<bool>> = BTreeMap::new();
    for seed in first..first + count {
        let (document, truth) = campaign(seed);
        let mut found = calibrated(&document);
        found.recordings.clear();
        let exact = true_of(&found, &truth);
        let (found, exact) =
            [&found, &exact].map(|of| report::conformity::judge(of, &spec).expect("judged")).into();
        for (one, truth) in found.iter().zip(&exact) {
            for (shown, truth) in one.shown.iter().zip(&truth.shown) {
                let (shown, truth) = [shown, truth].map(|shown| shown.as_ref().expect("shown")).into();
                let inside = (shown.value - truth.value).abs() <= 1.96 * shown.std;
                held.entry(one.requirement.title.clone()).or_default().push(inside);
            }
        }
    }
    let mut outside = Vec::new();
    for (title, held) in &held {
        let (inside, tried) = (held.iter().filter(|held| **held).count(), held.len());
        println!("{title}: {inside} of {tried}");
        let most = if title == "offset in a year" { 1.0 } else { 0.97 };
        if !testkit::agrees(inside, tried, [0.93, most], held.len()) {
            outside.push(format!("{title}: {inside} of {tried}"));
        }
    }
    assert_eq!(held.values().map(Vec::len).sum::<usize>(), 4 * Axis::ALL.len() * count as usize);
    assert!(outside.is_empty(), "{}", outside.join(", "));
}
