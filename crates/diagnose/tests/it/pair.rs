//! Two magnetometers side by side: the fit is what linear least squares gives.

use common::Document;
use diagnose::Options;
use estimate::linear;
use faer::Mat;
use serde_json::{Value, json};

const ROWS: usize = 400;

/// The field of an observatory, which hardly changes: offsets and matrix trade with each other over long distances.
fn field(row: usize) -> [f64; 3] {
    let t = row as f64 / ROWS as f64;
    [
        21_000.0 + 20.0 * (9.0 * t).sin(),
        900.0 + 15.0 * (23.0 * t).cos(),
        43_000.0 + 12.0 * (37.0 * t + 1.0).sin(),
    ]
}

/// A pair whose stated matrix and offsets are off, with columns that are no unit vectors; the readings of each sensor.
pub fn pair() -> (Document, Vec<Vec<f64>>) {
    let matrix = [[0.9993, 0.0134, -0.0062], [-0.0126, 1.0023, 0.0044], [0.0070, -0.0042, 0.9996]];
    let mut stream = noise::Stream::new(3, "pair");
    let readings: Vec<Vec<f64>> = (0..3)
        .map(|sensor| {
            let read = |row: usize| {
                let felt: f64 = (0..3).map(|axis| matrix[axis][sensor] * field(row)[axis]).sum();
                felt + 30.0 + 0.05 * stream.normal()
            };
            (0..ROWS).map(read).collect()
        })
        .collect();
    let mut columns = json!({"time_s": (0..ROWS).map(|row| 60.0 * row as f64).collect::<Vec<_>>()});
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let reference: Vec<f64> = (0..ROWS).map(|row| field(row)[axis]).collect();
        columns[format!("reference_{name}_nt")] = json!(reference);
        columns[format!("test_{name}_nt")] = json!(readings[axis]);
    }
    let stated = matrix.map(|row| row.map(|value| value * 1.002));
    let document: Value = json!({
        "fluxcal": 1,
        "instrument": {"noise": {"white_rms_nt": 0.05}},
        "calibration": {"differential": {"matrix": stated, "offset_nt": {"x": 0.0, "y": 0.0, "z": 0.0}}},
        "recordings": [{"id": "pair", "procedure": "differential", "columns": columns}],
    });
    (Document::parse(&document.to_string()).unwrap_or_else(|error| panic!("{error}")), readings)
}

#[test]
fn the_fit_of_a_pair_is_that_of_linear_least_squares() {
    let (document, readings) = pair();
    let design = Mat::from_fn(ROWS, 4, |row, k| if k < 3 { field(row)[k] } else { 1.0 });
    let left =
        |reading: &Vec<f64>| linear::fit(design.as_ref(), reading, None).expect("fitted").sum_of_squares;
    let by_hand = (readings.iter().map(left).sum::<f64>() / (3 * ROWS) as f64).sqrt();
    let found = diagnose::run(document, &Options::default()).expect("diagnosed");
    let entry = found.diagnosis.expect("a diagnosis").remove(0);
    let fit = entry.fit.expect("a fit");
    assert!(
        (fit.rms_refitted_nt / by_hand - 1.0).abs() < 1e-5,
        "{} where {by_hand} is reached",
        fit.rms_refitted_nt
    );
    assert!(fit.rms_before_nt > 100.0 * by_hand);
}
