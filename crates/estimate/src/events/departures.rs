//! Single readings and levels that depart, in a whitened residual beside what else is fitted.

use fourier::Complex;

use crate::stats::{chi_squared_quantile, median};

/// A departure of which the basis leaves less than this share is not looked for.
const LEFT: f64 = 1e-3;

/// The matched filter for a whitened series at any times: a departure of one in each row, whitened like the
/// series, against it and against an orthonormal basis of what else is fitted.
pub struct Departures {
    /// What a departure of one in a row is whitened to, from its row on.
    pub response: Vec<f64>,
    /// Σ of the series times the response from each row on.
    pub along: Vec<f64>,
    /// The same with each column of the basis.
    within: Vec<Vec<f64>>,
    /// Robust variance of the series, at least one (the square of the Birge ratio): an event must be
    /// significant against the scatter that there is, not against the noise alone.
    pub scatter: f64,
}

/// What a shape has to do with a whitened series and with the basis.
#[derive(Clone, Debug, Default)]
pub struct Product {
    /// Σ of the series times the shape.
    pub along: f64,
    /// Squared length of the shape.
    pub length: f64,
    /// Its products with the basis.
    pub within: Vec<f64>,
}

impl Product {
    /// By how much the sum of squares falls with the shape; zero where the basis leaves too little of it.
    pub fn gain(&self) -> f64 {
        let left = self.length - self.within.iter().map(|w| w * w).sum::<f64>();
        if left > LEFT * self.length { self.along * self.along / left } else { 0.0 }
    }

    /// Adds a shape in other rows.
    pub fn add(&mut self, other: &Self) {
        self.along += other.along;
        self.length += other.length;
        self.within.resize(other.within.len().max(self.within.len()), 0.0);
        self.within.iter_mut().zip(&other.within).for_each(|(sum, within)| *sum += within);
    }
}

impl Departures {
    /// Of a whitened series, the response, and the basis over the same rows.
    pub fn of<'a>(white: &[f64], response: Vec<f64>, basis: impl Iterator<Item = &'a [f64]>) -> Self {
        let along = correlate(white, &response);
        let squares: Vec<f64> = white.iter().map(|w| w * w).collect();
        let scatter = (median(&squares) / chi_squared_quantile(0.5, 1.0)).max(1.0);
        let within = basis.map(|column| correlate(column, &response)).collect();
        Self { response, along, within, scatter }
    }

    /// Squared length of a departure in each row, and of one that stays from each row on.
    pub fn lengths(&self) -> [Vec<f64>; 2] {
        let rows = self.along.len();
        let (mut level, mut single, mut stays) = (0.0, 0.0, 0.0);
        let (mut one, mut step) = (vec![0.0; rows], vec![0.0; rows]);
        for i in 0..rows {
            let response = self.response.get(i).copied().unwrap_or(0.0);
            level += response;
            single += response * response;
            stays += level * level;
            (one[rows - 1 - i], step[rows - 1 - i]) = (single, stays);
        }
        [one, step]
    }

    /// What a departure of all rows is.
    pub fn whole(&self) -> Product {
        Product {
            along: self.along.iter().sum(),
            length: self.lengths()[1].first().copied().unwrap_or(0.0),
            within: self.within.iter().map(|values| values.iter().sum()).collect(),
        }
    }

    /// What a spike in each row gains.
    pub fn spikes(&self) -> Vec<f64> {
        let [one, _] = self.lengths();
        let product = |(row, length): (usize, f64)| Product {
            along: self.along[row],
            length,
            within: self.within.iter().map(|column| column[row]).collect(),
        };
        one.into_iter().enumerate().map(|spike| product(spike).gain()).collect()
    }

    /// What a step at each row gains that stays to the last row, and in other series as far as `beyond`.
    pub fn steps(&self, beyond: &Product) -> Vec<f64> {
        let [_, stays] = self.lengths();
        let mut step = Product { within: vec![0.0; self.within.len()], ..Product::default() };
        step.add(beyond);
        let mut gains = vec![0.0; stays.len()];
        for row in (0..stays.len()).rev() {
            step.along += self.along[row];
            step.length = beyond.length + stays[row];
            step.within.iter_mut().zip(&self.within).for_each(|(sum, column)| *sum += column[row]);
            gains[row] = step.gain();
        }
        gains
    }
}

/// Σ_i series[j+i] template[i] for every row j, zero beyond the end.
pub fn correlate(series: &[f64], template: &[f64]) -> Vec<f64> {
    if let [only] = template {
        return series.iter().map(|value| value * only).collect();
    }
    let points = (series.len() + template.len()).next_power_of_two();
    let spectrum = |values: &[f64]| {
        let mut padded = values.to_vec();
        padded.resize(points, 0.0);
        fourier::forward(padded)
    };
    let product: Vec<Complex<f64>> =
        spectrum(series).iter().zip(spectrum(template)).map(|(a, b)| a * b.conj() / points as f64).collect();
    let mut found = fourier::inverse(product, points);
    found.truncate(series.len());
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlation_is_the_sum() {
        let series: Vec<f64> = (0..23).map(|k| f64::sin(k as f64 * k as f64)).collect();
        let template = [0.5, -1.0, 0.25, 2.0];
        for (j, found) in correlate(&series, &template).iter().enumerate() {
            let sum: f64 =
                template.iter().enumerate().filter_map(|(i, t)| Some(series.get(j + i)? * t)).sum();
            assert!((found - sum).abs() < 1e-12);
        }
    }

    #[test]
    fn gains_are_those_of_least_squares() {
        // Whitened by the differences of neighbours, beside a level, which is whitened to its first row.
        let white: Vec<f64> = (0..40).map(|k| f64::sin(k as f64 * k as f64)).collect();
        let mut level = vec![0.0; 40];
        level[0] = 1.0;
        let departures = Departures::of(&white, vec![1.0, -1.0], std::iter::once(level.as_slice()));
        let (spikes, steps) = (departures.spikes(), departures.steps(&Product::default()));
        for row in 1..39 {
            assert!((spikes[row] - (white[row] - white[row + 1]).powi(2) / 2.0).abs() < 1e-12, "{row}");
            assert!((steps[row] - white[row].powi(2)).abs() < 1e-12, "{row}");
        }
        // A step at the first row is the level.
        assert_eq!(steps[0], 0.0);
        // Where it goes on elsewhere, what is there counts as well.
        let beyond = Product { along: 3.0, length: 8.0, within: vec![0.0] };
        let longer = departures.steps(&beyond);
        assert!((longer[7] - (white[7] + 3.0).powi(2) / 9.0).abs() < 1e-12);
    }
}
