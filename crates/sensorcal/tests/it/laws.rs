//! Laws over drawn campaigns (FLUXCAL_CAMPAIGNS sets how many): what leaves a sensor's constants, what acts.
//!
//! Not asked here: that a recording in two is the same. The noise of a coil's field and of a sensor has
//! memory within a recording, a shield's field is another one in each, and a spectrum is of one series.

use rayon::prelude::*;
use sensorcal::Options;
use serde_json::{Value, json};
use testkit::laws::{self, Close};

use crate::build;

fn plan(seed: u64) -> Value {
    let mut plan = laws::plan(
        seed,
        json!([
            {"procedure": "sensor_sensitivity", "id": "sensitivity", "to_nt": 60000, "steps": 21},
            {"procedure": "sensor_sensitivity", "id": "again", "to_nt": 50000, "steps": 11},
            {"procedure": "sensor_offset_reversal", "id": "reversal", "pairs": 6},
            {"procedure": "sensor_offset_reversal", "id": "reversal-again", "pairs": 4},
            {"procedure": "sensor_noise", "id": "noise", "series": [{"length_s": 1800, "step_s": 10}, {"length_s": 6, "step_s": 0.05}]},
            {"procedure": "temperature_run", "id": "temperature", "deviations_k": [0, 15, 30, 15, 0, -15, 0], "to_nt": 60000, "steps": 5},
            {"procedure": "cross_field", "id": "cross", "levels_nt": [0, 50000, -50000], "to_nt": 60000, "steps": 5},
            {"procedure": "offset_drift", "id": "drift", "dates": 6, "pairs": 4}
        ]),
    );
    plan["unstated"] = json!(["sensors"]);
    plan["temperatures"]["daily_k"] = 0.3.into();
    plan
}

/// The same with temperatures and fields across that act.
fn acting(seed: u64) -> Value {
    let mut plan = plan(seed);
    let mut draw = laws::Draw::new(seed);
    let mut model = laws::warm(seed);
    let effects = model["effects"].as_array_mut().expect("a list");
    // The coils stay as they are: their temperature is not looked for here.
    effects.retain(|effect| effect["sensor"].is_string());
    for axis in ["x", "y", "z"] {
        let parameters = json!({"first_nt": draw.even(), "second_nt": draw.even(), "mixed_nt": 0.0});
        effects.push(json!({"effect": "cross_field", "sensor": axis, "parameters": parameters}));
    }
    plan["truth"]["model"] = model;
    plan
}

fn campaign(plan: &Value) -> Value {
    laws::json(&build::simulated(plan).document)
}

fn run(document: &Value) -> Value {
    laws::stage(|document| sensorcal::run(document, &Options::default()))(document)
}

/// Each law over so many campaigns.
fn each(law: impl Fn(u64, &Value)) {
    (0..testkit::campaigns(2)).for_each(|seed| law(seed, &campaign(&acting(seed))));
}

#[test]
fn changes_of_the_document_change_the_answer_alike() {
    type Change = fn(&Value, u64) -> Value;
    let laws: [(&str, Change, Close); 4] = [
        ("names of the axes", |document, _| laws::rename_axes(document), Close::SOLVED),
        ("volts and amperes", |document, _| laws::scale_volts(document, 0.73), Close::SOLVED),
        ("frame", |document, seed| laws::rotate_geo(document, &laws::rotation(seed)), Close::SOLVED),
        ("order of recordings", laws::reorder, Close::EXACT),
    ];
    each(|seed, document| {
        laws.par_iter().for_each(|(name, change, close)| {
            laws::commutes(name, document, |document| change(document, seed), run, close);
        });
    });
}

/// A temperature at which nothing changes is the ratio of two coefficients, which both may be noise.
const RATIOS: &[&str] = &["extrema_c"];

#[test]
fn twice_the_noise_is_twice_the_interval() {
    for seed in 0..testkit::campaigns(2) {
        let plan = plan(seed);
        let (document, quiet) = (campaign(&plan), campaign(&laws::quiet(&plan)));
        let louder = run(&laws::double_noise(&document, &quiet));
        let sensors = |document: &Value| document["calibration"]["sensors"].clone();
        let count = laws::doubled("noise", &sensors(&louder), &sensors(&run(&document)), 1e-3, RATIOS);
        assert!(count > 100, "{count} quantities");
    }
}

#[test]
fn unknown_keys_change_nothing_and_stay() {
    each(|_, document| laws::keeps_unknown_keys(document, run));
}

/// The answers at another reference are those at the first, moved: they predict the same readings.
#[test]
fn a_reference_temperature_moves_the_constants_and_no_field() {
    let parts = |document: &Value| {
        let constants = |axis: &str| {
            let sensor = &document["calibration"]["sensors"][axis];
            json!({"k": sensor["sensitivity_nt_per_v"], "o": sensor["offset_nt"]})
        };
        json!({"x": constants("x"), "y": constants("y"), "z": constants("z"), "model": document["model"]})
    };
    // Uncertainties belong to the temperature at which a number is stated.
    let close = Close { stds: false, ..Close::SOLVED };
    each(|_, document| {
        let by_k = [4.0, -3.0, 0.0];
        let expected = parts(&laws::move_reference(&run(document), by_k));
        let found = parts(&run(&laws::move_reference(document, by_k)));
        close.check("reference", &found, &expected);
    });
}
