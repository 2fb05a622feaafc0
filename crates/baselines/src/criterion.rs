//! The extended Bayesian information criterion.

/// What is counted of a model.
#[derive(Clone, Copy, Debug)]
pub struct Criterion {
    /// Rows, less the constants of the calibration.
    pub rows: f64,
    /// Weight of the search: nought gives the Bayesian information criterion.
    pub search: f64,
}

/// Weight of the search.
pub const SEARCH: f64 = 1.0;

impl Criterion {
    /// n ln(R/n) + k ln n + 2γ Σ ln P, with R the sum of squares that is left, k the columns and P among how
    /// many each choice was made: without that term the criterion claims something in noise as soon as there
    /// are more candidates than √n. Source: Schwarz 1978, Ann. Statist. 6, 461; Chen & Chen 2008, Biometrika
    /// 95, 759.
    pub fn of(self, left: f64, columns: f64, log_candidates: f64) -> f64 {
        let n = self.rows;
        n * (left.max(f64::MIN_POSITIVE) / n).ln() + columns * n.ln() + 2.0 * self.search * log_candidates
    }
}
