//! Laws over drawn campaigns: what does not matter to a corrected field, and what changes it in a known way.
//! FLUXCAL_CAMPAIGNS sets how many.

use correct::Frame;
use serde_json::{Value, json};
use testkit::laws::{self, Close};

/// Readings of a block in coils, and the calibration that is stated, with its uncertainties; temperatures act
/// as the model says.
fn document(seed: u64) -> Value {
    let mut plan = laws::plan(
        seed,
        json!([
            {"procedure": "axes_orientation", "id": "axes", "orientations": "nasa_table_3", "drive_nt": 50000, "drives": ["zero", "x", "-y", "z"]},
            {"procedure": "axes_orientation", "id": "sine", "orientations": "nasa_figure_9", "drive_nt": 40000, "drives": ["x", "y"],
                "ac": {"hz": 0.1, "cycles": 2, "rate_hz": 1, "dither_nt": 20000}}
        ]),
    );
    plan["temperatures"]["daily_k"] = 4.0.into();
    plan["truth"]["model"] = laws::warm(seed);
    let parsed = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    let mut document = laws::json(&simulate::campaign(&parsed).expect("simulated").document);
    document["calibration"]["axes"] = plan["truth"]["calibration"]["axes"].clone();
    document["calibration"]["axes"]["sensors"]["std_arcsec"] = json!({"x": 1.0, "y": 2.0, "z": 3.0});
    document["model"] = plan["truth"]["model"].clone();
    document
}

fn run(frame: Frame) -> impl Fn(&Value) -> Value {
    laws::stage(move |document| correct::run(document, frame))
}

fn each(law: impl Fn(u64, &Value)) {
    (0..testkit::campaigns(4)).for_each(|seed| law(seed, &document(seed)));
}

/// Of 50 000 nT: 5e-9 nT, ten digits below the uncertainties and three above rounding.
const CORRECTED: Close = Close { relative: 1e-13, direction: 1e-15, ..Close::SUMMED };
/// Uncertainties of the constants belong to the reference temperature at which they are stated, flags to
/// those of a calibration.
const UNCERTAINTIES: &[&str] = &["field_std_x_nt", "field_std_y_nt", "field_std_z_nt", "field_flags"];
/// The covariance of a field in GEO is not written.
const IN_GEO: &[&str] = &["field_geo_std_x_nt", "field_geo_std_y_nt", "field_geo_std_z_nt"];

/// That what is corrected of a changed document is the corrected document, changed.
fn commutes(name: &str, frame: Frame, change: impl Fn(u64, &Value) -> Value, close: &Close) {
    each(|seed, document| laws::commutes(name, document, |it| change(seed, it), run(frame), close));
}

#[test]
fn the_names_of_the_axes_do_not_matter() {
    for frame in [Frame::Sen, Frame::Geo] {
        commutes("rename", frame, |_, document| laws::rename_axes(document), &CORRECTED);
    }
}

#[test]
fn volts_and_amperes_by_another_measure_change_no_field() {
    commutes("volts", Frame::Sen, |_, document| laws::scale_volts(document, 0.73), &CORRECTED);
}

#[test]
fn turning_geo_turns_the_field_in_it_and_no_other() {
    let turn = |seed, document: &Value| laws::rotate_geo(document, &laws::rotation(seed));
    commutes("geo", Frame::Sen, turn, &CORRECTED);
    commutes("geo", Frame::Geo, turn, &CORRECTED.but(IN_GEO));
}

#[test]
fn the_order_of_recordings_does_not_matter() {
    commutes("order", Frame::Sen, |seed, document| laws::reorder(document, seed), &Close::EXACT);
}

#[test]
fn a_recording_in_two_is_the_same() {
    each(|seed, document| {
        let mut document = document.clone();
        // Flicker noise reaches down to one over a recording's length: a shorter one has less.
        document["instrument"]["noise"] = json!({"white_rms_nt": 0.05});
        let halves = |document: &Value| laws::split(document, "axes_orientation", 1, seed);
        // The chain is inverted until every row of a recording settles, which is a last digit more or less.
        laws::commutes("split", &document, halves, run(Frame::Sen), &CORRECTED);
    });
}

#[test]
fn twice_the_uncertainty_is_twice_the_interval() {
    each(|_, document| {
        let run = run(Frame::Sen);
        let (mut expected, twice) = (run(document), run(&laws::double_noise(document, document)));
        for recording in expected["recordings"].as_array_mut().expect("recordings") {
            for name in &UNCERTAINTIES[..3] {
                for std in recording["columns"][*name].as_array_mut().expect("a column") {
                    *std = (2.0 * std.as_f64().expect("an uncertainty")).into();
                }
            }
        }
        CORRECTED.check("noise", &twice["recordings"], &expected["recordings"]);
    });
}

#[test]
fn unknown_keys_change_nothing_and_stay() {
    each(|_, document| laws::keeps_unknown_keys(document, run(Frame::Sen)));
}

#[test]
fn a_reference_temperature_moves_the_constants_and_no_field() {
    let moved = |_, document: &Value| laws::move_reference(document, [4.0, -3.0, 2.0]);
    commutes("reference", Frame::Sen, moved, &CORRECTED.but(UNCERTAINTIES));
}
