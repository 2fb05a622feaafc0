//! Trends of a baseline weighed by their evidence: Gaussian processes, their amplitudes averaged over.
//!
//! y = c + Σ aₖ Pₖ(u) + f(t) + w(t) + Σ γⱼ xⱼ + e, with Legendre polynomials of the time or f, an integrated random walk
//! (whose mean is the cubic smoothing spline: G. Wahba, J. R. Stat. Soc. B 40 (1978) 364), the random walk w, regressors x
//! (steps, columns, measurements that are off), and the scatter e. All coefficients have normal priors, so that the
//! evidence of every trend is comparable; the amplitudes of f, w and e lie on grids.

use estimate::positive::cholesky;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat};

use crate::Error;

/// Standard deviation of the constant about the mean of the measurements, nT.
const CONSTANT_NT: f64 = 100.0;
/// Of a drift, nT a year: an observatory's variometer is to drift by less (INTERMAGNET Technical Reference Manual,
/// section 2.2).
const DRIFT_NT_PER_YEAR: f64 = 5.0;
/// Scatter beyond that of the readings, nT.
const SCATTER_NT: [f64; 7] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
/// Amplitude of a random walk after a year, nT.
const WALK_NT: [f64; 5] = [0.2, 0.6, 1.8, 5.4, 16.2];
/// Amplitude of an integrated one after a year, nT.
const SPLINE_NT: [f64; 5] = [0.5, 2.0, 8.0, 32.0, 128.0];
/// Polynomials of a shorter series are those of this time, years: they are not to run away outside it.
const SHORTEST_YEARS: f64 = 1.0;
/// How long before the first measurement the processes begin, years; a baseline may be asked for after that.
pub const BEFORE_YEARS: f64 = 0.1;
/// Points of the grid with a smaller share of the evidence are left out.
const LEAST: f64 = 1e-4;

/// How a baseline goes, beside a random walk: pillars wander a little in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trend {
    Polynomial(usize),
    Spline,
}

impl Trend {
    pub const ALL: [Self; 5] =
        [Self::Polynomial(0), Self::Polynomial(1), Self::Polynomial(2), Self::Polynomial(3), Self::Spline];

    pub fn name(self) -> &'static str {
        match self {
            Self::Polynomial(degree) => ["constant", "line", "parabola", "cubic"][degree],
            Self::Spline => "spline",
        }
    }

    /// The amplitudes of its processes, the walk and the spline, nT after a year.
    fn amplitudes(self) -> Vec<[f64; 2]> {
        let splines: &[f64] = if self == Self::Spline { &SPLINE_NT } else { &[0.0] };
        WALK_NT.iter().flat_map(|walk| splines.iter().map(|spline| [*walk, *spline])).collect()
    }
}

pub struct Regressor {
    /// At each measurement.
    pub at: Vec<f64>,
    /// Standard deviation of its coefficient, nT.
    pub prior_nt: f64,
}

pub struct Data {
    pub years: Vec<f64>,
    /// Less their mean, nT.
    pub value_nt: Vec<f64>,
    /// Of the readings alone, nT².
    pub variance: Vec<f64>,
}

/// One trend with amplitudes of the processes and of the scatter.
struct Point {
    trend: Trend,
    amplitudes_nt: [f64; 2],
    scatter_nt: f64,
    log_evidence: f64,
    factor: Llt<f64>,
    /// K⁻¹ y.
    weights: Col<f64>,
}

/// All points that matter, each with its share of the evidence.
pub struct Mixture {
    points: Vec<(Point, f64)>,
    span_years: f64,
}

/// What is known at a time that is asked for.
pub struct At {
    pub years: f64,
    pub regressors: Vec<f64>,
}

impl Mixture {
    /// Weighs the trends. Errors: a covariance that is not positive definite.
    pub fn of(data: &Data, regressors: &[Regressor]) -> Result<Self, Error> {
        let span_years = data.years.iter().copied().fold(SHORTEST_YEARS, f64::max);
        let mut points = Vec::new();
        for trend in Trend::ALL {
            let amplitudes = trend.amplitudes();
            let cells = (amplitudes.len() * SCATTER_NT.len()) as f64;
            for amplitudes_nt in amplitudes {
                let own = Mat::from_fn(data.years.len(), data.years.len(), |i, j| {
                    let shared: f64 = (regressors.iter())
                        .map(|one| one.prior_nt * one.prior_nt * one.at[i] * one.at[j])
                        .sum();
                    shared + covariance(trend, amplitudes_nt, span_years, [data.years[i], data.years[j]])
                });
                for scatter_nt in SCATTER_NT {
                    let mut all = own.clone();
                    for (i, variance) in data.variance.iter().enumerate() {
                        all[(i, i)] += variance + scatter_nt * scatter_nt;
                    }
                    let factor = cholesky(all.as_ref())?;
                    let y = Col::from_fn(data.value_nt.len(), |i| data.value_nt[i]);
                    let weights = factor.solve(&y);
                    let log_determinant: f64 = (0..y.nrows()).map(|i| factor.L()[(i, i)].ln()).sum();
                    let log_evidence = -0.5 * (y.transpose() * &weights) - log_determinant - cells.ln();
                    points.push(Point { trend, amplitudes_nt, scatter_nt, log_evidence, factor, weights });
                }
            }
        }
        let best = points.iter().map(|point| point.log_evidence).fold(f64::NEG_INFINITY, f64::max);
        points.retain(|point| (point.log_evidence - best).exp() > LEAST);
        let sum: f64 = points.iter().map(|point| (point.log_evidence - best).exp()).sum();
        let share = |point: Point| {
            let share = (point.log_evidence - best).exp() / sum;
            (point, share)
        };
        Ok(Self { points: points.into_iter().map(share).collect(), span_years })
    }

    /// ln of the Bayes factor for each of some further regressors.
    pub fn log_bayes_factors(&self, more: &[Regressor]) -> Vec<f64> {
        let Some(first) = more.first() else { return Vec::new() };
        let x = Mat::from_fn(first.at.len(), more.len(), |i, j| more[j].at[i]);
        let mut factors = vec![0.0; more.len()];
        for (point, share) in &self.points {
            let (along, solved) = (point.weights.transpose() * &x, point.factor.solve(&x));
            for (j, one) in more.iter().enumerate() {
                let prior = one.prior_nt * one.prior_nt;
                let square = 1.0 / prior + x.col(j).transpose() * solved.col(j);
                factors[j] +=
                    share * (0.5 * along[j] * along[j] / square - 0.5 * (square * prior).ln()).exp();
            }
        }
        factors.into_iter().map(f64::ln).collect()
    }

    /// Share of the evidence of each trend.
    pub fn probabilities(&self) -> [(Trend, f64); 5] {
        Trend::ALL.map(|trend| {
            let own = self.points.iter().filter(|(point, _)| point.trend == trend);
            (trend, own.map(|(_, share)| share).fold(0.0, |sum, share| sum + share))
        })
    }

    /// Posterior mean of the scatter.
    pub fn scatter_nt(&self) -> f64 {
        self.points.iter().map(|(point, share)| share * point.scatter_nt).sum()
    }

    /// The baseline at some times with its standard uncertainty, nT, the scatter of measurements left out.
    pub fn at(&self, data: &Data, regressors: &[Regressor], times: &[At]) -> Vec<[f64; 2]> {
        let priors: Vec<f64> = regressors.iter().map(|one| one.prior_nt * one.prior_nt).collect();
        self.averaged(times.len(), |point| {
            let of = |a: f64, b: f64| covariance(point.trend, point.amplitudes_nt, self.span_years, [a, b]);
            let with = Mat::from_fn(data.years.len(), times.len(), |i, j| {
                let each = regressors.iter().zip(&times[j].regressors).zip(&priors);
                of(data.years[i], times[j].years)
                    + each.map(|((one, there), prior)| prior * one.at[i] * there).sum::<f64>()
            });
            let own = |at: &At| {
                let each = at.regressors.iter().zip(&priors);
                of(at.years, at.years) + each.map(|(there, prior)| prior * there * there).sum::<f64>()
            };
            (with, times.iter().map(own).collect())
        })
    }

    /// The coefficient of a regressor with its standard uncertainty.
    pub fn coefficient(&self, of: &Regressor) -> [f64; 2] {
        let prior = of.prior_nt * of.prior_nt;
        let with = Mat::from_fn(of.at.len(), 1, |i, _| prior * of.at[i]);
        self.averaged(1, |_| (with.clone(), vec![prior]))[0]
    }

    /// Mean and standard deviation of quantities over all points, of each quantity its covariance with the measurements
    /// and its variance a priori.
    fn averaged(&self, count: usize, of: impl Fn(&Point) -> (Mat<f64>, Vec<f64>)) -> Vec<[f64; 2]> {
        let mut sums = vec![[0.0; 2]; count];
        for (point, share) in &self.points {
            let (with, own) = of(point);
            let (means, solved) = (point.weights.transpose() * &with, point.factor.solve(&with));
            for (j, [sum, squares]) in sums.iter_mut().enumerate() {
                let variance = own[j] - with.col(j).transpose() * solved.col(j);
                *sum += share * means[j];
                *squares += share * (variance.max(0.0) + means[j] * means[j]);
            }
        }
        sums.into_iter().map(|[mean, squares]| [mean, (squares - mean * mean).max(0.0).sqrt()]).collect()
    }

    /// Rms of the leave-one-out residuals, of the best point of a trend; None where it has no share.
    pub fn left_out_rms(&self, trend: Trend) -> Option<f64> {
        let own = self.points.iter().filter(|(point, _)| point.trend == trend);
        let (point, _) = own.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let count = point.weights.nrows();
        let inverse = point.factor.solve(Mat::<f64>::identity(count, count));
        let squares: f64 = (0..count).map(|i| (point.weights[i] / inverse[(i, i)]).powi(2)).sum();
        Some((squares / count as f64).sqrt())
    }
}

/// Covariance of the baseline at two times, nT².
fn covariance(trend: Trend, [walk_nt, spline_nt]: [f64; 2], span_years: f64, years: [f64; 2]) -> f64 {
    let [a, b] = years.map(|year| 2.0 * year / span_years - 1.0);
    let degree = match trend {
        Trend::Polynomial(degree) => degree,
        Trend::Spline => 1,
    };
    let legendre = |u: f64| [1.0, u, 1.5 * u * u - 0.5, 2.5 * u * u * u - 1.5 * u];
    let (pa, pb) = (legendre(a), legendre(b));
    // Half the span is the unit of u.
    let drift_nt = 0.5 * span_years * DRIFT_NT_PER_YEAR;
    let polynomial: f64 = (1..=degree).map(|k| drift_nt * drift_nt * pa[k] * pb[k]).sum();
    // Both begin before the first measurement.
    let [near, far] = [years[0].min(years[1]), years[0].max(years[1])].map(|year| year + BEFORE_YEARS);
    // ∫₀ⁿ (n − s)(f − s) ds, 1/3 after a year.
    let integrated = near * near * (3.0 * far - near) / 6.0;
    let process = walk_nt * walk_nt * near + 3.0 * spline_nt * spline_nt * integrated;
    CONSTANT_NT * CONSTANT_NT + polynomial + process
}
