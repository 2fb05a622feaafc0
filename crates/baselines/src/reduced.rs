//! The columns of each group as few that are orthonormal: lags of a grid and powers of a temperature run
//! together.
//!
//! Source: Simon & Tibshirani 2012, Standardization and the group lasso penalty, Statistica Sinica 22, 983.

use diagnose::{Dictionary, Error};
use estimate::screen::Screen;
use faer::{Mat, Side};
use std::ops::Range;

use crate::Combination;

/// A direction that holds less than this share of the squared length of a group's largest is left out.
const LEAST: f64 = 1e-4;
/// A column of which the calibration leaves less than this share of the squared length is left out.
pub const VISIBLE: f64 = 1e-9;

/// The columns of all groups.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// Those of each group of the dictionary; empty where the calibration leaves nothing of it.
    pub groups: Vec<Range<usize>>,
    /// What each is made of: of mean square one over the rows when the calibration is projected out, and
    /// orthogonal within its group.
    pub columns: Vec<Combination>,
}

impl Reduced {
    /// Of a dictionary with its products.
    pub fn of(dictionary: &Dictionary, screen: &Screen) -> Result<Self, Error> {
        let mut reduced = Self { groups: Vec::new(), columns: Vec::new() };
        for group in &dictionary.groups {
            let from = reduced.columns.len();
            let all = group.forms.iter().flat_map(|form| form.columns.iter().copied());
            let there: Vec<usize> = all.filter(|column| screen.visible(*column) > VISIBLE).collect();
            reduced.columns.extend(directions(screen, &there)?);
            reduced.groups.push(from..reduced.columns.len());
        }
        Ok(reduced)
    }
}

fn directions(screen: &Screen, columns: &[usize]) -> Result<Vec<Combination>, Error> {
    let size = columns.len();
    let length: Vec<f64> = columns.iter().map(|column| screen.product(*column, *column).sqrt()).collect();
    let products =
        Mat::from_fn(size, size, |i, j| screen.product(columns[i], columns[j]) / (length[i] * length[j]));
    let eigen = products.self_adjoint_eigen(Side::Lower).map_err(|error| {
        let reason = format!("{error:?}");
        estimate::Error::Decomposition { rows: size, columns: size, reason }
    })?;
    let values = eigen.S().column_vector();
    let most = (0..size).map(|k| values[k]).fold(0.0, f64::max);
    let kept = (0..size).rev().filter(|k| values[*k] > LEAST * most);
    let rows = screen.freedom();
    let combination = |k: usize| {
        let scale = (rows / values[k]).sqrt();
        (0..size).map(|i| (columns[i], eigen.U()[(i, k)] * scale / length[i])).collect()
    };
    Ok(kept.map(combination).collect())
}
