//! Laws over drawn pairs: what does not matter to the matrix, and what changes it in a known way.
//! FLUXCAL_CAMPAIGNS sets how many.
//!
//! Not asked here: volts and amperes, GEO and reference temperatures, none of which enters. The fourteen
//! parameters have no other names: their angles count from the reference's y and z (DIFF).

use diffmag::Options;
use serde_json::{Value, json};
use testkit::laws::{self, Close, Draw};

use crate::natural::simulated;

/// Two recordings, one after the other, of a pair whose axes, scales and offsets are drawn.
fn plan(seed: u64) -> Value {
    let mut draw = Draw::new(seed);
    let mut three = |level: [f64; 3], size: f64| level.map(|level| level + size * draw.even());
    let reference = three([25.0, 0.0, 1.0], 0.5);
    json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "2026-03-01T00:00:00Z",
        "instrument": {"noise": {"white_rms_nt": 0.05, "flicker_nt2_per_hz_at_1hz": 1e-4}},
        "truth": {
            "outside": {
                "main_field_nt": three([20800.0, 700.0, 47500.0], 200.0),
                "daily_nt": [22, 28, 12],
                "background": {"flicker_nt2_per_hz_at_1hz": 1e-2, "flicker_exponent": 1.6}
            },
            "differential": {
                "reference": {"alpha_deg": reference[0], "beta_deg": reference[1], "gamma_deg": reference[2], "scale": three([1.0; 3], 2e-3)},
                "test": {"phi_deg": three([91.0, 1.0, 40.0], 1.0), "theta_deg": three([89.6, 90.4, 2.0], 1.0), "scale": three([1.0; 3], 2e-3)},
                "offset_nt": three([0.0; 3], 20.0)
            }
        },
        "procedures": [
            {"procedure": "differential", "id": "first", "length_s": 30000, "step_s": 60},
            {"procedure": "differential", "id": "second", "length_s": 24000, "step_s": 60}
        ]
    })
}

fn campaign(plan: &Value) -> Value {
    laws::json(&simulated(plan).document)
}

fn run(document: &Value) -> Value {
    laws::stage(|document| diffmag::run(document, &Options::default()))(document)
}

fn each(law: impl Fn(u64, &Value)) {
    (0..testkit::campaigns(2)).for_each(|seed| law(seed, &campaign(&plan(seed))));
}

#[test]
fn the_names_of_the_axes_do_not_matter() {
    // Covariances of a drift run over the reference's axes without naming them; one round more or less is
    // rounding.
    let close = Close::SOLVED.but(&["fourteen", "joint.covariance", "from_joint_std", "iteration.rounds"]);
    each(|_, document| laws::commutes("rename", document, laws::rename_axes, run, &close));
}

#[test]
fn the_order_of_recordings_does_not_matter() {
    let law = |seed, document: &Value| {
        laws::commutes("order", document, |document| laws::reorder(document, seed), run, &Close::EXACT);
    };
    each(law);
}

#[test]
fn a_recording_in_two_is_the_same() {
    for seed in 0..testkit::campaigns(2) {
        let mut plan = plan(seed);
        // Recordings whose clocks began apart are put on the grid of the longest, which may be another one
        // after the cut.
        plan["procedures"].as_array_mut().expect("a list").truncate(1);
        let halves = |document: &Value| laws::split(document, "differential", 10, seed);
        laws::invariant("split", &campaign(&plan), halves, run, &Close::EXACT.but(&["recordings"]));
    }
}

#[test]
fn twice_the_noise_is_twice_the_interval() {
    for seed in 0..testkit::campaigns(2) {
        let plan = plan(seed);
        let (document, quiet) = (campaign(&plan), campaign(&laws::quiet(&plan)));
        let louder = run(&laws::double_noise(&document, &quiet));
        let part = |document: &Value| document["calibration"]["differential"].clone();
        // Angles and ratios are read off a matrix that moves by some thousandths with the noise, and so do
        // their derivatives. A time constant that is fitted to noise, and the share of the noise that pulls
        // the matrix, are not in its measure.
        let apart = &["time_constant_s", "share"];
        let count = laws::doubled("noise", &part(&louder), &part(&run(&document)), 1e-2, apart);
        assert!(count > 30, "{count} quantities");
    }
}

#[test]
fn unknown_keys_change_nothing_and_stay() {
    each(|_, document| laws::keeps_unknown_keys(document, run));
}
