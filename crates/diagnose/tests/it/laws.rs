//! Laws over drawn campaigns: what does not matter to a diagnosis, and what changes it in a known way.
//! FLUXCAL_CAMPAIGNS sets how many.
//!
//! Probabilities of a search are counted in drawn noise, which is drawn in the order of channels and
//! candidates: they, and what is told by them alone, are compared in no law that changes that order.

use diagnose::Options;
use serde_json::{Value, json};
use testkit::laws::{self, Close, Draw};

use crate::bench::{Scene, noise, simulated};

/// One effect or none, of a size that is drawn.
fn effects(seed: u64) -> Vec<Value> {
    let mut draw = Draw::new(seed);
    let axis = ["x", "y", "z"][draw.below(3)];
    let size = 1.0 + 0.3 * draw.even();
    let all = [
        json!({"effect": "offset_temperature_lag", "sensor": axis, "parameters": {"coefficient_nt_per_k": 0.4 * size, "lag_s": 300.0}}),
        json!({"effect": "quadratic_nonlinearity", "sensor": axis, "parameters": {"departure_nt": 5.0 * size}}),
        json!({"effect": "eddy_currents", "coil": axis, "parameters": {"share_ppm": 300.0 * size, "time_constant_s": 60.0}}),
        json!({"effect": "cross_field", "sensor": axis, "parameters": {"first_nt": 5.0 * size, "second_nt": -3.0, "mixed_nt": 1.0}}),
    ];
    vec![all[seed as usize % all.len()].clone()]
}

fn run(document: &Value) -> Value {
    laws::stage(|document| diagnose::run(document, &Options::default()))(document)
}

/// What is found: the verdict, the effects, what is left and the calibration that goes with them.
fn answer(document: &Value) -> Value {
    let entry = &document["diagnosis"][0];
    let effects = entry["effects"].as_array().cloned().unwrap_or_default();
    let named = |effect: &Value| json!({"effect": effect["effect"], "sensor": effect["sensor"], "coil": effect["coil"], "parameters": effect["parameters"]});
    json!({
        "verdict": entry["verdict"], "ambiguity": entry["ambiguity"], "fit": entry["fit"],
        "effects": effects.iter().map(named).collect::<Vec<_>>(), "calibration": document["calibration"], "model": document["model"]
    })
}

fn campaign(seed: u64) -> Value {
    laws::json(&simulated(Scene::Runs, &effects(seed), &noise(), 700 + seed))
}

/// The document with a recording without rows.
fn with_another(document: &Value) -> Value {
    let mut document = document.clone();
    let recordings = document["recordings"].as_array_mut().expect("recordings");
    let mut another = recordings[0].clone();
    another["id"] = json!("without rows");
    another["columns"].as_object_mut().expect("columns").values_mut().for_each(|rows| *rows = json!([]));
    recordings.push(another);
    document
}

/// What a law changes of a document, by the seed of its campaign.
type Change = fn(&Value, u64) -> Value;

/// The answer to the changed document is the answer to the document, changed.
#[test]
fn what_does_not_matter_changes_no_answer() {
    // Uncertainties belong to the temperature at which a number is stated.
    let reference = Close { stds: false, ..Close::SOLVED.but(&["covariance"]) };
    let laws: [(&str, Change, Close); 6] = [
        ("the names of the axes", |document, _| laws::rename_axes(document), Close::SOLVED),
        ("a recording without rows", |document, _| with_another(document), Close::SOLVED),
        ("the measure of amperes", |document, _| laws::scale_volts(document, 0.73), Close::SOLVED),
        ("the frame", |document, seed| laws::rotate_geo(document, &laws::rotation(seed)), Close::SOLVED),
        ("the order of recordings", laws::reorder, Close::SOLVED),
        ("a reference", |document, _| laws::move_reference(document, [4.0, -3.0, 2.0]), reference),
    ];
    for seed in 0..testkit::campaigns(1) {
        let document = campaign(seed);
        let found = run(&document);
        for (law, change, close) in &laws {
            close.check(law, &answer(&run(&change(&document, seed))), &answer(&change(&found, seed)));
        }
    }
}

/// A column that moves in another recording only is zero where there are readings: no size is beyond numbers.
#[test]
fn a_column_of_another_recording_is_no_fault() {
    let readings: Vec<f64> = (0..16).map(|row| 20_900.0 + 8.0 * (0.2 * f64::from(row)).sin()).collect();
    let times: Vec<f64> = (0..16).map(|row| 0.5 * f64::from(row)).collect();
    let document = json!({"fluxcal": 1, "recordings": [
        {"id": "days", "procedure": "free_run", "columns": {"time_s": [0, 86_400, 172_800], "battery_v": [12.1, 12.2, 12.4]}},
        {"id": "field", "procedure": "free_run", "columns": {"time_s": times, "sensor_x_nt": readings}},
    ]});
    assert!(run(&document)["diagnosis"][0]["verdict"].is_string());
}

#[test]
fn unknown_keys_change_nothing_and_stay() {
    (0..testkit::campaigns(1)).for_each(|seed| laws::keeps_unknown_keys(&campaign(seed), run));
}

#[test]
fn twice_the_noise_is_twice_the_interval() {
    for seed in 0..testkit::campaigns(1) {
        let document = simulated(Scene::Runs, &[], &noise(), 800 + seed);
        let quiet = simulate::replay(&document, None).expect("predicted").document;
        let (document, quiet) = (laws::json(&document), laws::json(&quiet));
        let louder = run(&laws::double_noise(&document, &quiet));
        let shift = |document: &Value| document["diagnosis"][0]["base_shift"].clone();
        // A scale that coils and sensors may trade is known to a thousandth, moves by as much, and its
        // uncertainty with it.
        let count = laws::doubled("noise", &shift(&louder), &shift(&run(&document)), 1e-2, &[]);
        assert!(count > 20, "{count} quantities");
    }
}
