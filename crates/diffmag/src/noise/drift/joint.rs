use common::covariance::rows;
use common::{JointDrift, Quantity};
use estimate::cosine::{Errors, Projection, Regression, weighted};
use estimate::dot;
use estimate::{line_search, stats};
use faer::Mat;
use std::f64::consts::PI;

use super::columns::{Beside, Columns, ROUNDS};
use crate::Error;
use paired::noise::Noise;

/// Probability below which a drift is demanded: one false alarm in a hundred recordings, over three axes and two
/// forms.
pub const LEVEL: f64 = 0.01 / 6.0;

/// The search of τ ends when ln τ moves less; while the noise is not settled, than the second.
const ACCURACY: f64 = 1e-7;
const ROUGH: f64 = 0.02;

/// The band that confirms an exponential reaches to so many times 1/(2πτ), where nine tenths of what white
/// noise lets be known of it are; and it has at least so many coefficients.
const CONFIRMS: f64 = 8.0;
const LEAST_CONFIRMS: usize = 256;

/// η, b, a and τ together.
pub struct Joint {
    /// Coefficients of the reference's x, y, z, the days, e^(−t/τ) and its derivative with respect to ln τ;
    /// the last is zero at the best τ.
    pub regression: Regression,
    pub ln_tau: f64,
    /// Least and greatest ln τ that were sought.
    limits: (f64, f64),
    pub noise: Noise,
    /// Probability of an exponential as great by chance, over all τ; the larger of the two in all of the band
    /// and in the part of it that confirms it.
    pub p: f64,
    freedom: f64,
}

/// Least squares over η, b, a and τ, weighted by the noise of what they leave: variable projection, the
/// linear unknowns solved for each τ; sought over a grid of ln τ, refined by Gauss and Newton.
///
/// Noise of the reference, where it is more than the field at short periods, pulls η, and the field that it
/// leaves in the difference can look like an exponential. So one that is seen has to be seen at long periods
/// too, where the field is strong.
///
/// Source: G. H. Golub and V. Pereyra, Separable nonlinear least squares, Inverse Problems 19 (2003) R1–R26.
pub fn joint(
    columns: &Columns<'_>,
    y: &[f64],
    start: &Noise,
    beside: &Beside<'_>,
) -> Result<Option<Joint>, Error> {
    if columns.search.is_empty() {
        return Ok(None);
    }
    let mut noise = start.clone();
    for _ in 0..ROUNDS {
        let errors = noise.errors(&columns.cosine)?;
        let best = Best::of(columns, y, &errors, beside, ROUGH)?;
        noise = columns.noise(&best.regression, &errors, beside.lines_hz)?;
    }
    let errors = noise.errors(&columns.cosine)?;
    let Best { regression, ln_tau, score, length } = Best::of(columns, y, &errors, beside, ACCURACY)?;
    let freedom = noise.freedom(&columns.cosine, &regression.influence[4]);
    let mut p = chance(score, length, freedom);
    // Coefficient k is at k/(2 × the length).
    let enough = (CONFIRMS * columns.length_s() / PI * (-ln_tau).exp()).ceil() as usize;
    let kept = enough.max(LEAST_CONFIRMS);
    if p < LEVEL && kept < y.len() {
        let own: Vec<Vec<f64>> = beside.own.iter().map(|column| column[..kept].to_vec()).collect();
        let slow = Beside { own: &own, lines_hz: beside.lines_hz };
        let confirmed = Best::of(&columns.up_to(kept), &y[..kept], &errors, &slow, ROUGH)?;
        p = p.max(chance(confirmed.score, confirmed.length, freedom));
    }
    Ok(Some(Joint { regression, ln_tau, limits: columns.limits(), noise, p, freedom }))
}

/// The exponential that explains most.
struct Best {
    regression: Regression,
    ln_tau: f64,
    /// Its amplitude over the standard deviation, τ held.
    score: f64,
    /// Length of the curve of the exponentials of all τ.
    length: f64,
}

impl Best {
    fn of(
        columns: &Columns<'_>,
        y: &[f64],
        errors: &Errors,
        beside: &Beside<'_>,
        accuracy: f64,
    ) -> Result<Self, Error> {
        let all = columns.with(&[], beside);
        let lowest = columns.search().next().map_or(0, |(_, transform)| transform.len());
        let cut: Vec<&[f64]> = all.iter().map(|column| &column[..lowest]).collect();
        let projection = Projection::of(&cut, &y[..lowest], errors)?;
        let (place, length) = along(&projection, errors, columns.search().map(|(_, column)| column));
        let start = columns.search[place].0;
        let (ln_tau, gain) = refine(columns, errors, &Projection::of(&all, y, errors)?, start, accuracy);
        let [plain, slope] = columns.exponential(ln_tau).map(|column| columns.transform(&column));
        let regression = weighted(&columns.with(&[&plain, &slope], beside), y, errors)?;
        Ok(Self { regression, ln_tau, score: gain.sqrt(), length })
    }
}

/// Of columns in the order of one parameter the place of the one that explains most, and the length of the
/// curve that they go through, less what other columns explain of them and of unit length.
fn along<'b>(
    projection: &Projection,
    errors: &Errors,
    columns: impl Iterator<Item = &'b [f64]>,
) -> (usize, f64) {
    let (mut best, mut most, mut length) = (0, 0.0, 0.0);
    let mut before: Option<Vec<f64>> = None;
    for (place, column) in columns.enumerate() {
        let Some(direction) = projection.direction(column, errors) else { continue };
        let score = projection.score(&direction).abs();
        if score > most {
            (best, most) = (place, score);
        }
        if let Some(before) = &before {
            length += dot(before, &direction).clamp(-1.0, 1.0).acos();
        }
        before = Some(direction);
    }
    (best, length)
}

/// P(max |z| ≥ score) of noise alone along a curve of length L: P(|t_ν| ≥ z) + L/π (1 + z²/ν)^(−ν/2), an
/// upper bound that is sharp where it is small. Without an exponential there is no τ, so that χ² does not
/// hold.
///
/// Sources: R. B. Davies, Hypothesis testing when a nuisance parameter is present only under the alternative,
/// Biometrika 74 (1987) 33–43; M. Knowles and D. Siegmund, On Hotelling's approach to testing for a nonlinear
/// parameter in regression, Int. Stat. Rev. 57 (1989) 205–220.
fn chance(score: f64, length: f64, freedom: f64) -> f64 {
    let crossings = length / PI * (-0.5 * freedom * (score * score / freedom).ln_1p()).exp();
    (stats::two_sided_p(score, freedom) + crossings).min(1.0)
}

/// The best τ near a start, and by what its exponential lowers the sum of squares.
fn refine(
    columns: &Columns<'_>,
    errors: &Errors,
    projection: &Projection,
    start: f64,
    accuracy: f64,
) -> (f64, f64) {
    let gain = |ln_tau: f64| {
        let column = columns.transform(&columns.exponential(ln_tau)[0]);
        projection.direction(&column, errors).map_or(0.0, |direction| projection.score(&direction).powi(2))
    };
    let step = |(ln_tau, _): &(f64, f64)| {
        let [plain, slope] = columns.exponential(*ln_tau).map(|column| columns.transform(&column));
        let sizes = projection.coefficients(&[&plain, &slope], errors)?;
        Some(sizes[1] / sizes[0])
    };
    let above = |(_, reached): &(f64, f64), ln_tau: f64| Some(gain(ln_tau)).filter(|found| found >= reached);
    line_search::climb((start, gain(start)), columns.limits(), accuracy, step, above)
}

impl Joint {
    /// η, b, a and ln τ.
    pub fn values(&self) -> [f64; 6] {
        let found = &self.regression.coefficients;
        [found[0], found[1], found[2], found[3], found[4], self.ln_tau]
    }

    /// Covariance of η, b, a and ln τ: that of the linear unknowns and of the derivative's coefficient, which
    /// is a δ ln τ.
    pub fn covariance(&self) -> Mat<f64> {
        let scale = |i: usize| if i == 5 { 1.0 / self.regression.coefficients[4] } else { 1.0 };
        let widening = |i: usize| if i < 3 { 1.0 } else { widening(self.freedom) };
        Mat::from_fn(6, 6, |i, j| {
            scale(i) * scale(j) * widening(i) * widening(j) * self.regression.covariance[(i, j)]
        })
    }

    pub fn document(&self) -> JointDrift {
        let (values, covariance) = (self.values(), self.covariance());
        let quantity = |i: usize| Quantity::new(values[i], covariance[(i, i)].sqrt());
        let (low, high) = self.limits;
        let half = stats::coverage_factor(0.95, f64::INFINITY) * covariance[(5, 5)].sqrt();
        let tau = self.ln_tau.exp();
        JointDrift {
            eta: [quantity(0), quantity(1), quantity(2)],
            straight_nt_per_day: quantity(3),
            amplitude_nt: quantity(4),
            time_constant_s: Quantity::new(tau, tau * covariance[(5, 5)].sqrt()),
            time_constant_interval_s: [
                (self.ln_tau - half).max(low).exp(),
                (self.ln_tau + half).min(high).exp(),
            ],
            time_constant_at_limit: self.ln_tau <= low || self.ln_tau >= high,
            covariance: rows(&covariance),
        }
    }
}

/// Student's 97.5 % point over the normal one: with it ± 1.96 standard uncertainties are Student's interval.
pub fn widening(freedom: f64) -> f64 {
    stats::coverage_factor(0.95, freedom) / stats::coverage_factor(0.95, f64::INFINITY)
}
