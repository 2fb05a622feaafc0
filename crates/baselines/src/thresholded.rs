//! Sequentially thresholded least squares, from the products of the columns alone.
//!
//! Ridge regression on all columns; groups whose coefficients are below the threshold go, and the rest are
//! fitted again, until none goes; these are fitted once more without the ridge. Source: Brunton, Proctor &
//! Kutz 2016, PNAS 113, 3932; de Silva et al. 2020, PySINDy, JOSS 5,
//! 2104. A group of r columns goes when |β_g| < t √r: with one column a group, that is PySINDy's STLSQ.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::ops::Range;

use crate::blocks::Sample;

/// Rounds of thresholding: PySINDy's.
const ROUNDS: usize = 20;
/// Ridge of the last fit, as a share of the squared length of a column.
const ROUNDING: f64 = 1e-10;

/// What stays.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// The groups.
    pub groups: Vec<usize>,
    /// Coefficients of all columns, zero for those that went.
    pub coefficients: Vec<f64>,
    /// By how much they lower the sum of squares.
    pub gain: f64,
}

/// At a threshold and a ridge.
pub fn thresholded(sample: &Sample, groups: &[Range<usize>], threshold: f64, ridge: f64) -> Kept {
    let mut kept: Vec<usize> = (0..groups.len()).filter(|group| !groups[*group].is_empty()).collect();
    for _ in 0..ROUNDS {
        let coefficients = fitted(sample, groups, &kept, |_| ridge);
        let stays = |group: &usize| {
            let own = &coefficients[groups[*group].clone()];
            let squares: f64 = own.iter().map(|c| c * c).sum();
            squares >= threshold * threshold * own.len() as f64
        };
        let before = kept.len();
        kept.retain(stays);
        if kept.len() == before {
            break;
        }
    }
    let coefficients = fitted(sample, groups, &kept, |length| ROUNDING * length);
    let gain = coefficients.iter().zip(&sample.along).map(|(c, along)| c * along).sum();
    Kept { groups: kept, coefficients, gain }
}

/// (XᵀX + α)⁻¹ Xᵀy over the columns of some groups, α from the squared length of a column.
fn fitted(sample: &Sample, groups: &[Range<usize>], kept: &[usize], ridge: impl Fn(f64) -> f64) -> Vec<f64> {
    let columns: Vec<usize> = kept.iter().flat_map(|group| groups[*group].clone()).collect();
    let mut coefficients = vec![0.0; sample.along.len()];
    if columns.is_empty() {
        return coefficients;
    }
    let gram = Mat::from_fn(columns.len(), columns.len(), |i, j| {
        let product = sample.gram[(columns[i], columns[j])];
        if i == j { product + ridge(sample.rows) } else { product }
    });
    let along = Mat::from_fn(columns.len(), 1, |i, _| sample.along[columns[i]]);
    let solution = match gram.llt(Side::Lower) {
        Ok(factor) => factor.solve(&along),
        // Columns that run together in a sample to all digits.
        Err(_) => gram.full_piv_lu().solve(&along),
    };
    for (i, column) in columns.iter().enumerate() {
        coefficients[*column] = if solution[(i, 0)].is_finite() { solution[(i, 0)] } else { 0.0 };
    }
    coefficients
}

#[cfg(test)]
pub mod reference {
    //! The cases of fixtures/reference/baselines_pysindy.py.

    use serde_json::Value;

    /// One of them.
    pub struct Case {
        /// The columns.
        pub columns: Vec<Vec<f64>>,
        /// The response.
        pub response: Vec<f64>,
        /// What a stepwise search chooses.
        pub stepwise: Vec<usize>,
        /// The rest.
        pub value: Value,
    }

    pub fn list(value: &Value) -> Vec<f64> {
        value.as_array().expect("a list").iter().filter_map(Value::as_f64).collect()
    }

    pub fn lists(value: &Value) -> Vec<Vec<f64>> {
        value.as_array().expect("lists").iter().map(list).collect()
    }

    pub fn numbers(value: &Value) -> Vec<usize> {
        list(value).into_iter().map(|number| number as usize).collect()
    }

    /// All of them.
    pub fn cases() -> Vec<Case> {
        let text = testkit::read_fixture("reference/baselines_pysindy.json");
        let reference: Value = serde_json::from_str(&text).expect("JSON");
        let cases = reference["cases"].as_array().expect("cases");
        let case = |value: &Value| Case {
            columns: lists(&value["columns"]),
            response: list(&value["response"]),
            stepwise: numbers(&value["stepwise"]),
            value: value.clone(),
        };
        cases.iter().map(case).collect()
    }

    /// Rows of the columns about their mean, of mean square one, and of the response about its mean.
    pub fn rows(case: &Case) -> Vec<Vec<f64>> {
        let n = case.response.len() as f64;
        let centred = |values: &[f64]| -> Vec<f64> {
            let mean = values.iter().sum::<f64>() / n;
            values.iter().map(|value| value - mean).collect()
        };
        let unit = |values: &Vec<f64>| -> Vec<f64> {
            let values = centred(values);
            let rms = (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt();
            values.iter().map(|value| value / rms).collect()
        };
        let columns: Vec<Vec<f64>> = case.columns.iter().map(unit).chain([centred(&case.response)]).collect();
        (0..case.response.len()).map(|row| columns.iter().map(|column| column[row]).collect()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::Blocks;

    /// PySINDy's STLSQ on the same columns: fixtures/reference/baselines_pysindy.py.
    #[test]
    fn the_same_columns_as_pysindy_chooses() {
        for case in reference::cases() {
            let rows = reference::rows(&case);
            let sample = Blocks::of_rows(&rows).sample(&vec![1.0; rows.len()]).expect("finite");
            let groups: Vec<Range<usize>> = (0..case.columns.len()).map(|k| k..k + 1).collect();
            let expected = case.value["thresholded"].as_array().expect("lists");
            for (threshold, chosen) in reference::list(&case.value["thresholds"]).iter().zip(expected) {
                let found = thresholded(&sample, &groups, *threshold, 0.05);
                assert_eq!(found.groups, reference::numbers(chosen), "threshold {threshold}");
            }
        }
    }
}
