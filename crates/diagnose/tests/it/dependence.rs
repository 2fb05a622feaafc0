//! A column that no effect knows: named as a dependence, with its sensor and its lag, and never as physics.

use crate::bench;

use bench::{NOISE_NT, Scene, noise, simulated};
use common::{Document, Verdict};
use diagnose::Options;
use serde_json::json;

/// nT for a watt of the heater, and how late.
const PER_W: f64 = 0.4;
const LAG_S: f64 = 40.0;

/// Power of a heater that is switched on and off, and sensor z that follows it late.
fn heated() -> Document {
    let mut document = simulated(Scene::Runs, &[], &noise(), 21);
    for recording in &mut document.recordings {
        let time = recording.column("time_s").expect("times").to_vec();
        let power: Vec<f64> =
            time.iter().map(|t| if (t / 331.0).fract() < 0.4 { 4.0 } else { 0.0 }).collect();
        let mut felt = power[0];
        let step = 1.0 - (-(time[1] - time[0]) / LAG_S).exp();
        let readings = recording.columns.get_mut("sensor_z_nt").expect("readings");
        for (reading, power) in readings.iter_mut().zip(&power) {
            felt += step * (power - felt);
            *reading += PER_W * felt;
        }
        recording.columns.insert("heater_w".into(), serde_json::from_value(json!(power)).expect("a column"));
    }
    document
}

#[test]
fn a_housekeeping_column_is_named_as_a_dependence() {
    let found = diagnose::run(heated(), &Options::default()).expect("diagnosed");
    let words = diagnose::summary(&found);
    println!("{words}");
    let entry = found.diagnosis.expect("a diagnosis").remove(0);
    assert_eq!(entry.verdict, Verdict::Explained, "{words}");
    let [effect] = &entry.effects[..] else { panic!("{words}") };
    assert_eq!(
        (effect.effect.as_str(), effect.column.as_deref()),
        ("dependence", Some("heater_w")),
        "{words}"
    );
    assert_eq!(effect.sensor.map(|axis| axis.to_string()).as_deref(), Some("z"), "{words}");
    let within = |name: &str, truth: f64| {
        let quantity = &effect.parameters[name];
        let std = quantity.std().expect("an uncertainty");
        assert!((quantity.value() - truth).abs() < 3.0 * std && std < 0.3 * truth, "{name}: {words}");
    };
    within("z_nt_per_unit", PER_W);
    within("lag_s", LAG_S);
    let fit = entry.fit.expect("a fit");
    assert!((fit.held_out_after_nt / NOISE_NT - 1.0).abs() < 0.05, "{words}");
    let effects = found.model.expect("a model").effects;
    assert_eq!(effects.iter().map(|one| one.effect.as_str()).collect::<Vec<_>>(), ["dependence"]);
}
