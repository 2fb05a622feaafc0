use common::{CrossFieldFit, Quantity};

use super::super::verdict::normal_std;

/// Parameters of the fields across, in the order of [`shapes`].
const PARAMETERS: [&str; 5] = [
    "offset.first_nt",
    "offset.second_nt",
    "offset.mixed_nt",
    "sensitivity.first_nt",
    "sensitivity.second_nt",
];

/// Change of the reading for each nT of the parameters; b along and u, v across in units of 50 000 nT.
fn shapes(b: f64, u: f64, v: f64) -> [f64; 5] {
    [u * u, v * v, u * v, b * u, b * v]
}

/// What fields across do to a sensor.
pub struct Across {
    /// Covariance of the parameters, nT².
    covariance: [[f64; 5]; 5],
    /// Their values where they are not corrected, nT.
    left: [f64; 5],
}

impl Across {
    /// As sensorcal found it; `corrected` where the model has it. A parameter that could not be seen is zero, give or take the largest that
    /// was.
    pub fn of(fit: &CrossFieldFit, corrected: bool) -> Self {
        let widened = normal_std(1.0, fit.noise.coverage_factor_95).powi(2);
        let value = |name: &str| {
            let (group, key) = name.split_once('.').unwrap_or((name, ""));
            let of = if group == "offset" { &fit.offset } else { &fit.sensitivity };
            (of.get(key).map(Quantity::value), of.values().map(|size| size.value().abs()).fold(0.0, f64::max))
        };
        let places = PARAMETERS.map(|name| fit.covariance_order.iter().position(|key| key == name));
        let mut covariance = [[0.0; 5]; 5];
        for (a, row) in covariance.iter_mut().enumerate() {
            for (b, entry) in row.iter_mut().enumerate() {
                let found = places[a].zip(places[b]).and_then(|(a, b)| fit.covariance.get(a)?.get(b));
                *entry = found.map_or(0.0, |found| found * widened);
            }
            if places[a].is_none() {
                row[a] = value(PARAMETERS[a]).1.powi(2);
            }
        }
        let left = PARAMETERS.map(|name| if corrected { 0.0 } else { value(name).0.unwrap_or(0.0) });
        Self { covariance, left }
    }

    /// Standard uncertainty of the reading, nT, by what is known and what is not corrected: √(gᵀ C g + (g · left)²).
    pub fn std(&self, b: f64, u: f64, v: f64) -> f64 {
        let by = shapes(b, u, v);
        let entries = (0..25).map(|k| by[k / 5] * self.covariance[k / 5][k % 5] * by[k % 5]);
        let left: f64 = by.iter().zip(&self.left).map(|(by, left)| by * left).sum();
        (entries.sum::<f64>().max(0.0) + left * left).sqrt()
    }
}
