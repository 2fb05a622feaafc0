//! Laws of the forward model over drawn campaigns: what does not matter to a prediction, and what changes it
//! in a known way. FLUXCAL_CAMPAIGNS sets how many.

use serde_json::{Value, json};
use testkit::laws::{self, Close};

/// A document that states what is true, with `model`.
fn document(seed: u64, model: Value) -> Value {
    let plan = laws::plan(
        seed,
        json!([
            {"procedure": "coil_constant", "id": "constant", "coil": "y", "step_nt": 20000, "repeats": 2},
            {"procedure": "sensor_sensitivity", "id": "sensitivity", "steps": 5},
            {"procedure": "sensor_offset_reversal", "id": "reversal", "pairs": 2},
            {"procedure": "temperature_run", "id": "temperature", "deviations_k": [0, 20, -20, 0], "steps": 3},
            {"procedure": "axes_orientation", "id": "axes", "orientations": "nasa_table_3", "drive_nt": 50000, "drives": ["zero", "x", "-y", "z"]}
        ]),
    );
    let parsed = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    let campaign = simulate::campaign(&parsed).expect("simulated");
    let mut document = laws::json(&campaign.document);
    for part in ["coils", "sensors", "axes"] {
        document["calibration"][part] = plan["truth"]["calibration"][part].clone();
    }
    document["model"] = model;
    document
}

/// Effects of one reading on itself, fixed in SEN and in GEO; temperatures beside.
fn instant(seed: u64) -> Value {
    let mut draw = laws::Draw::new(seed);
    let mut model = laws::warm(seed);
    let effects = model["effects"].as_array_mut().expect("a list");
    for axis in ["x", "y", "z"] {
        let across = json!({"first_nt": draw.even(), "second_nt": draw.even(), "mixed_nt": draw.even()});
        effects.push(json!({"effect": "cross_field", "sensor": axis, "parameters": across}));
        effects.push(json!({"effect": "quadratic_nonlinearity", "sensor": axis, "parameters": {"departure_nt": 3.0 * draw.even()}}));
    }
    let iron =
        json!({"north_nt": 5.0 * draw.even(), "east_nt": 5.0 * draw.even(), "down_nt": 5.0 * draw.even()});
    effects.push(json!({"effect": "hard_iron", "parameters": iron}));
    model
}

/// The same, and what has memory or an orientation of its own.
fn everything(seed: u64) -> Value {
    let mut draw = laws::Draw::new(seed + 1000);
    let mut model = instant(seed);
    let effects = model["effects"].as_array_mut().expect("a list");
    let mut names = |names: &[&str], size: f64| -> Value {
        names
            .iter()
            .map(|name| (name.to_string(), json!(size * draw.even())))
            .collect::<serde_json::Map<_, _>>()
            .into()
    };
    let iron = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"].map(|entry| format!("{entry}_ppm"));
    let soft = names(&iron.each_ref().map(String::as_str), 50.0);
    effects.push(json!({"effect": "soft_iron", "parameters": soft}));
    for axis in ["x", "y", "z"] {
        let turn = names(&["first_arcsec_per_k", "second_arcsec_per_k"], 2.0);
        effects.push(json!({"effect": "axis_temperature", "sensor": axis, "parameters": turn}));
        effects.push(json!({"effect": "loop_bandwidth", "sensor": axis, "parameters": {"lag_s": 2.0}}));
        effects.push(json!({"effect": "eddy_currents", "coil": axis, "parameters": {"share_ppm": 100.0, "time_constant_s": 5.0}}));
        effects.push(json!({"effect": "ageing", "sensor": axis, "parameters": {"rate_nt_per_day": 0.5}}));
    }
    model
}

fn replay(document: &Value) -> Value {
    laws::stage(|document| simulate::replay(&document, None).map(|replayed| replayed.document))(document)
}

fn each(model: impl Fn(u64) -> Value, law: impl Fn(u64, &Value)) {
    (0..testkit::campaigns(5)).for_each(|seed| law(seed, &document(seed, model(seed))));
}

/// That predictions of what is changed are the predictions, changed.
fn commutes(model: fn(u64) -> Value, name: &str, change: impl Fn(u64, &Value) -> Value, close: &Close) {
    each(model, |seed, document| laws::commutes(name, document, |it| change(seed, it), replay, close));
}

/// A prediction is some dozens of products and sums of numbers with sixteen digits.
const PREDICTED: Close = Close { relative: 1e-13, direction: 1e-15, ..Close::SUMMED };

#[test]
fn the_names_of_the_axes_do_not_matter() {
    commutes(everything, "rename", |_, document| laws::rename_axes(document), &PREDICTED);
}

#[test]
fn volts_and_amperes_by_another_measure_scale_the_readings() {
    commutes(everything, "volts", |_, document| laws::scale_volts(document, 0.73), &PREDICTED);
}

#[test]
fn the_frame_of_the_laboratory_does_not_matter() {
    let turn = |seed, document: &Value| laws::rotate_geo(document, &laws::rotation(seed));
    commutes(instant, "geo", turn, &PREDICTED);
}

#[test]
fn the_order_of_recordings_does_not_matter() {
    commutes(everything, "order", |seed, document| laws::reorder(document, seed), &Close::EXACT);
}

#[test]
fn a_recording_in_two_is_the_same_where_nothing_has_memory() {
    for procedure in ["sensor_sensitivity", "temperature_run", "axes_orientation", "sensor_offset_reversal"] {
        commutes(instant, "split", |seed, it| laws::split(it, procedure, 1, seed), &Close::EXACT);
    }
}

#[test]
fn twice_the_declared_noise_is_twice_the_noise() {
    each(everything, |seed, document| {
        let noisy =
            laws::stage(|document| simulate::replay(&document, Some(seed)).map(|replayed| replayed.document));
        let clean = replay(document);
        let louder = noisy(&laws::double_noise(&clean, &clean));
        // What is beyond the clean readings, twice; declared as what it is.
        let expected = laws::double_noise(&noisy(&clean), &clean);
        Close { relative: 1e-12, ..PREDICTED }.check("noise", &louder, &expected);
    });
}

#[test]
fn unknown_keys_change_nothing_and_stay() {
    each(everything, |_, document| laws::keeps_unknown_keys(document, replay));
}

#[test]
fn a_reference_temperature_moves_no_reading() {
    let moved = |_, document: &Value| laws::move_reference(document, [4.0, -3.0, 2.0]);
    commutes(laws::warm, "reference", moved, &PREDICTED);
}
