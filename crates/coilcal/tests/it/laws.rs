//! Laws over drawn campaigns: what does not matter to the coils, and what changes an answer in a known way.
//! FLUXCAL_CAMPAIGNS sets how many.
//!
//! Not asked here: moving a reference temperature, splitting a survey or a series of the nulling.

use serde_json::{Value, json};
use testkit::laws::{self, Close};

use crate::build;

fn plan(seed: u64) -> Value {
    let constant = |id: &str, coil: &str| json!({"procedure": "coil_constant", "id": format!("{id}-{coil}"), "coil": coil, "step_nt": 10000, "repeats": 4});
    let gradient =
        |coil: &str| json!({"procedure": "coil_gradient", "id": format!("gradient-{coil}"), "coil": coil});
    let nulling = json!({"procedure": "nulling_residual", "id": "nulling", "sites": ["weekday-day", "weekend-night"],
        "series": [{"length_s": 512, "rate_hz": 1}, {"length_s": 8, "rate_hz": 64}]});
    let axes = ["x", "y", "z"];
    let each = |coil: &&str| [constant("constant", coil), constant("again", coil), gradient(coil)];
    let procedures: Vec<Value> = axes.iter().flat_map(each).chain([nulling]).collect();
    let mut plan = laws::plan(seed, procedures.into());
    plan["drive"] = "voltage".into();
    plan["unstated"] = json!(["coils"]);
    let noise = |size: f64| json!({"noise": {"white_rms_nt": size, "flicker_nt2_per_hz_at_1hz": 0.1 * size * size}, "mains_nt": [size, size, size]});
    plan["truth"]["site"] = json!({"weekday-day": noise(0.3), "weekend-night": noise(0.1)});
    plan["truth"]["coil_profile"] =
        json!({"x": {"first_ppm_per_m": 3.0, "second_ppm_per_m2": -40.0}, "z": {"second_ppm_per_m2": 20.0}});
    plan
}

fn campaign(plan: &Value) -> Value {
    laws::json(&build::simulated(plan))
}

fn run(document: &Value) -> Value {
    laws::stage(|document| coilcal::run(document, &coilcal::Options::default()))(document)
}

/// Each law over so many campaigns.
fn each(law: impl Fn(u64, &Value)) {
    (0..testkit::campaigns(3)).for_each(|seed| law(seed, &campaign(&plan(seed))));
}

/// A scalar magnetometer knows no directions.
#[test]
fn changes_of_the_document_change_the_answer_alike() {
    type Change = fn(&Value, u64) -> Value;
    let laws: [(&str, Change); 4] = [
        ("names of the axes", |document, _| laws::rename_axes(document)),
        ("volts and amperes by another measure", |document, _| laws::scale_volts(document, 0.73)),
        ("frame of the laboratory", |document, seed| laws::rotate_geo(document, &laws::rotation(seed))),
        ("order of recordings", laws::reorder),
    ];
    each(|seed, document| {
        for (name, change) in laws {
            laws::commutes(name, document, |document| change(document, seed), run, &Close::SUMMED);
        }
    });
}

#[test]
fn a_constant_in_two_recordings_is_the_same() {
    // What was recorded differs, and the ids of the recordings.
    let close = Close::SUMMED.but(&["recordings"]);
    each(|seed, document| {
        let halves = |document: &Value| laws::split(document, "coil_constant", 1, seed);
        laws::invariant("split", document, halves, run, &close);
    });
}

#[test]
fn twice_the_noise_is_twice_the_interval() {
    for seed in 0..testkit::campaigns(3) {
        let mut plan = plan(seed);
        // The nulling's noise is what it measures.
        plan["procedures"]
            .as_array_mut()
            .expect("a list")
            .retain(|one| one["procedure"] != "nulling_residual");
        let (document, quiet) = (campaign(&plan), campaign(&laws::quiet(&plan)));
        let louder = run(&laws::double_noise(&document, &quiet));
        // A coil's field that is off by a millionth has uncertainties in ppm that are so too.
        let count = laws::doubled(
            "noise",
            &louder["calibration"]["coils"],
            &run(&document)["calibration"]["coils"],
            1e-3,
            &[],
        );
        assert!(count > 30, "{count} quantities");
    }
}

#[test]
fn unknown_keys_change_nothing_and_stay() {
    each(|_, document| laws::keeps_unknown_keys(document, run));
}
