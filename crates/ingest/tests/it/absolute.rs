//! Absolute measurements: what the documents hold is what the model read that wrote the sheets
//! (fixtures/reference/absolute_sheet.py); several files, and files that do not go together.

use common::{Document, Recording};
use ingest::{Ingested, Options, guess, run};
use std::path::PathBuf;

const ALL: [&str; 4] = ["absolute-gon.txt", "absolute-deg.txt", "absolute-null.txt", "absolute.json"];

fn read(files: &[&str], document: Document, options: &Options) -> Result<Ingested, String> {
    let files: Vec<PathBuf> = files.iter().map(|name| testkit::fixture("ingest").join(name)).collect();
    run(document, &files, options).map_err(|error| error.to_string())
}

fn empty() -> Document {
    Document { fluxcal: 1, ..Document::default() }
}

/// What the theodolite's magnetometer reads with the circle at that azimuth, degrees, and the telescope at that
/// zenith angle: S0 + n·B with n = t + δ h + ε w.
fn reading_nt(azimuth: f64, zenith: f64) -> f64 {
    let (declination, inclination) = (4.25_f64.to_radians(), 64.5_f64.to_radians());
    let (h, z) = (48_600.0 * inclination.cos(), 48_600.0 * inclination.sin());
    let (x, y) = (h * declination.cos(), h * declination.sin());
    let ((sin_a, cos_a), (sin_v, cos_v)) = (azimuth.to_radians().sin_cos(), zenith.to_radians().sin_cos());
    let along = sin_v * cos_a * x + sin_v * sin_a * y - cos_v * z;
    let across = -sin_a * x + cos_a * y;
    let upward = cos_v * cos_a * x + cos_v * sin_a * y + sin_v * z;
    5.0 + along + 1e-4 * across + 1.2e-3 * upward
}

/// Compares each reading of the field. Sheets round it to 0.1 nT, and the circles and the mark to at most 1″, of which
/// half is 0.12 nT in the field of 48 600 nT and 0.05 nT in H: 0.05 + 0.12 + 2 · 0.05 nT. The number of readings.
fn check(recording: &Recording) -> usize {
    let column = |name: &str| recording.column(name).unwrap_or_else(|| panic!("{}: {name}", recording.id));
    let (horizontal, vertical) = (column("horizontal_deg"), column("vertical_deg"));
    let (residual, direction) = (column("residual_nt"), column("direction_deg"));
    let turned = |row: usize| if vertical[row] > 180.0 { 180.0 } else { 0.0 };
    let is_mark = |row: &usize| residual[*row].is_nan() && !horizontal[*row].is_nan();
    let marks =
        (0..residual.len()).filter(is_mark).map(|row| (horizontal[row] + turned(row)).rem_euclid(360.0));
    let marks: Vec<f64> = marks.collect();
    let azimuth = recording
        .conditions
        .quantity("mark_azimuth_deg", "")
        .expect("a condition")
        .expect("an azimuth")
        .value();
    let zero = azimuth - marks.iter().sum::<f64>() / marks.len() as f64;
    let mut count = 0;
    for row in (0..residual.len()).filter(|row| !residual[*row].is_nan()) {
        let circle = if horizontal[row].is_nan() {
            4.25 + direction[row] + turned(row)
        } else {
            horizontal[row] + zero
        };
        let expected = reading_nt(circle, vertical[row]);
        assert!(
            (residual[row] - expected).abs() < 0.27,
            "{}, row {row}: {} {expected}",
            recording.id,
            residual[row]
        );
        count += 1;
    }
    count
}

#[test]
fn each_reading_is_that_of_the_model() {
    let mut ingested = read(&ALL, empty(), &Options::default()).expect("recordings");
    let recordings = &ingested.document.recordings;
    let ids: Vec<&str> = recordings.iter().map(|recording| recording.id.as_str()).collect();
    let expected = "2025-03-14-0900 2025-03-14-0910 2025-03-14-0915 2025-03-14-1010 2025-03-14-1210";
    assert_eq!(ids.join(" "), expected);
    assert!(recordings.iter().all(|recording| recording.procedure == "absolute"));
    assert_eq!(recordings.iter().map(check).sum::<usize>(), 2 * 17 + 3 * 8);
    assert_eq!(testkit::ill_written(&ingested.words), Vec::<String>::new());
    // A document that was written is read again.
    let text = ingested.document.to_text().expect("a document");
    assert_eq!(Document::parse(&text).expect("a document").recordings.len(), 5);
}

#[test]
fn with_others_and_twice() {
    let ingested = read(&["flx20240310a.min"], empty(), &Options::default()).expect("a series");
    let both = read(&ALL[..1], ingested.document, &Options::default()).expect("both").document;
    assert_eq!(both.recordings.len(), 2);
    let twice = read(&ALL[..1], both.clone(), &Options { id: Some("again".into()), ..Options::default() });
    assert_eq!(twice.expect("another id").document.recordings[2].id, "again");
    let clash = Options { id: Some("flx-2024-03-10".into()), ..Options::default() };
    let renamed = read(&ALL[..1], both.clone(), &clash).expect("the pillar").document;
    assert_eq!(renamed.recordings[2].id, "flx-2024-03-10-P1");
    assert!(read(&ALL[..1], renamed, &clash).expect_err("twice").contains("each measurement once"));
    let mixed =
        read(&["absolute-deg.txt", "flx20240310a.min"], both, &Options::default()).expect_err("a series");
    assert!(
        mixed.contains("flx20240310a.min holds no absolute measurement as the other files do"),
        "{mixed}"
    );
}

#[test]
fn no_mapping_is_guessed_for_a_sheet() {
    let refused = guess(&testkit::fixture("ingest/absolute-deg.txt"), "sensor").err().expect("a refusal");
    assert!(refused.to_string().contains("absolute measurements need no mapping: ingest FILE"), "{refused}");
}
