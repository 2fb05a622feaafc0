//! One vector magnetometer against another.

use concealed::scene::AXES;
use nalgebra::Matrix3;
use recorded::{Series, least_squares};

use crate::stats::mean;

/// Matrix and offsets of test = R η + d by plain least squares: the calibration that the document states.
pub fn matrix(series: &Series) -> Option<(Matrix3<f64>, [f64; 3])> {
    let mut columns = vec![vec![1.0; series.rows()]];
    let mut means = [0.0; 3];
    for (k, axis) in AXES.iter().enumerate() {
        let readings = series.column(&format!("reference_{axis}_nt"));
        means[k] = mean(readings);
        columns.push(readings.iter().map(|value| value - means[k]).collect());
    }
    let (mut eta, mut offset) = (Matrix3::identity(), [0.0; 3]);
    for (j, axis) in AXES.iter().enumerate() {
        let found = least_squares(&columns, series.column(&format!("test_{axis}_nt")))?;
        (0..3).for_each(|i| eta[(i, j)] = found[i + 1]);
        offset[j] = found[0] - (0..3).map(|i| found[i + 1] * means[i]).sum::<f64>();
    }
    Some((eta, offset))
}
