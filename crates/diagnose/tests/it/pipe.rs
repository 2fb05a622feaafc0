//! The program as its users call it.

use common::{Axis, Calibration, Document, to_text};
use serde_json::{Value, json};
use std::process::Command;

use crate::bench::{Scene, diagnosed, fixture, noise, scaled, simulated};

const DIAGNOSE: &str = env!("CARGO_BIN_EXE_diagnose");

fn diagnose(arguments: &[&str], threads: &str) -> (String, String, Option<i32>) {
    let mut program = Command::new(DIAGNOSE);
    program.args(arguments).env("RAYON_NUM_THREADS", threads).current_dir(testkit::fixture(".."));
    let output = program.output().expect("run");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (text(output.stdout), text(output.stderr), output.status.code())
}

/// BLESS=1 writes the documents anew; read the difference before it is kept.
#[test]
fn golden() {
    for (name, input) in [
        ("warm", "diagnose/warm/input.json"),
        ("delay", "diagnose/delay/input.json"),
        ("orbit", "diagnose/orbit/input.json"),
        ("warm-again", "diagnose/warm/expected.json"),
    ] {
        testkit::golden(&format!("diagnose/{name}"), input, |_| to_text(&diagnosed(fixture(input)).1));
    }
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(DIAGNOSE, "diagnose/warm/input.json");
}

/// The examples in the help texts run as they stand; completions and man pages are there.
#[test]
fn examples_and_manual() {
    testkit::examples(DIAGNOSE, &[]);
    testkit::manual(DIAGNOSE);
}

/// Every document of `fixtures/bad/diagnose` brings its message, its exit code, and nothing on standard output.
#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/diagnose", DIAGNOSE) >= 14);
}

/// Nothing is written, and a message says why.
#[test]
fn requests_that_make_no_sense() {
    for (option, value, message) in [
        ("--level", "1.5", "a level of 1.5; expected a probability"),
        ("--against", "nowhere.json", "nowhere.json"),
        (
            "--against",
            "fixtures/bad/diagnose/two-rows.json",
            "found 120 rows where the simulation of \"run-1\" has 2",
        ),
        (
            "--against",
            "fixtures/coilcal/uneven/input.json",
            "the simulation has none of the document's recordings",
        ),
        ("--without", "delays", "there is no effect \"delays\"; expected one of quadratic_nonlinearity"),
    ] {
        let (out, words, code) = diagnose(&[option, value, "fixtures/diagnose/warm/input.json"], "2");
        assert!(out.is_empty() && code != Some(0) && words.contains(message), "{words}");
    }
}

/// What cannot be used is told, and the rest is diagnosed.
#[test]
fn what_is_left_aside_is_told() {
    let mut document: Value =
        serde_json::from_str(&testkit::read_fixture("diagnose/warm/input.json")).expect("JSON");
    document["model"] = json!({"effects": [{"effect": "coil_temperature", "coil": "x", "parameters": {"coefficient_ppm_per_k": 1.0}}]});
    document["calibration"]["reference_conditions"]["coil_temperature_c"] = json!(21.0);
    let recording = &mut document["recordings"][0];
    recording["columns"].as_object_mut().expect("columns").remove("coil_temperature_c");
    recording["columns"]["time_s"][3] = Value::Null;
    document["recordings"].as_array_mut().expect("recordings").truncate(1);
    let run = testkit::run(DIAGNOSE, &[], &document.to_string());
    assert_eq!(run.code, 0, "{}", run.stderr);
    for told in
        ["note: coil_temperature x of model.effects acts in no recording", "note: the times of \"run-1\""]
    {
        assert!(run.stderr.contains(told), "{}", run.stderr);
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let one = diagnose(&["fixtures/diagnose/warm/input.json"], "1");
    let four = diagnose(&["fixtures/diagnose/warm/input.json"], "4");
    assert!(one.2 == Some(0) && one == four);
    assert!(one.1.contains("offset_temperature_lag of sensor x"), "{}", one.1);
    // README and page show what is said.
    for page in ["../README.md", "../docs/diagnose.md"] {
        let page = std::fs::read_to_string(testkit::fixture(page)).expect("a page");
        let shown = page.lines().skip_while(|line| !line.trim().starts_with("diagnose: explained"));
        let shown: Vec<&str> = shown.take(4).collect();
        assert_eq!(shown.len(), 4);
        for line in shown {
            assert!(one.1.contains(line.trim()), "{line}\n{}", one.1);
        }
    }
}

#[test]
fn an_effect_that_is_known_not_to_act_is_not_named() {
    let (out, words, code) =
        diagnose(&["--without", "offset_temperature", "fixtures/diagnose/warm/input.json"], "2");
    assert!(code == Some(0) && words.starts_with("diagnose: unexplained"), "{words}");
    let document = Document::parse(&out).expect("a document");
    let entry = &document.diagnosis.as_ref().expect("a diagnosis")[0];
    let unnamed: Vec<_> = entry.unnamed.iter().map(|one| one.sensor).collect();
    assert_eq!(unnamed, [Some(Axis::X)]);
    let arguments = &document.history.last().expect("an entry").arguments;
    assert!(arguments.contains(&"--without=offset_temperature".to_string()), "{arguments:?}");
}

#[test]
fn a_document_without_readings_is_refused_with_nothing_on_stdout() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("empty.json");
    std::fs::write(&file, r#"{"fluxcal": 1, "recordings": []}"#).expect("written");
    let (out, words, code) = diagnose(&[file.to_str().expect("a path")], "2");
    assert!(out.is_empty() && code == Some(2), "{words}");
    assert!(words.contains("no recording whose readings can be predicted"), "{words}");
}

/// A simulation takes the place of the prediction: against one with the effect, nothing is left.
#[test]
fn against_a_simulation() {
    let simulated =
        simulate::replay(&fixture("diagnose/warm/expected.json"), None).expect("replayed").document;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("simulated.json");
    std::fs::write(&file, to_text(&simulated)).expect("written");
    let file = file.to_str().expect("a path");
    let (out, words, code) = diagnose(&["fixtures/diagnose/warm/input.json", "--against", file], "2");
    assert_eq!(code, Some(0), "{words}");
    assert!(words.starts_with("diagnose: agrees"), "{words}");
    let found = Document::parse(&out).expect("a document");
    assert_eq!(found.recordings, fixture("diagnose/warm/input.json").recordings);
}

/// What is adopted holds without its recordings: it is relative to a temperature that is stated.
#[test]
fn the_reference_temperature_is_stated() {
    let mut document = fixture("diagnose/warm/input.json");
    document.calibration.as_mut().expect("a calibration").reference_conditions = None;
    let temperatures: Vec<f64> = document
        .recordings
        .iter()
        .flat_map(|recording| recording.column("sensor_temperature_c").expect("temperatures").to_vec())
        .collect();
    let mean = temperatures.iter().sum::<f64>() / temperatures.len() as f64;
    let (_, found) = diagnosed(document);
    let stated = found.calibration.as_ref().and_then(|calibration| calibration.reference_conditions.as_ref());
    let stated = stated.and_then(|stated| stated.sensor_temperature_c);
    assert!(stated.is_some_and(|stated| (stated - mean).abs() < 1e-9), "{stated:?} where the mean is {mean}");
}

/// Directions keep an uncertainty whose covariance is over the cosines: none along a direction itself.
#[test]
fn directions_have_their_covariance() {
    let (_, found) = diagnosed(fixture("diagnose/orbit/input.json"));
    let axes = found.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let sensors = axes.and_then(|axes| axes.sensors.as_ref()).expect("directions");
    let (matrix, covariance) = (sensors.matrix.expect("a matrix"), sensors.covariance.as_ref().expect("one"));
    for axis in [Axis::Y, Axis::Z] {
        let std = sensors.std_arcsec.as_ref().and_then(|std| std.get(axis)).expect("an uncertainty");
        let (column, first) = (axis.index(), 3 * axis.index());
        let variance: f64 = (0..3).map(|k| covariance[first + k][first + k]).sum();
        let arcsec = variance.sqrt() * 206_264.806;
        assert!(std > 0.0 && (0.999 * std..=1.5 * std).contains(&arcsec), "{arcsec} and {std}");
        let along: f64 = (0..9)
            .map(|k| (k / 3, k % 3))
            .map(|(i, j)| matrix[i][column] * covariance[first + i][first + j] * matrix[j][column])
            .sum();
        assert!(along.abs() < 1e-9 * variance, "{along} of {variance}");
    }
}

/// Constants of coils that were fitted again keep the covariance of the fit and lose that of before.
#[test]
fn constants_of_coils_have_their_covariance() {
    let heating = json!({"effect": "coil_heating", "coil": "x", "parameters": {"fall_ppm_per_a2": 50.0, "lag_s": 600.0}});
    let mut document = simulated(Scene::Runs, &[scaled(Scene::Runs, &heating, 3.0)], &noise(), 41);
    let stale = vec![vec![4.0, 0.0], vec![0.0, 9.0]];
    let coils =
        document.calibration.as_mut().and_then(|calibration| calibration.coils.as_mut()).expect("coils");
    for axis in Axis::ALL {
        let coil = coils.entry(axis).as_mut().expect("a coil");
        coil.covariance = Some(stale.clone());
        coil.covariance_order = Some(vec!["constant_nt_per_a".into(), "offset_nt".into()]);
    }
    let before = document.calibration.clone();
    let (_, found) = diagnosed(document);
    let coil = |calibration: &Option<Calibration>, axis| {
        calibration.as_ref().and_then(|all| all.coils.as_ref()?.get(axis).cloned()).expect("a coil")
    };
    let mut moved = 0;
    for axis in Axis::ALL {
        let (old, new) = (coil(&before, axis), coil(&found.calibration, axis));
        if (&old.constant_nt_per_a, &old.offset_nt) == (&new.constant_nt_per_a, &new.offset_nt) {
            assert_eq!(new.covariance, old.covariance, "{axis}");
            continue;
        }
        moved += 1;
        let Some(covariance) = new.covariance else { continue };
        for (row, quantity) in [new.constant_nt_per_a, new.offset_nt].into_iter().enumerate() {
            let variance = quantity.and_then(|quantity| quantity.std()).expect("an uncertainty").powi(2);
            assert!((covariance[row][row] / variance - 1.0).abs() < 1e-9, "{axis}: {covariance:?}");
        }
    }
    assert!(moved > 0, "no coil was fitted again");
}

/// The report's Table 4: the values that were misprinted are located, and nothing else is claimed.
#[test]
fn the_wrong_values_of_table_4_are_located() {
    let document = axescal::run(fixture("nasa-1977/table-4.json"), &axescal::Options::default());
    let (entry, _) = diagnosed(document.expect("directions"));
    let readings = entry.places.iter().flat_map(|share| &share.readings);
    let readings: Vec<(&str, &str, usize)> =
        readings.map(|reading| (reading.recording.as_str(), reading.column.as_str(), reading.row)).collect();
    // The 29th: orientation 4, coil 1, sensor 2. The 4th, which the scan has wrong: orientation 1, coil 2,
    // sensor 1.
    for wrong in [("orientation-4", "sensor_y_v", 0), ("orientation-1", "sensor_x_v", 1)] {
        assert!(readings.contains(&wrong), "{readings:?}");
    }
    let [spikes] = &entry.effects[..] else { panic!("{:?}", entry.effects) };
    assert_eq!(spikes.list.len(), readings.len(), "{:?}", spikes.list);
}
