//! The band in which two instruments answer alike: up to where the matrix of an octave is that of longer
//! periods.

use common::covariance::between;
use estimate::positive::Positive;
use estimate::{dot, stats};
use faer::Mat;

use crate::Error;
use crate::drift::Columns;
use crate::octave::{Octave, UNKNOWNS};

/// An octave whose matrix is so improbable, over all octaves that are held against longer periods, is not
/// alike.
const DISAGREE_BELOW: f64 = 0.01;
/// The band is not narrowed to fewer coefficients.
const LEAST_KEPT: usize = 256;
/// Below so many octaves in succession that agree with longer periods nothing is left out: the longest have
/// drifts, tilts and temperatures.
const AGREED: usize = 2;
/// The lowest octave has so many at least.
const LOWEST: usize = 8;
/// The noise of the octaves and the matrix by it are fitted in turn, so often.
const ROUNDS: usize = 12;
/// The reference's axes; a straight drift is the column after them.
const AXES: usize = 3;

/// How many of the lowest cosine coefficients of a test axis, `y`, belong to periods at which the instruments
/// answer alike.
///
/// The matrix of each octave, by least squares in it, is held against that of all longer periods, weighted by
/// a noise level of each octave: filters, and noise of the reference where the field is weak, pull the matrix
/// of short periods. No form of the noise is assumed, and nothing is said of octaves in which the field is
/// not seen.
pub fn band(columns: &Columns<'_>, y: &[f64]) -> Result<usize, Error> {
    let octaves = octaves(&columns.base(), y);
    let tested = octaves.iter().filter(|(from, _)| *from >= LEAST_KEPT).count();
    let (mut kept, mut agreed) = (y.len(), 0);
    for (number, (from, octave)) in octaves.iter().enumerate().rev().take(tested) {
        let Some((eta, inverse, squares)) = octave.alone().filter(|_| octave.count > AXES as f64) else {
            continue;
        };
        let variance = squares.max(0.0) / (octave.count - AXES as f64);
        let (others, covariance) = weighted(&octaves[..number])?;
        // Probability of two matrices of independent octaves so far apart by chance.
        let sum = Mat::from_fn(AXES, AXES, |i, j| variance * inverse[(i, j)] + covariance[(i, j)]);
        let apart: [f64; AXES] = std::array::from_fn(|i| eta[i] - others[i]);
        let distance = between(&Positive::of(&sum)?.inverse, &apart, &apart);
        let p = stats::chi_squared_p(distance.max(0.0), AXES as f64);
        if p < DISAGREE_BELOW / tested as f64 {
            (kept, agreed) = (*from, 0);
        } else {
            agreed += 1;
        }
        if agreed == AGREED {
            break;
        }
    }
    Ok(kept)
}

/// From the lowest frequencies on, with the first coefficient of each.
fn octaves(columns: &[&[f64]], y: &[f64]) -> Vec<(usize, Octave)> {
    let mut edges = vec![y.len()];
    while edges[edges.len() - 1] / 2 >= LOWEST {
        edges.push(edges[edges.len() - 1] / 2);
    }
    edges.push(0);
    edges.reverse();
    let all = [&columns[..UNKNOWNS], &[y]].concat();
    let of = |edge: &[usize]| {
        let product = |i: usize, j: usize| dot(&all[i][edge[0]..edge[1]], &all[j][edge[0]..edge[1]]);
        let products = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
        (edge[0], Octave { count: (edge[1] - edge[0]) as f64, products })
    };
    edges.windows(2).map(of).collect()
}

/// Least squares of the reference's axes and a straight drift over some octaves, each weighted by what is
/// left in it.
fn weighted(octaves: &[(usize, Octave)]) -> Result<(Vec<f64>, Mat<f64>), Error> {
    let octaves = || octaves.iter().map(|(_, octave)| octave);
    let mut variances = vec![1.0; octaves().count()];
    let mut found = (Vec::new(), Mat::new());
    for _ in 0..ROUNDS {
        let sum = |i: usize, j: usize| -> f64 {
            octaves().zip(&variances).map(|(octave, variance)| octave.products[i][j] / variance).sum()
        };
        let covariance = Positive::of(&Mat::from_fn(UNKNOWNS, UNKNOWNS, sum))?.inverse;
        let right: Vec<f64> = (0..UNKNOWNS).map(|j| sum(j, UNKNOWNS)).collect();
        let coefficient = |i: usize| (0..UNKNOWNS).map(|j| covariance[(i, j)] * right[j]).sum();
        let coefficients: Vec<f64> = (0..UNKNOWNS).map(coefficient).collect();
        for (octave, variance) in octaves().zip(&mut variances) {
            let leverage: f64 = (0..UNKNOWNS)
                .flat_map(|i| (0..UNKNOWNS).map(move |j| (i, j)))
                .map(|(i, j)| covariance[(i, j)] * octave.products[i][j] / *variance)
                .sum();
            let least = f64::EPSILON * octave.products[UNKNOWNS][UNKNOWNS] / octave.count;
            let freedom = (octave.count - leverage).max(1.0);
            *variance = (octave.squares(&coefficients) / freedom).max(least).max(f64::MIN_POSITIVE);
        }
        found = (coefficients, covariance);
    }
    Ok(found)
}
