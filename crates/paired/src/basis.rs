//! Orthonormal columns.

use estimate::dot;

/// A column of which the others leave less than this share of the square follows from them.
const INDEPENDENT: f64 = 1e-12;

/// Orthonormal columns that span some.
pub fn basis(columns: impl IntoIterator<Item = Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let whole = dot(&column, &column);
        basis.iter().for_each(|known| without(&mut column, known));
        let square = dot(&column, &column);
        if square > INDEPENDENT * whole {
            let size = square.sqrt();
            column.iter_mut().for_each(|value| *value /= size);
            basis.push(column);
        }
    }
    basis
}

/// Takes what is along a column of length one out of a series.
pub fn without(series: &mut [f64], column: &[f64]) {
    let part = dot(column, series);
    series.iter_mut().zip(column).for_each(|(value, along)| *value -= part * along);
}
