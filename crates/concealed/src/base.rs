//! What a fresh calibration takes up of an effect.

use nalgebra::{DMatrix, DVector};

use crate::scene::{Campaign, Readings, World};

/// Least singular value that counts, over the largest.
const LEAST: f64 = 1e-9;

/// What is left of an effect when all constants of the basic model are fitted to it by least squares: for
/// coils
///
/// ```text
/// δM_i = Σ_j a_ij B_j + o_i + (R (C I + e))_i
/// ```
///
/// with the nine a (sensitivities and axes), three offsets o, nine C (coil constants and axes) and three e
/// (coil offsets) free, B in SEN; without coils the a and o alone.
pub fn left(campaign: &Campaign, effect: &Readings) -> Readings {
    let coils = campaign.runs.iter().any(|run| matches!(run.world, World::Coils(_)));
    let width = if coils { 24 } else { 12 };
    let rows: usize = campaign.runs.iter().map(|run| 3 * run.times.len()).sum();
    let (mut columns, mut target) = (DMatrix::zeros(rows, width), DVector::zeros(rows));
    let mut at = 0;
    for (run, effect) in campaign.runs.iter().zip(effect) {
        for (row, &t) in run.times.iter().enumerate() {
            let field = run.field_sen(&campaign.bench, t);
            let turn = (run.attitude)(t);
            for sensor in 0..3 {
                target[at] = effect[sensor][row];
                (0..3).for_each(|j| columns[(at, 3 * sensor + j)] = field[j]);
                columns[(at, 9 + sensor)] = 1.0;
                if coils {
                    for (a, b) in (0..9).map(|k| (k / 3, k % 3)) {
                        let current = run.current(b).map_or(0.0, |current| current(t));
                        columns[(at, 12 + 3 * a + b)] = turn[(sensor, a)] * current;
                    }
                    (0..3).for_each(|a| columns[(at, 21 + a)] = turn[(sensor, a)]);
                }
                at += 1;
            }
        }
    }
    for mut column in columns.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 {
            column /= norm;
        }
    }
    let moments = columns.tr_mul(&columns).symmetric_eigen();
    let projected = moments.eigenvectors.tr_mul(&columns.tr_mul(&target));
    let largest = moments.eigenvalues.max();
    let solved = DVector::from_fn(width, |k, _| {
        let value = moments.eigenvalues[k];
        if value > LEAST * largest { projected[k] / value } else { 0.0 }
    });
    let rest = target - &columns * (&moments.eigenvectors * solved);
    let mut rest = rest.iter();
    let mut all: Readings =
        effect.iter().map(|run| run.clone().map(|column| vec![0.0; column.len()])).collect();
    for run in &mut all {
        for row in 0..run[0].len() {
            run.iter_mut().for_each(|column| column[row] = rest.next().copied().unwrap_or(0.0));
        }
    }
    all
}

/// Rms of each sensor over all runs.
pub fn rms(readings: &Readings) -> [f64; 3] {
    std::array::from_fn(|sensor| {
        let all = || readings.iter().flat_map(|run| run[sensor].iter());
        (all().map(|v| v * v).sum::<f64>() / all().count().max(1) as f64).sqrt()
    })
}

/// Rms of what is left in the sensor that keeps most of it.
pub fn size_left(campaign: &Campaign, effect: &Readings) -> f64 {
    rms(&left(campaign, effect)).into_iter().fold(0.0, f64::max)
}
