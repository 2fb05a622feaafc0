//! What a fresh calibration leaves of a series added to a host's readings: the measure of the sizes.

use concealed::base;
use concealed::scene::{AXES, Readings};
use recorded::least_squares;

use crate::host::{Host, Watched};

/// What is left of `added` when all constants of the basic model are fitted to it, nT, sensor by sensor; of what is held against a scalar
/// magnetometer one column, the change of the vector's length less a level and slopes along the three readings, which is all that nine
/// constants do where the field points one way.
pub fn left(host: &Host, added: &Readings) -> Vec<Vec<f64>> {
    match host.watched {
        Watched::Vectors => base::left(&host.centred, added).into_iter().flatten().collect(),
        Watched::Length => vec![without_plane(host, &longer(host, added))],
    }
}

/// How much longer the vector gets, nT, row by row.
fn longer(host: &Host, added: &Readings) -> Vec<f64> {
    let length = |v: [f64; 3]| v.iter().map(|part| part * part).sum::<f64>().sqrt();
    let row = |row: usize| {
        let field = [0, 1, 2].map(|k| host.plain[0][k][row] + host.campaign.bench.offset_nt[k]);
        length([0, 1, 2].map(|k| field[k] + added[0][k][row])) - length(field)
    };
    (0..host.rows()).map(row).collect()
}

/// A column less its level and its slopes along the three readings.
pub fn without_plane(host: &Host, column: &[f64]) -> Vec<f64> {
    let mut design = vec![vec![1.0; column.len()]];
    for k in 0..AXES.len() {
        let readings = &host.plain[0][k];
        let mean = readings.iter().sum::<f64>() / readings.len().max(1) as f64;
        design.push(readings.iter().map(|value| value - mean).collect());
    }
    let Some(found) = least_squares(&design, column) else { return column.to_vec() };
    let plane = |row: usize| design.iter().zip(&found).map(|(one, c)| c * one[row]).sum::<f64>();
    column.iter().enumerate().map(|(row, value)| value - plane(row)).collect()
}

/// Rms of what is left in the sensor that keeps most of it, nT.
pub fn size(host: &Host, added: &Readings) -> f64 {
    left(host, added).iter().map(|column| rms(column)).fold(0.0, f64::max)
}

/// Root of the mean of squares.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
