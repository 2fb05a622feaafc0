//! Pairs and variometers beside a scalar magnetometer, each with one cause that least squares finds at once.

use common::{Axis, Diagnosis, Document, ExplainedEffect, Quantity, Verdict};
use noise::Stream;
use serde_json::{Value, json};
use std::f64::consts::TAU;

use crate::bench::{adopted, diagnosed, near as within, parsed};

const ROWS: usize = 1440;
const STEP_S: f64 = 60.0;

/// A pair for two days of minutes: the field wanders, the test instrument has further contributions.
struct Pair {
    stream: Stream,
    field: Vec<[f64; 3]>,
}

impl Pair {
    fn new(seed: u64) -> Self {
        let mut stream = Stream::new(seed, "beside");
        let mut walk = [0.0; 3];
        let field = (0..ROWS)
            .map(|row| {
                walk = walk.map(|value| value + 0.2 * stream.normal());
                let day = |phase: f64| (TAU * row as f64 / 1440.0 + phase).sin();
                [
                    20_500.0 + 25.0 * day(0.0) + walk[0],
                    1500.0 + 15.0 * day(1.0) + walk[1],
                    44_000.0 + 10.0 * day(2.0) + walk[2],
                ]
            })
            .collect();
        Self { stream, field }
    }

    /// On and off, 40 rows each and a few more.
    fn switched(&self) -> Vec<f64> {
        (0..ROWS).map(|row| f64::from(u8::from((row / 37 + row / 101) % 2 == 0))).collect()
    }

    fn document(
        mut self,
        columns: &[(&str, Vec<f64>)],
        added: impl Fn(usize) -> [f64; 3],
        noise_nt: [f64; 2],
    ) -> Document {
        let mut all = json!({"time_s": (0..ROWS).map(|row| STEP_S * row as f64).collect::<Vec<_>>()});
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let reference: Vec<f64> =
                self.field.iter().map(|b| b[axis] + noise_nt[0] * self.stream.normal()).collect();
            let turned = |b: &[f64; 3]| 1.001 * b[axis] + 0.004 * b[(axis + 1) % 3];
            let test: Vec<f64> = self
                .field
                .iter()
                .enumerate()
                .map(|(row, b)| turned(b) + 12.0 + added(row)[axis] + noise_nt[1] * self.stream.normal())
                .collect();
            all[format!("reference_{name}_nt")] = json!(reference);
            all[format!("test_{name}_nt")] = json!(test);
        }
        for (name, values) in columns {
            all[*name] = json!(values);
        }
        document("pair", "differential", &all)
    }
}

fn document(id: &str, procedure: &str, columns: &Value) -> Document {
    parsed(&json!({"fluxcal": 1, "recordings": [{"id": id, "procedure": procedure, "columns": columns}]}))
}

fn entry(document: Document) -> Diagnosis {
    diagnosed(document).0
}

fn names(entry: &Diagnosis) -> Vec<(&str, Option<&str>)> {
    entry.effects.iter().map(|effect| (effect.effect.as_str(), effect.column.as_deref())).collect()
}

fn sensors(entry: &Diagnosis) -> Vec<(&str, Option<Axis>)> {
    entry.effects.iter().map(|effect| (effect.effect.as_str(), effect.sensor)).collect()
}

fn near(quantity: &Quantity, truth: f64) {
    within(quantity, truth, 4.0, 0.05);
}

/// A load in amperes that is switched, and what it does.
fn loaded(seed: u64) -> Document {
    let pair = Pair::new(seed);
    let load: Vec<f64> = pair.switched().iter().map(|on| 2.0 * on).collect();
    let felt = load.clone();
    let of = |row: usize| [3.0, -1.0, 2.0].map(|size| size * felt[row]);
    pair.document(&[("load_current_a", load)], of, [0.05, 0.1])
}

#[test]
fn a_load_that_is_switched_is_no_step() {
    let found = entry(loaded(1));
    assert_eq!(names(&found), [("stray_current", Some("load_current_a"))], "{}", found.answer);
    assert_eq!(found.verdict, Verdict::Explained, "{}", found.answer);
    for (name, truth) in [("x_nt_per_a", 3.0), ("y_nt_per_a", -1.0), ("z_nt_per_a", 2.0)] {
        near(&found.effects[0].parameters[name], truth);
    }
    let [family] = &found.families[..] else { panic!("one family: {:?}", found.families) };
    assert_eq!((family.family.as_str(), family.members.len()), ("follows_column", 1), "{family:?}");
    assert_eq!(family.members[0].effect, "stray_current load_current_a");
    assert!(family.probability > 0.99 && family.share > 0.99, "{family:?}");
    let fit = found.fit.expect("a fit");
    assert!(fit.rms_after_nt < 0.12 && fit.rms_refitted_nt > 1.0, "{fit:?}");
    // The rivals are told, and do not win.
    assert!(fit.plain.iter().all(|plain| fit.held_out_after_nt < 1.05 * plain.held_out_nt), "{fit:?}");
}

#[test]
fn what_was_found_is_in_the_model_and_agrees_the_next_time() {
    let (_, found) = diagnosed(loaded(8));
    assert_eq!(adopted(&found), ["stray_current load_current_a"]);
    let (answer, again) = diagnosed(found.clone());
    assert_eq!(again.model, found.model);
    assert_eq!(answer.verdict, Verdict::Agrees, "{}", answer.answer);
}

#[test]
fn a_command_that_is_logged_a_row_early_and_a_step_are_told_apart() {
    let pair = Pair::new(2);
    let acts = pair.switched();
    let mut logged = acts.clone();
    logged.rotate_left(1);
    let found = entry(pair.document(
        &[("relay_v", logged)],
        |row| [2.0 * acts[row] + if row < 800 { 0.0 } else { 1.5 }, 0.0, -acts[row]],
        [0.05, 0.1],
    ));
    assert_eq!(names(&found), [("dependence", Some("relay_v")), ("reading_step", None)], "{}", found.answer);
    let [relay, step] = &found.effects[..] else { panic!("two effects") };
    assert_eq!(relay.parameters["late_rows"].value(), -1.0, "{}", found.answer);
    near(&relay.parameters["x_nt_per_v"], 2.0);
    near(&step.parameters["x_height_nt"], 1.5);
    // A step is certain, whatever the chance of another change with time.
    let families: Vec<(&str, bool)> =
        found.families.iter().map(|one| (one.family.as_str(), one.probability > 0.99)).collect();
    assert_eq!(families, [("follows_column", true), ("time", true)], "{:?}", found.families);
    assert_eq!(step.parameters["time_s"].value(), 800.0 * STEP_S);
}

/// A level that is nowhere else, and one that was there before: both are steps.
#[test]
fn a_level_that_comes_back_is_two_steps() {
    let level = |row: usize| if (400..900).contains(&row) { 0.6 } else { 0.0 };
    let found = entry(Pair::new(41).document(&[], |row| [level(row), -0.5 * level(row), 0.0], [0.02, 0.1]));
    assert_eq!(names(&found), [("reading_step", None); 2], "{}", found.answer);
    for (row, height) in [(400.0, 0.6), (900.0, -0.6)] {
        let is_it = |step: &&ExplainedEffect| step.parameters["time_s"].value() == row * STEP_S;
        let step = found.effects.iter().find(is_it).expect("a step there");
        near(&step.parameters["x_height_nt"], height);
        near(&step.parameters["y_height_nt"], -0.5 * height);
    }
}

/// The clock was right at the beginning: a rate alone explains it.
#[test]
fn a_clock_that_gains_is_no_offset() {
    let pair = Pair::new(23);
    let field = pair.field.clone();
    let late = |row: usize| {
        [0, 1, 2].map(|axis| {
            let rows = 500e-6 * row as f64;
            let [now, before] = [row, row.saturating_sub(1)].map(|row| field[row][axis]);
            rows * (before - now)
        })
    };
    let found = entry(pair.document(&[("load_current_a", vec![0.0; ROWS])], late, [0.01, 0.01]));
    assert_eq!(names(&found), [("clock_rate", None)], "{}", found.answer);
    within(&found.effects[0].parameters["rate_ppm"], 500.0, 4.0, 50.0);
    assert!(found.answer.contains("the clock of the test instrument gains"), "{}", found.answer);
}

/// What was not recorded: each is named with its sensor, and its size found.
#[test]
fn lines_late_sensors_codes_and_bits_are_named() {
    let white = [0.02, 0.1];
    let line = |row: usize| {
        let phase = TAU * row as f64 / 17.3;
        [0.3 * phase.sin(), 0.2 * phase.cos(), -0.1 * phase.sin()]
    };
    let found = entry(Pair::new(31).document(&[], line, white));
    assert_eq!(names(&found), [("periodic_field", None)], "{}", found.answer);
    let [hz, sine] = ["frequency_hz", "x_sine_nt"].map(|name| &found.effects[0].parameters[name]);
    let apart = (hz.value() - 1.0 / (17.3 * STEP_S)).abs();
    assert!(apart < 4.0 * hz.std().expect("an uncertainty") && apart < 1e-7, "{hz}");
    near(sine, 0.3);

    // Of a field whose rate is that from row to row.
    let mut pair = Pair::new(32);
    let walk = pair.field.clone();
    for (row, field) in pair.field.iter_mut().enumerate() {
        let around = &walk[row.saturating_sub(10)..(row + 11).min(ROWS)];
        *field = [0, 1, 2].map(|axis| around.iter().map(|b| b[axis]).sum::<f64>() / around.len() as f64);
    }
    let field = pair.field.clone();
    let late = |row: usize| {
        let next = field[(row + 1).min(ROWS - 1)][2];
        [0.0, 0.0, 0.5 * 0.4 * (field[row.saturating_sub(1)][2] - next)]
    };
    let found = entry(pair.document(&[], late, [0.002, 0.005]));
    assert_eq!(sensors(&found), [("delay", Some(Axis::Z))], "{}", found.answer);
    assert_eq!(found.ambiguity, [["delay z"], ["loop_bandwidth z"]], "{}", found.answer);
    let delay = &found.effects[0].parameters["delay_s"];
    let std = delay.std().expect("an uncertainty");
    assert!((delay.value() - 0.4 * STEP_S).abs() < 4.0 * std + 0.02 * STEP_S && std < 2.0, "{delay}");

    let pair = Pair::new(33);
    let field = pair.field.clone();
    let reading =
        move |row: usize, axis: usize| 1.001 * field[row][axis] + 0.004 * field[row][(axis + 1) % 3] + 12.0;
    let bit =
        |row: usize| [0.5 * f64::from(u8::from((reading(row, 0) / 6.0).rem_euclid(1.0) < 0.5)), 0.0, 0.0];
    let found = entry(pair.document(&[], bit, [0.005, 0.05]));
    // The bit, or odd harmonics of it.
    let named = sensors(&found);
    let right = |one: &(&str, Option<Axis>)| *one == ("differential_nonlinearity", Some(Axis::X));
    assert!(!named.is_empty() && named.iter().all(right), "{}", found.answer);
    for effect in &found.effects {
        let times = 6.0 / effect.parameters["period_nt"].value();
        assert!((times - times.round()).abs() < 0.02 && times.round() as i32 % 2 == 1, "{}", found.answer);
    }
}

/// What happened to the test instrument's readings themselves.
#[test]
fn codes_frozen_readings_and_spikes_are_named() {
    let altered = |alter: &dyn Fn(usize, f64) -> f64| {
        let mut document = Pair::new(34).document(&[], |_| [0.0; 3], [0.02, 0.1]);
        let column = document.recordings[0].columns.get_mut("test_y_nt").expect("readings");
        let held: Vec<f64> = column.iter().enumerate().map(|(row, value)| alter(row, *value)).collect();
        *column = held.into();
        entry(document)
    };
    let nothing = altered(&|_, value| value);
    assert_eq!((nothing.verdict, names(&nothing)), (Verdict::Agrees, vec![]), "{}", nothing.answer);
    let coarse = altered(&|_, value| 1.7 * (value / 1.7).round());
    assert_eq!(sensors(&coarse), [("quantisation", Some(Axis::Y))], "{}", coarse.answer);
    assert!((coarse.effects[0].parameters["width_nt"].value() - 1.7).abs() < 0.01, "{}", coarse.answer);
    let first = std::cell::Cell::new(0.0);
    let frozen = altered(&|row, value| {
        first.set(if (600..630).contains(&row) { first.get() } else { value });
        first.get()
    });
    assert_eq!(sensors(&frozen), [("dropout", Some(Axis::Y))], "{}", frozen.answer);
    let parameters = &frozen.effects[0].parameters;
    let [from, lasts] = ["time_s", "duration_s"].map(|name| parameters[name].value() / STEP_S);
    assert_eq!((from, lasts), (599.0, 30.0));
    let spike = altered(&|row, value| if row == 700 { value + 5.0 } else { value });
    assert_eq!(sensors(&spike), [("spike", Some(Axis::Y))], "{}", spike.answer);
    assert!((spike.effects[0].parameters["height_nt"].value() - 5.0).abs() < 0.5, "{}", spike.answer);
}

/// A current that is known by its power: one name, and no steps.
#[test]
fn a_root_of_a_column_is_one_name() {
    let wave = |row: usize| (TAU * row as f64 / 400.0).sin();
    let power: Vec<f64> = (0..ROWS).map(|row| 30.0 * wave(row).max(0.0)).collect();
    let felt = power.clone();
    let root = |row: usize| felt[row].powf(0.6);
    let of = |row: usize| [2.0, -1.0, 0.5].map(|size| size * root(row));
    let found = entry(Pair::new(21).document(&[("panel_power_w", power)], of, [0.02, 0.05]));
    assert_eq!(names(&found), [("dependence", Some("panel_power_w"))], "{}", found.answer);
    let exponent = found.effects[0].parameters["exponent"].value();
    assert!(exponent == 0.5 || exponent == 2.0 / 3.0, "{}", found.answer);
}

#[test]
fn noise_of_the_reference_is_no_name() {
    for (seed, reference_nt) in [(3, 0.05), (4, 0.1), (5, 0.3), (6, 1.0)] {
        let pair = Pair::new(seed);
        let day: Vec<f64> = (0..ROWS).map(|row| 20.0 + 5.0 * (TAU * row as f64 / 1440.0).sin()).collect();
        let columns = [("load_current_a", pair.switched()), ("test_temperature_c", day)];
        let found = entry(pair.document(&columns, |_| [0.0; 3], [reference_nt, 0.1]));
        assert_eq!(found.verdict, Verdict::Agrees, "{reference_nt}: {}", found.answer);
    }
}

#[test]
fn a_variometer_beside_a_scalar_agrees_and_its_temperature_is_named() {
    for (coefficient, stated) in [(0.0, false), (0.08, false), (0.08, true)] {
        let Pair { mut stream, field } = Pair::new(7);
        let main = [20_500.0, 1500.0, 44_000.0];
        let heat = |row: usize| 3.0 * (TAU * row as f64 / 1000.0).sin();
        let mut columns = json!({
            "time_s": (0..ROWS).map(|row| STEP_S * row as f64).collect::<Vec<_>>(),
            "sensor_temperature_c": (0..ROWS).map(|row| 20.0 + heat(row)).collect::<Vec<_>>(),
        });
        let scalar = |b: &[f64; 3]| b.iter().map(|b| b * b).sum::<f64>().sqrt() + 0.015 * stream.normal();
        columns["reference_nt"] = json!(field.iter().map(scalar).collect::<Vec<_>>());
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let read = |(row, b): (usize, &[f64; 3])| {
                let own = if axis == 2 { coefficient * heat(row) } else { 0.0 };
                b[axis] - main[axis] + 300.0 + own + 0.01 * stream.normal()
            };
            columns[format!("sensor_{name}_nt")] =
                json!(field.iter().enumerate().map(read).collect::<Vec<_>>());
        }
        let mut document = document("hut", "free_run", &columns);
        if stated {
            let parameters = json!({"coefficient_nt_per_k": coefficient, "curvature_nt_per_k2": 0.0});
            let effect = json!({"effect": "offset_temperature", "sensor": "z", "parameters": parameters});
            document.model = serde_json::from_value(json!({"effects": [effect]})).expect("a model");
            let at = json!({"reference_conditions": {"sensor_temperature_c": 20.0}});
            document.calibration = serde_json::from_value(at).expect("a calibration");
        }
        let found = entry(document);
        if coefficient == 0.0 || stated {
            assert_eq!(found.verdict, Verdict::Agrees, "{}", found.answer);
        } else {
            assert_eq!(names(&found), [("dependence", Some("sensor_temperature_c"))], "{}", found.answer);
            let size = main.iter().map(|b: &f64| b * b).sum::<f64>().sqrt();
            near(&found.effects[0].parameters["along_field_nt_per_k"], -coefficient * main[2] / size);
        }
        let fit = found.fit.expect("a fit");
        assert!(fit.rms_after_nt < 0.021, "{fit:?}");
    }
}

/// A load that nobody recorded passes for noise only where nobody declared that.
#[test]
fn more_than_the_declared_noise_is_unexplained() {
    for (load, declared, verdict) in
        [(0.0, true, Verdict::Agrees), (1.0, true, Verdict::Unexplained), (1.0, false, Verdict::Agrees)]
    {
        let pair = Pair::new(61);
        let on = pair.switched();
        let mut document = pair.document(&[], |row| [load * on[row], 0.0, -load * on[row]], [0.05, 0.1]);
        if declared {
            let noise = |nt: f64| serde_json::from_value(json!({"white_rms_nt": nt})).expect("a noise");
            document.instrument.get_or_insert_default().noise = noise(0.1);
            document.recordings[0].conditions.reference_noise = noise(0.05);
        }
        let found = entry(document);
        assert_eq!(found.verdict, verdict, "{load} {declared}: {}", found.answer);
    }
}
