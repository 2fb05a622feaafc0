//! The length of the vector, which is all that a scalar magnetometer tells of it.

use recorded::least_squares;

use crate::stats::mean;

/// How much longer the vector gets by what is added to the readings, nT, row by row.
pub fn longer(readings: &[Vec<f64>; 3], offset_nt: [f64; 3], added: &[Vec<f64>; 3]) -> Vec<f64> {
    let length = |v: [f64; 3]| v.iter().map(|part| part * part).sum::<f64>().sqrt();
    let row = |row: usize| {
        let field = [0, 1, 2].map(|k| readings[k][row] + offset_nt[k]);
        length([0, 1, 2].map(|k| field[k] + added[k][row])) - length(field)
    };
    (0..readings[0].len()).map(row).collect()
}

/// A column less its level and its slopes along the three readings.
pub fn without_plane(readings: &[Vec<f64>; 3], column: &[f64]) -> Vec<f64> {
    let mut design = vec![vec![1.0; column.len()]];
    for readings in readings {
        let mean = mean(readings);
        design.push(readings.iter().map(|value| value - mean).collect());
    }
    let Some(found) = least_squares(&design, column) else { return column.to_vec() };
    let plane = |row: usize| design.iter().zip(&found).map(|(one, c)| c * one[row]).sum::<f64>();
    column.iter().enumerate().map(|(row, value)| value - plane(row)).collect()
}
