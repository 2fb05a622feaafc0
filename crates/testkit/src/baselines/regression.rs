//! Choices among the columns of a linear regression.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Thresholds that are tried, in standard deviations of the response for a column of unit rms.
const THRESHOLDS: [f64; 10] = [0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8];
/// Ridge and rounds of thresholding: PySINDy's defaults.
const RIDGE: f64 = 0.05;
const ROUNDS: usize = 20;
/// A column of which no more than this share is left beside the chosen ones adds nothing.
const LEFT: f64 = 1e-9;

/// A response and the columns that may explain it; what is always in is projected out of both.
#[derive(Clone, Debug)]
pub struct Regression {
    response: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Degrees of freedom of what is always in.
    inside: usize,
}

impl Regression {
    /// Columns and response of the same length; columns are brought to unit rms.
    pub fn new(mut response: Vec<f64>, always: Vec<Vec<f64>>, mut columns: Vec<Vec<f64>>) -> Self {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for mut column in always {
            let before = dot(&column, &column);
            take_off(&mut column, &basis);
            take_off(&mut column, &basis);
            let length = dot(&column, &column);
            if length > LEFT * before {
                column.iter_mut().for_each(|value| *value /= length.sqrt());
                basis.push(column);
            }
        }
        take_off(&mut response, &basis);
        for column in &mut columns {
            let before = dot(column, column);
            take_off(column, &basis);
            take_off(column, &basis);
            let length = dot(column, column);
            let unit = (length / response.len() as f64).sqrt();
            let scale = if length > LEFT * before { 1.0 / unit } else { 0.0 };
            column.iter_mut().for_each(|value| *value *= scale);
        }
        Self { response, columns, inside: basis.len() }
    }

    /// Coefficients of the chosen columns under a ridge.
    fn coefficients(&self, chosen: &[usize], ridge: f64) -> Option<Vec<f64>> {
        let size = chosen.len();
        let gram = Mat::from_fn(size, size, |i, j| {
            dot(&self.columns[chosen[i]], &self.columns[chosen[j]]) + if i == j { ridge } else { 0.0 }
        });
        let along = Mat::from_fn(size, 1, |i, _| dot(&self.columns[chosen[i]], &self.response));
        let solution = gram.llt(Side::Lower).ok()?.solve(&along);
        Some((0..size).map(|i| solution[(i, 0)]).collect())
    }

    /// n ln(RSS/n) + k ln n.
    fn criterion(&self, chosen: &[usize]) -> f64 {
        let n = self.response.len() as f64;
        let Some(coefficients) = self.coefficients(chosen, LEFT * n) else { return f64::INFINITY };
        let left = (0..self.response.len()).map(|row| {
            let fitted: f64 =
                chosen.iter().zip(&coefficients).map(|(c, size)| self.columns[*c][row] * size).sum();
            (self.response[row] - fitted).powi(2)
        });
        n * (left.sum::<f64>() / n).ln() + (chosen.len() + self.inside) as f64 * n.ln()
    }

    /// Adds the column that lowers the criterion most, takes off any that raises it, until neither helps.
    pub fn stepwise(&self) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        let mut least = self.criterion(&chosen);
        loop {
            let more =
                self.usable().filter(|c| !chosen.contains(c)).map(|c| [chosen.clone(), vec![c]].concat());
            let fewer = chosen.iter().map(|c| chosen.iter().copied().filter(|other| other != c).collect());
            let best = more
                .chain(fewer)
                .map(|trial: Vec<usize>| (self.criterion(&trial), trial))
                .min_by(|a, b| a.0.total_cmp(&b.0));
            match best {
                Some((criterion, trial)) if criterion < least => (least, chosen) = (criterion, trial),
                _ => return chosen,
            }
        }
    }

    /// Ridge regression on all columns; coefficients below the threshold are set to zero and the rest fitted again, until none
    /// falls. Source: Brunton, Proctor & Kutz 2016, PNAS 113, 3932; de Silva et al. 2020, PySINDy, JOSS 5, 2104.
    pub fn thresholded(&self, threshold: f64) -> Vec<usize> {
        let mut chosen: Vec<usize> = self.usable().collect();
        for _ in 0..ROUNDS {
            let Some(coefficients) = self.coefficients(&chosen, RIDGE) else { return chosen };
            let kept: Vec<usize> = chosen
                .iter()
                .zip(&coefficients)
                .filter(|(_, size)| size.abs() >= threshold)
                .map(|(c, _)| *c)
                .collect();
            if kept.len() == chosen.len() {
                break;
            }
            chosen = kept;
        }
        chosen
    }

    /// The same at the threshold of the least criterion.
    pub fn thresholded_by_criterion(&self) -> Vec<usize> {
        let unit = (dot(&self.response, &self.response) / self.response.len() as f64).sqrt();
        THRESHOLDS
            .iter()
            .map(|threshold| self.thresholded(threshold * unit))
            .map(|chosen| (self.criterion(&chosen), chosen))
            .chain([(self.criterion(&[]), Vec::new())])
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or_else(Vec::new, |(_, chosen)| chosen)
    }

    /// Columns of which something is left beside what is always in.
    fn usable(&self) -> impl Iterator<Item = usize> {
        (0..self.columns.len()).filter(|c| self.columns[*c].iter().any(|value| *value != 0.0))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes the part along orthonormal columns off a series.
fn take_off(series: &mut [f64], basis: &[Vec<f64>]) {
    for column in basis {
        let along = dot(series, column);
        series.iter_mut().zip(column).for_each(|(value, unit)| *value -= along * unit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    /// PySINDy's STLSQ and a stepwise search in NumPy on the same columns: fixtures/reference/baselines_pysindy.py.
    #[test]
    fn the_same_columns_as_pysindy_chooses() {
        let reference: Value =
            serde_json::from_str(&crate::read_fixture("reference/baselines_pysindy.json")).expect("JSON");
        let list = |value: &Value| -> Vec<f64> {
            value.as_array().expect("a list").iter().filter_map(Value::as_f64).collect()
        };
        for case in reference["cases"].as_array().expect("cases") {
            let columns = case["columns"].as_array().expect("columns").iter().map(list).collect();
            let response = list(&case["response"]);
            let ones = vec![1.0; response.len()];
            let regression = Regression::new(response, vec![ones], columns);
            for (threshold, chosen) in
                list(&case["thresholds"]).iter().zip(case["thresholded"].as_array().expect("lists"))
            {
                let found: Vec<f64> = regression.thresholded(*threshold).iter().map(|c| *c as f64).collect();
                assert_eq!(found, list(chosen), "threshold {threshold}");
            }
            let mut found: Vec<f64> = regression.stepwise().iter().map(|c| *c as f64).collect();
            found.sort_by(f64::total_cmp);
            assert_eq!(found, list(&case["stepwise"]));
        }
    }
}
