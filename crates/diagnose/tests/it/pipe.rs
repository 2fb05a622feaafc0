//! The program as its users call it.

use crate::bench::{Scene, noise, scaled, simulated};
use common::{Axis, Document};
use std::process::Command;

fn diagnose(arguments: &[&str], threads: &str) -> (Vec<u8>, String, Option<i32>) {
    let output = Command::new(env!("CARGO_BIN_EXE_diagnose"))
        .args(arguments)
        .env("RAYON_NUM_THREADS", threads)
        .current_dir(testkit::fixture(".."))
        .output()
        .expect("run");
    (output.stdout, String::from_utf8_lossy(&output.stderr).into_owned(), output.status.code())
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
    let document = Document::parse(&String::from_utf8(out).expect("text")).expect("a document");
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

/// A simulation made elsewhere takes the place of the prediction: against one with the effect, nothing is
/// left.
#[test]
fn against_a_simulation() {
    let expected = testkit::read_fixture("diagnose/warm/expected.json");
    let document = Document::parse(&expected).expect("a document");
    let simulated = simulate::replay(&document, None).expect("replayed").document;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("simulated.json");
    std::fs::write(&file, common::to_text(&simulated)).expect("written");
    let file = file.to_str().expect("a path");
    let (out, words, code) = diagnose(&["fixtures/diagnose/warm/input.json", "--against", file], "2");
    assert_eq!(code, Some(0), "{words}");
    assert!(words.starts_with("diagnose: agrees"), "{words}");
    let found = Document::parse(&String::from_utf8(out).expect("text")).expect("a document");
    assert_eq!(
        found.recordings,
        Document::parse(&testkit::read_fixture("diagnose/warm/input.json")).expect("a document").recordings
    );

    let (out, words, code) = diagnose(&["fixtures/nasa-1977/table-4.json", "--against", file], "2");
    assert!(out.is_empty() && code == Some(2), "{words}");
    assert!(words.contains("the simulation has none of the document's recordings"), "{words}");
}

/// What is adopted holds without the recordings that it came from: it is relative to a temperature that is
/// stated.
#[test]
fn the_reference_temperature_is_stated() {
    let mut document =
        Document::parse(&testkit::read_fixture("diagnose/warm/input.json")).expect("a document");
    document.calibration.as_mut().expect("a calibration").reference_conditions = None;
    let temperatures: Vec<f64> = document
        .recordings
        .iter()
        .flat_map(|recording| recording.column("sensor_temperature_c").expect("temperatures").to_vec())
        .collect();
    let mean = temperatures.iter().sum::<f64>() / temperatures.len() as f64;
    let found = diagnose::run(document, &diagnose::Options::default()).expect("diagnosed");
    let stated = found.calibration.as_ref().and_then(|calibration| calibration.reference_conditions.as_ref());
    let stated = stated.and_then(|stated| stated.sensor_temperature_c);
    assert!(stated.is_some_and(|stated| (stated - mean).abs() < 1e-9), "{stated:?} where the mean is {mean}");
}

/// Directions that were fitted again keep an uncertainty, and its covariance is over the cosines: none along
/// a direction itself.
#[test]
fn directions_have_their_covariance() {
    let document = Document::parse(&testkit::read_fixture("diagnose/orbit/input.json")).expect("a document");
    let found = diagnose::run(document, &diagnose::Options::default()).expect("diagnosed");
    let axes = found.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let sensors = axes.and_then(|axes| axes.sensors.as_ref()).expect("directions");
    let (matrix, covariance) = (sensors.matrix.expect("a matrix"), sensors.covariance.as_ref().expect("one"));
    for axis in [common::Axis::Y, common::Axis::Z] {
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
    found.clone().to_text().expect("readings");
}

/// Constants of coils that were fitted again keep the covariance of the fit and lose that of before.
#[test]
fn constants_of_coils_have_their_covariance() {
    let heating = serde_json::json!({"effect": "coil_heating", "coil": "x", "parameters": {"fall_ppm_per_a2": 50.0, "lag_s": 600.0}});
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
    let found = diagnose::run(document, &diagnose::Options::default()).expect("diagnosed");
    let coil = |calibration: &Option<common::Calibration>, axis| {
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
