//! A host that nobody recorded, for tests of the rules alone.

use recorded::{Error, Series, Stages};

use crate::hosts::Candidate;

/// It has no folder.
pub static CANDIDATE: Candidate = Candidate {
    name: "made-up",
    folder: "",
    words: "made up for a test",
    source: "none",
    offset_nt: [20_000.0, 0.0, 43_000.0],
    code_nt: 0.0,
    read: |_: &Stages| -> Result<Series, Error> { Ok(Series::default()) },
};

/// How a host is watched.
pub enum Beside {
    /// A vector magnetometer of other axes.
    Vector,
    /// A scalar magnetometer.
    Scalar,
    /// Nothing, with a thermometer.
    Thermometer,
}

/// Twelve hundred minutes with a little uneven noise.
pub fn series(beside: &Beside) -> Series {
    let rows = 1200_u32;
    let time: Vec<f64> = (0..rows).map(|row| 60.0 * f64::from(row)).collect();
    let noise = |row: usize, seed: u64| {
        let mixed = (row as u64 + 1)
            .wrapping_mul(0x9E37_79B9_7F4A_7C15)
            .wrapping_add(seed.wrapping_mul(0xD1B5_4A32_D192_ED03));
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        0.1 * ((mixed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    let wave = |t: f64, hours: f64, phase: f64| (std::f64::consts::TAU * t / (3600.0 * hours) + phase).sin();
    let moving = |t: f64| [30.0 * wave(t, 9.0, 0.0), 20.0 * wave(t, 5.0, 1.0), 10.0 * wave(t, 3.0, 2.0)];
    let vectors = |level: [f64; 3], seed: u64| -> Vec<[f64; 3]> {
        let one = |(row, t): (usize, &f64)| {
            let field = moving(*t);
            [0, 1, 2].map(|k| level[k] + field[k] + noise(row, seed + k as u64))
        };
        time.iter().enumerate().map(one).collect()
    };
    let series = Series::default().with("time_s", time.clone());
    match beside {
        Beside::Vector => series
            .with_vectors("reference", &vectors([20_000.0, 500.0, 43_000.0], 1))
            .with_vectors("test", &vectors([20_000.0, 500.0, 43_000.0], 11)),
        Beside::Scalar => {
            let length = |(row, t): (usize, &f64)| {
                let field = moving(*t);
                let full = [field[0] + 20_000.0, field[1], field[2] + 43_000.0];
                full.iter().map(|part| part * part).sum::<f64>().sqrt() + noise(row, 7)
            };
            let scalar = time.iter().enumerate().map(length).collect();
            series.with_vectors("sensor", &vectors([0.0; 3], 1)).with("reference_nt", scalar)
        }
        Beside::Thermometer => {
            let still = |row: usize| [0, 1, 2].map(|k| 21_000.0 + noise(row, 21 + k));
            let readings: Vec<[f64; 3]> = (0..time.len()).map(still).collect();
            let warm = time.iter().map(|t| 22.0 + 2.0 * wave(*t, 7.0, 0.5)).collect();
            series.with_vectors("sensor", &readings).with("sensor_temperature_c", warm)
        }
    }
}
