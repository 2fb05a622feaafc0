//! A document with calibration and model predicts its own recordings.

use common::{Axis, Document};
use serde_json::{Value, json};
use simulate::{Campaign, DriveRecord, Replayed, TruthPlan};

use crate::build::quiet;

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

/// A campaign whose document states all that is true.
fn known(name: &str) -> Document {
    let mut plan = quiet(name);
    (plan.unstated, plan.drive) = (Vec::new(), DriveRecord::Current);
    let TruthPlan { residual_field_nt, shield_field_nt, coil_profile, outside, .. } = &mut plan.truth;
    (*residual_field_nt, *shield_field_nt, *coil_profile) = (None, None, None);
    outside.iter_mut().for_each(|outside| outside.station = None);
    let Campaign { mut document, truth } = simulate::campaign(&plan).expect("simulated");
    document.calibration = Some(truth.calibration);
    document.model = Some(truth.model);
    document
}

fn worst(a: &Document, b: &Document, wanted: impl Fn(&str, &str) -> bool) -> (f64, usize) {
    let (mut worst, mut count) = (0.0f64, 0);
    for (a, b) in a.recordings.iter().zip(&b.recordings) {
        for (name, column) in a.columns.iter().filter(|(name, _)| wanted(&a.procedure, name)) {
            for (x, y) in column.iter().zip(&b.columns[name]) {
                worst = worst.max((x - y).abs());
                count += 1;
            }
        }
    }
    (worst, count)
}

#[test]
fn what_is_known_exactly_is_predicted_exactly() {
    for (name, readings) in [("cubesat", 20_000), ("observatory-pair", 129_600)] {
        let document = known(name);
        let mut emptied = document.clone();
        for recording in &mut emptied.recordings {
            for (name, column) in &mut recording.columns {
                let reading = (name.starts_with("sensor_") && !name.contains("temperature"))
                    || name.starts_with("test_")
                    || name == "reference_nt";
                if reading {
                    column.iter_mut().for_each(|value| *value = 1.0);
                }
            }
        }
        let Replayed { document: replayed, .. } = simulate::replay(&emptied, None).expect("replayed");
        let (missed, count) = worst(&document, &replayed, |_, _| true);
        println!("{name}: {count} numbers, the worst {missed:.1e}");
        assert!(missed < 1e-6 && count > readings, "{name}: {missed} of {count}");
    }
}

#[test]
fn the_magsat_campaign_too_where_everything_is_recorded() {
    let document = known("magsat");
    let Replayed { document: replayed, notes } = simulate::replay(&document, None).expect("replayed");
    // The leak of natural variations is known only where the station outside was recorded.
    let leak = "nulling_leakage is not applied in recording \"coil-x\" and 39 more";
    assert!(notes.iter().any(|note| note.contains(leak)), "{notes:?}");
    let nulling = worst(&document, &replayed, |procedure, _| procedure == "nulling_residual");
    assert!(nulling.0 < 1e-9 && nulling.1 > 100_000, "{nulling:?}");
    let shield = worst(&document, &replayed, |procedure, _| procedure == "sensor_noise");
    assert!(shield.0 < 1e-9, "{shield:?}");
    // Elsewhere the leak is what is missed: up to 0.5 % of the day's variation.
    let all = worst(&document, &replayed, |_, name| name.starts_with("sensor_") && name.ends_with("_v"));
    assert!(all.0 * 6400.0 < 0.3, "{all:?}");
}

#[test]
fn missing_readings_stay_missing_and_noise_is_added_when_asked() {
    let mut document = known("cubesat");
    let noise = json!({"white_rms_nt": 3.0});
    let instrument = document.instrument.as_mut().expect("an instrument");
    instrument.noise = serde_json::from_value(noise).expect("noise");
    instrument.quantisation_nt = Some(1.0);
    let at = document.recordings.iter().position(|r| r.id == "on-board").expect("a recording");
    document.recordings[at].columns["sensor_y_nt"][7] = f64::NAN;
    let run = |arguments: &[&str]| {
        let run = testkit::run(SIMULATE, arguments, &common::to_text(&document));
        assert_eq!(run.code, 0, "{}", run.stderr);
        Document::parse(&run.stdout).expect("a document")
    };
    let (plain, noisy) = (run(&["replay", "-q"]), run(&["replay", "-q", "--noise", "--seed", "4"]));
    let column = |document: &Document, axis: Axis| {
        document.recordings[at].columns[&format!("sensor_{axis}_nt")].clone()
    };
    assert!(column(&plain, Axis::Y)[7].is_nan() && column(&noisy, Axis::Y)[7].is_nan());
    let differences: Vec<f64> =
        column(&noisy, Axis::X).iter().zip(&column(&plain, Axis::X)).map(|(a, b)| a - b).collect();
    let rms = (differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64).sqrt();
    assert!((2.4..3.7).contains(&rms), "{rms}");
    assert!(column(&noisy, Axis::X).iter().all(|value| value.fract() == 0.0));
    assert_eq!(noisy.history.last().expect("history").arguments, ["replay", "--noise", "--seed=4"]);
}

#[test]
fn what_cannot_be_predicted_is_said_with_its_place() {
    let document = json!({"fluxcal": 1, "recordings": [{"id": "run", "procedure": "free_run",
        "columns": {"coil_x_a": [0.5, 1.0], "sensor_x_nt": [1.0, 2.0]}}]});
    let run = |document: &Value| testkit::run(SIMULATE, &["replay"], &document.to_string());
    let refused = run(&document);
    assert_eq!((refused.code, refused.stdout.as_str()), (2, ""));
    let said = "recordings[0]: found a drive of coil x, whose constant is not known; expected calibration.coils.x.constant_nt_per_a";
    assert!(refused.stderr.contains(said), "{}", refused.stderr);
    let mut volts = document.clone();
    volts["calibration"] = json!({"coils": {"x": {"constant_nt_per_a": 40000.0}}});
    let predicted = run(&volts);
    let assumed = "directions of the sensors are not stated: assumed along SEN";
    assert!(predicted.stderr.contains(assumed), "{}", predicted.stderr);
    let predicted: Value = serde_json::from_str(&predicted.stdout).expect("JSON");
    assert_eq!(predicted["recordings"][0]["columns"]["sensor_x_nt"], json!([20000.0, 40000.0]));
    volts["recordings"][0]["columns"] = json!({"coil_x_a": [0.5], "sensor_x_v": [1.0]});
    let refused = run(&volts);
    let said = "readings in V without a sensitivity";
    assert!(refused.code == 2 && refused.stderr.contains(said), "{}", refused.stderr);
}
