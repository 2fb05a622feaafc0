//! Laws over drawn campaigns: what does not matter to the directions, and what changes them in a known way.
//! FLUXCAL_CAMPAIGNS sets how many.
//!
//! Not asked here: splitting a run with a sine, whose amplitude is of the whole run.

use axescal::Options;
use serde_json::{Value, json};
use testkit::laws::{self, Close};

fn plan(seed: u64) -> Value {
    let mut plan = laws::plan(
        seed,
        json!([
            {"procedure": "axes_orientation", "id": "axes", "orientations": "nasa_table_3", "drive_nt": 50000, "fixture_std_arcmin": 2.0,
                "drives": ["zero", "x", "-x", "y", "-y", "z", "-z", "zero"]},
            {"procedure": "axes_orientation", "id": "ac", "orientations": "nasa_figure_9", "drive_nt": 50000, "fixture_std_arcmin": 2.0,
                "drives": ["x", "y", "z"], "ac": {"hz": 0.1, "cycles": 4, "rate_hz": 1, "dither_nt": 10}}
        ]),
    );
    plan["unstated"] = json!(["axes"]);
    plan["instrument"]["noise"] = json!({"white_rms_nt": 0.5});
    plan
}

/// The same with temperatures that act.
fn warm(seed: u64) -> Value {
    let mut plan = plan(seed);
    plan["truth"]["model"] = laws::warm(seed);
    plan["temperatures"]["daily_k"] = 3.0.into();
    plan
}

fn campaign(plan: &Value) -> Value {
    let model = plan["truth"]["model"].clone();
    let plan = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    let mut document = laws::json(&simulate::campaign(&plan).expect("simulated").document);
    if !model.is_null() {
        document["model"] = model;
    }
    document
}

fn run(document: &Value) -> Value {
    laws::stage(|document| axescal::run(document, &Options::default()))(document)
}

/// Each law over so many campaigns.
fn each(law: impl Fn(u64, &Value)) {
    (0..testkit::campaigns(4)).for_each(|seed| law(seed, &campaign(&plan(seed))));
}

/// How the minimum was reached, and the measures of the columns there, depend on the frame in which steps are counted.
const WAY: &[&str] = &["iterations", "singular_values"];
/// The way; and in another frame a coil is at another angle to its nominal axis, by which channels seem swapped.
const TURNED: &[&str] =
    &["finding_codes", "iterations", "singular_values", "coils.off_nominal_arcsec", "residual_field_nt"];
/// The way; and a reading without drive is listed under the first coil, whatever its name.
const NAMED: &[&str] = &["iterations", "singular_values", "readings.coil"];

#[test]
fn changes_of_the_document_change_the_answer_alike() {
    let turn = |document: &Value, seed: u64| laws::rotate_geo(document, &laws::rotation(seed));
    type Change = fn(&Value, u64) -> Value;
    let laws: [(&str, Change, Close); 4] = [
        ("names of the axes", |document, _| laws::rename_axes(document), Close::SOLVED.but(NAMED)),
        ("volts and amperes", |document, _| laws::scale_volts(document, 0.73), Close::SUMMED),
        ("frame of the coils", turn, Close::SOLVED.but(TURNED)),
        ("order of recordings", laws::reorder, Close::SUMMED.but(WAY)),
    ];
    each(|seed, document| {
        for (name, change, close) in &laws {
            laws::commutes(name, document, |document| change(document, seed), run, close);
        }
    });
}

#[test]
fn turning_geo_turns_the_residual_field() {
    each(|seed, document| {
        let q = laws::rotation(seed);
        let turned = |document: &Value| {
            laws::rotate_geo(document, &q)["calibration"]["axes"]["residual_field_nt"].clone()
        };
        let (expected, found) = (turned(&run(document)), run(&laws::rotate_geo(document, &q)));
        for axis in ["x", "y", "z"] {
            let found = &found["calibration"]["axes"]["residual_field_nt"][axis];
            let off = found["value"].as_f64().expect("a field") - expected[axis].as_f64().expect("a field");
            let std = found["std"].as_f64().expect("an uncertainty");
            assert!(off.abs() < 1e-3 * std, "residual field {axis}: {off}");
        }
    });
}

#[test]
fn an_orientation_in_two_recordings_is_the_same() {
    for seed in 0..testkit::campaigns(4) {
        let mut plan = plan(seed);
        plan["procedures"].as_array_mut().expect("a list").truncate(1);
        let halves = |document: &Value| laws::split(document, "axes_orientation", 1, seed);
        // What was recorded differs, and with the ids and rows the list of all readings.
        let close = Close::SUMMED.but(&["recordings", "axes.readings", "doubtful", "iterations"]);
        laws::invariant("split", &campaign(&plan), halves, run, &close);
    }
}

#[test]
fn twice_the_noise_is_twice_the_interval() {
    for seed in 0..testkit::campaigns(4) {
        let mut plan = plan(seed);
        // Noise alone is doubled, and not theodolites or stated constants.
        plan["facility"].as_object_mut().expect("a facility").remove("theodolite_arcsec");
        for exact in ["coils", "sensors"] {
            plan["truth"]["calibration"].as_object_mut().expect("constants").remove(exact);
        }
        let (document, quiet) = (campaign(&plan), campaign(&laws::quiet(&plan)));
        let louder = run(&laws::double_noise(&document, &quiet));
        let axes = |document: &Value| document["calibration"]["axes"].clone();
        // Angles move by 1e-5 rad with the noise, and the readings' derivatives with them.
        let count = laws::doubled("noise", &axes(&louder), &axes(&run(&document)), 1e-3, &[]);
        assert!(count >= 20, "{count} quantities");
    }
}

#[test]
fn unknown_keys_change_nothing_and_stay() {
    each(|_, document| laws::keeps_unknown_keys(document, run));
}

#[test]
fn a_reference_temperature_moves_no_direction() {
    // What the model's effects add at most is in a code.
    let close = Close::SOLVED.but(&["iterations", "finding_codes"]);
    for seed in 0..testkit::campaigns(4) {
        let law = |document: &Value| laws::move_reference(document, [4.0, -3.0, 2.0]);
        laws::commutes("reference", &campaign(&warm(seed)), law, run, &close);
    }
}

/// Of NASA's readings.
#[test]
fn the_unit_of_the_field_does_not_matter() {
    let table: Value =
        serde_json::from_str(&testkit::read_fixture("nasa-1977/table-4.json")).expect("a document");
    let solved = |factor: f64| {
        let mut document = table.clone();
        for axis in ["x", "y", "z"] {
            let calibration = &mut document["calibration"];
            calibration["coils"][axis]["constant_nt_per_a"] = json!(factor * 50_000.0);
            calibration["sensors"][axis]["sensitivity_nt_per_v"] = json!(factor * 50_000.0);
        }
        let axes = &run(&document)["calibration"]["axes"];
        ["sensors", "coils"].map(|part| json!({"matrix": axes[part]["matrix"]}))
    };
    for factor in [1e-3, 1e3] {
        for (found, expected) in solved(factor).iter().zip(solved(1.0)) {
            Close::SOLVED.check("unit", found, &expected);
        }
    }
}
