//! Readings of one drive count as their mean where noise with memory is declared: neighbours err together.

use common::Noise;
use nalgebra::{DMatrix, Vector3};
use std::ops::Range;

use crate::Observations;

/// Rows whose drives differ by less than this share of the largest are rows of one drive.
const SAME_DRIVE: f64 = 1e-3;
/// Of more drives than this in one recording, each reading counts by itself.
const MOST_DRIVES: usize = 400;
/// Terms of the series for the rounding that readings of one drive share; they fall as one over k².
const TERMS: usize = 40;

/// The readings of one block and the Cholesky root of their correlation.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Number of the first reading; the others follow.
    pub first: usize,
    /// L, lower triangular, L Lᵀ = correlation.
    pub root: DMatrix<f64>,
}

pub fn has_memory(noise: &Noise) -> bool {
    let sizes = [noise.flicker_nt2_per_hz_at_1hz, noise.random_walk_nt_per_sqrt_s];
    sizes.into_iter().flatten().any(|size| size > 0.0)
}

/// Rows of one drive each, one after the other, and the covariance of their means; None: each row counts.
pub fn means(
    noises: &[&Noise],
    time_s: Option<&[f64]>,
    drive_nt: &[Vector3<f64>],
    code_nt: f64,
    there: impl Fn(usize) -> bool,
) -> Option<(Vec<Range<usize>>, DMatrix<f64>)> {
    let time = time_s.filter(|time| time.len() > 1 && noises.iter().any(|noise| has_memory(noise)))?;
    let largest =
        drive_nt.iter().map(|drive| drive.amax()).filter(|size| size.is_finite()).fold(0.0, f64::max);
    let mut drives: Vec<Range<usize>> = Vec::new();
    for row in (0..drive_nt.len()).filter(|row| there(*row)) {
        match drives.last_mut() {
            Some(last) if (drive_nt[row] - drive_nt[last.start]).amax() <= SAME_DRIVE * largest => {
                last.end = row + 1;
            }
            _ => drives.push(row..row + 1),
        }
    }
    if drives.len() > MOST_DRIVES {
        return None;
    }
    let mut covariance = DMatrix::zeros(drives.len(), drives.len());
    for noise in noises {
        let part = noise::covariance_of_means(noise, Some(time), &drives, &there).ok()?;
        covariance += DMatrix::from_row_slice(drives.len(), drives.len(), &part);
    }
    let white = noises.iter().filter_map(|noise| noise.white_rms_nt).fold(0.0, f64::hypot);
    for (place, rows) in drives.iter().enumerate() {
        let count = rows.clone().filter(|row| there(*row)).count();
        covariance[(place, place)] += rounding(code_nt, white, count);
    }
    Some((drives, covariance))
}

/// Variance of the mean of n readings of one field by rounding to codes of width q, where white noise σ comes
/// before the converter: c + (q²/12 − c)/n. Their rounding has the covariance c = Σ q²/(2π²k²)
/// exp(−4π²k²σ²/q²) in common, over all fields (B. Widrow and I. Kollár, Quantization Noise, 2008, ch. 15).
fn rounding(code: f64, white: f64, count: usize) -> f64 {
    if code <= 0.0 {
        return 0.0;
    }
    let whole = code * code / 12.0;
    let spread = std::f64::consts::TAU * white / code;
    let term =
        |k: usize| (-(k as f64 * spread).powi(2)).exp() / (2.0 * (std::f64::consts::PI * k as f64).powi(2));
    let common = if white > 0.0 { code * code * (1..=TERMS).map(term).sum::<f64>() } else { whole };
    common + (whole - common) / count as f64
}

/// The blocks of what goes together, of the readings that are there.
pub fn blocks(all: &Observations) -> Vec<Block> {
    let mut blocks = Vec::new();
    for together in &all.together {
        let own = |number: &usize| {
            let reading = &all.readings[*number];
            reading.recording == together.recording && reading.sensor == together.sensor
        };
        let numbers: Vec<usize> = (0..all.readings.len()).filter(own).collect();
        let places: Vec<usize> = numbers
            .iter()
            .filter_map(|number| together.rows.iter().position(|row| *row == all.readings[*number].row))
            .collect();
        let std = |place: usize| together.covariance[(place, place)].sqrt();
        let correlation = DMatrix::from_fn(places.len(), places.len(), |i, j| {
            together.covariance[(places[i], places[j])] / (std(places[i]) * std(places[j]))
        });
        if let (Some(first), Some(root)) = (numbers.first(), correlation.cholesky()) {
            blocks.push(Block { first: *first, root: root.unpack() });
        }
    }
    blocks
}

/// L⁻¹ of each block: takes what readings have in common out of a column in units of their deviations.
pub fn whiten(blocks: &[Block], column: &mut [f64]) {
    for Block { first, root } in blocks {
        for row in 0..root.nrows() {
            let before: f64 = (0..row).map(|other| root[(row, other)] * column[first + other]).sum();
            column[first + row] = (column[first + row] - before) / root[(row, row)];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_without_noise_does_not_average_and_with_much_noise_does() {
        assert!((rounding(0.6, 0.0, 100) - 0.03).abs() < 1e-15);
        assert!((rounding(0.6, 0.6, 100) - 0.0003).abs() < 1e-15);
        for count in [1, 10] {
            assert!(
                (rounding(0.6, 1e-9, count) / 0.03 - 1.0).abs() < 0.02,
                "the series without its terms beyond 40"
            );
        }
        let some = rounding(0.6, 0.18, 1_000_000);
        // First term: q²/(2π²) exp(−4π² 0.3²).
        assert!((some / (0.36 / 19.739 * (-3.553f64).exp()) - 1.0).abs() < 0.01, "{some}");
    }

    #[test]
    fn rows_of_one_drive_make_one_mean() {
        let noise: Noise =
            serde_json::from_str(r#"{"white_rms_nt": 0.1, "flicker_nt2_per_hz_at_1hz": 0.01}"#)
                .expect("a noise");
        let drive: Vec<Vector3<f64>> =
            [0.0, 0.0, 5e4, 5e4, 5e4, -5e4].map(|field| Vector3::new(field, 0.0, 0.0)).into();
        let time = [0.0, 1.0, 12.0, 13.0, 14.0, 25.0];
        let (drives, covariance) =
            means(&[&noise], Some(&time), &drive, 0.0, |row| row != 3).expect("correlated noise");
        assert_eq!(drives, [0..2, 2..5, 5..6]);
        assert!(covariance[(0, 0)] > 0.005 && covariance[(0, 1)] != 0.0);
        assert!(means(&[&noise], None, &drive, 0.0, |_| true).is_none(), "no times, no memory");
        let white: Noise = serde_json::from_str(r#"{"white_rms_nt": 0.1}"#).expect("a noise");
        assert!(means(&[&white], Some(&time), &drive, 0.0, |_| true).is_none());
    }
}
