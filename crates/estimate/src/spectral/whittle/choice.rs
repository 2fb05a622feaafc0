//! Which form of the white noise series show.

use crate::stats::chi_squared_p;

/// A restriction of the white noise is dropped below this probability.
const RESTRICTED: f64 = 0.01;

/// Which of the models: by reading, by density, each.
pub struct Choice {
    pub number: usize,
    pub per_reading_p: Option<f64>,
    pub density_p: Option<f64>,
}

impl Choice {
    pub fn of(costs: [f64; 3], series: usize) -> Self {
        let [per_reading_p, density_p] = [costs[0], costs[1]]
            .map(|cost| chi_squared_p(2.0 * (cost - costs[2]).max(0.0), series as f64 - 1.0));
        let number = [per_reading_p, density_p].iter().position(|p| *p > RESTRICTED).unwrap_or(2);
        Choice { number, per_reading_p: Some(per_reading_p), density_p: Some(density_p) }
    }
}
