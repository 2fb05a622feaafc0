//! Courses of a baseline weighed by their evidence: a Gaussian process whose size is averaged over.
//!
//! y = c + Σ aₖ Pₖ(u) + f(t) + Σ γⱼ xⱼ + e, with Legendre polynomials of the time, f a random walk or an integrated one
//! (whose mean is the cubic smoothing spline: G. Wahba, J. R. Stat. Soc. B 40 (1978) 364), regressors x (steps, columns,
//! measurements that are off), and the scatter e. All coefficients have normal priors, so that the evidence of every course
//! is comparable; sizes of f and e lie on grids.

use estimate::positive::cholesky;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Col, Mat};

use crate::Error;

/// Standard deviation of the constant about the mean of the measurements, nT.
const CONSTANT_NT: f64 = 100.0;
/// Of the coefficient of a polynomial: an observatory's variometer is to drift by less than 5 nT a year (INTERMAGNET
/// Technical Reference Manual, section 2.2).
const DRIFT_NT: f64 = 5.0;
/// Scatter beyond that of the readings, nT.
const SCATTER_NT: [f64; 7] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
/// Size of a random walk after a year, nT.
const WALK_NT: [f64; 5] = [0.2, 0.6, 1.8, 5.4, 16.2];
/// Size of an integrated one after a year, nT.
const SPLINE_NT: [f64; 5] = [0.5, 2.0, 8.0, 32.0, 128.0];
/// Polynomials of a shorter series are those of this time, years: they are not to run away outside it.
const SHORTEST_YEARS: f64 = 1.0;
/// Points of the grid with a smaller share of the evidence are left out.
const LEAST: f64 = 1e-4;

/// How a baseline may go. Pillars wander a little in any case: every trend comes with a random walk and without.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Course {
    /// Degree of the polynomial, or the spline.
    trend: Trend,
    walks: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trend {
    Polynomial(usize),
    Spline,
}

impl Course {
    pub fn all() -> impl Iterator<Item = Self> {
        let trends = (0..4).map(Trend::Polynomial).chain([Trend::Spline]);
        trends.flat_map(|trend| [false, true].map(|walks| Self { trend, walks }))
    }

    pub fn name(self) -> String {
        let trend = match self.trend {
            Trend::Polynomial(0) if self.walks => return "random walk".into(),
            Trend::Polynomial(degree) => ["constant", "line", "parabola", "cubic"][degree],
            Trend::Spline => "spline",
        };
        trend.to_string() + if self.walks { " and random walk" } else { "" }
    }

    /// The sizes that its processes may have, of the walk and of the spline, nT after a year.
    fn sizes(self) -> Vec<[f64; 2]> {
        let walks: &[f64] = if self.walks { &WALK_NT } else { &[0.0] };
        let splines: &[f64] = if self.trend == Trend::Spline { &SPLINE_NT } else { &[0.0] };
        walks.iter().flat_map(|walk| splines.iter().map(|spline| [*walk, *spline])).collect()
    }
}

/// What the measurements are explained by, at their times and anywhere else.
pub struct Regressor {
    /// At each measurement.
    pub at: Vec<f64>,
    /// Standard deviation of its coefficient, nT.
    pub prior_nt: f64,
}

/// Measurements of one component.
pub struct Data {
    /// Years since the first.
    pub years: Vec<f64>,
    /// Less their mean, nT.
    pub value_nt: Vec<f64>,
    /// Of the readings alone, nT².
    pub variance: Vec<f64>,
}

/// One course with one size of process and scatter.
struct Point {
    course: Course,
    size_nt: [f64; 2],
    scatter_nt: f64,
    log_evidence: f64,
    factor: Llt<f64>,
    /// K⁻¹ y.
    weights: Col<f64>,
}

/// All courses that matter, each with its share of the evidence.
pub struct Mixture {
    points: Vec<(Point, f64)>,
    span_years: f64,
}

/// What is known at a time that is asked for.
pub struct At {
    pub years: f64,
    /// The regressors there.
    pub regressors: Vec<f64>,
}

impl Mixture {
    /// Weighs the courses.
    ///
    /// Errors: a covariance that is none.
    pub fn of(data: &Data, regressors: &[Regressor]) -> Result<Self, Error> {
        let span_years = data.years.iter().copied().fold(SHORTEST_YEARS, f64::max);
        let mut points = Vec::new();
        for course in Course::all() {
            let sizes = course.sizes();
            let cells = (sizes.len() * SCATTER_NT.len()) as f64;
            for size_nt in sizes {
                let own = Mat::from_fn(data.years.len(), data.years.len(), |i, j| {
                    let shared: f64 = (regressors.iter())
                        .map(|one| one.prior_nt * one.prior_nt * one.at[i] * one.at[j])
                        .sum();
                    shared + covariance(course, size_nt, span_years, [data.years[i], data.years[j]])
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
                    points.push(Point { course, size_nt, scatter_nt, log_evidence, factor, weights });
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

    /// Share of the evidence of each course.
    pub fn probabilities(&self) -> impl Iterator<Item = (Course, f64)> {
        Course::all().map(|course| {
            let own = self.points.iter().filter(|(point, _)| point.course == course);
            (course, own.map(|(_, share)| share).fold(0.0, |sum, share| sum + share))
        })
    }

    /// Mean of the scatter.
    pub fn scatter_nt(&self) -> f64 {
        self.points.iter().map(|(point, share)| share * point.scatter_nt).sum()
    }

    /// The course at some times with its standard uncertainty, nT, the scatter of measurements left out.
    pub fn at(&self, data: &Data, regressors: &[Regressor], times: &[At]) -> Vec<[f64; 2]> {
        let priors: Vec<f64> = regressors.iter().map(|one| one.prior_nt * one.prior_nt).collect();
        let shared = |i: usize, there: &At| -> f64 {
            let each = regressors.iter().zip(&there.regressors).zip(&priors);
            each.map(|((one, there), prior)| prior * one.at[i] * there).sum()
        };
        let mut sums = vec![[0.0; 2]; times.len()];
        for (point, share) in &self.points {
            let of = |a: f64, b: f64| covariance(point.course, point.size_nt, self.span_years, [a, b]);
            let k = Mat::from_fn(data.years.len(), times.len(), |i, j| {
                of(data.years[i], times[j].years) + shared(i, &times[j])
            });
            let (means, solved) = (point.weights.transpose() * &k, point.factor.solve(&k));
            for (j, (at, [sum, squares])) in times.iter().zip(&mut sums).enumerate() {
                let own: f64 =
                    at.regressors.iter().zip(&priors).map(|(there, prior)| prior * there * there).sum();
                let variance = of(at.years, at.years) + own - k.col(j).transpose() * solved.col(j);
                *sum += share * means[j];
                *squares += share * (variance.max(0.0) + means[j] * means[j]);
            }
        }
        sums.into_iter().map(|[mean, squares]| [mean, (squares - mean * mean).max(0.0).sqrt()]).collect()
    }

    /// The coefficient of a regressor with its standard uncertainty.
    pub fn coefficient(&self, of: &Regressor) -> [f64; 2] {
        let square = of.prior_nt * of.prior_nt;
        let x = Col::from_fn(of.at.len(), |i| of.at[i] * square);
        self.averaged(|point| {
            [x.transpose() * &point.weights, square - x.transpose() * point.factor.solve(&x)]
        })
    }

    /// Mean and standard deviation of the mixture of normal distributions.
    fn averaged(&self, of: impl Fn(&Point) -> [f64; 2]) -> [f64; 2] {
        let each: Vec<([f64; 2], f64)> =
            self.points.iter().map(|(point, share)| (of(point), *share)).collect();
        let mean: f64 = each.iter().map(|([mean, _], share)| share * mean).sum();
        let square = |[own, variance]: [f64; 2]| variance.max(0.0) + (own - mean).powi(2);
        let variance: f64 = each.iter().map(|(one, share)| share * square(*one)).sum();
        [mean, variance.sqrt()]
    }

    /// Rms of each measurement less what the others give, of the best point of a course; None where it has no share.
    pub fn left_out_rms(&self, course: Course) -> Option<f64> {
        let own = self.points.iter().filter(|(point, _)| point.course == course);
        let (point, _) = own.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let count = point.weights.nrows();
        let inverse = point.factor.solve(Mat::<f64>::identity(count, count));
        let squares: f64 = (0..count).map(|i| (point.weights[i] / inverse[(i, i)]).powi(2)).sum();
        Some((squares / count as f64).sqrt())
    }
}

/// Covariance of the course at two times, nT².
fn covariance(course: Course, [walk_nt, spline_nt]: [f64; 2], span_years: f64, years: [f64; 2]) -> f64 {
    let [a, b] = years.map(|year| 2.0 * year / span_years - 1.0);
    let degree = match course.trend {
        Trend::Polynomial(degree) => degree,
        Trend::Spline => 1,
    };
    let legendre = |u: f64| [1.0, u, 1.5 * u * u - 0.5, 2.5 * u * u * u - 1.5 * u];
    let (pa, pb) = (legendre(a), legendre(b));
    let polynomial: f64 = (1..=degree).map(|k| DRIFT_NT * DRIFT_NT * pa[k] * pb[k]).sum();
    // Both begin before the first measurement.
    let [near, far] = [years[0].min(years[1]), years[0].max(years[1])].map(|year| year + BEFORE_YEARS);
    // ∫₀ⁿ (n − s)(f − s) ds, 1/3 after a year.
    let integrated = near * near * (3.0 * far - near) / 6.0;
    let process = walk_nt * walk_nt * near + 3.0 * spline_nt * spline_nt * integrated;
    CONSTANT_NT * CONSTANT_NT + polynomial + process
}

/// How long before the first measurement a process begins, years.
const BEFORE_YEARS: f64 = 0.1;
