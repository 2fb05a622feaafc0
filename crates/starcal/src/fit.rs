//! The fit: least squares by the products of the rows, with weights by the scatter of each kind of row, and the
//! uncertainty by what each window of time says.

use estimate::linear::mirrored;
use estimate::stats::coverage_factor;
use faer::linalg::solvers::Solve;
use faer::{Col, Mat, Side};

use crate::Error;
use crate::layout::{Layout, Signal};
use crate::partial::{DELAYS, DIRECTIONS, PLACES, Partial, Products};
use crate::terms::Direction;

/// Rounds in which weights and coefficients settle.
const ROUNDS: usize = 6;
/// Directions of which the readings say less than this share of what they say of the others are not determined.
const UNDETERMINED: f64 = 1e-10;
/// The variance of the place with the most rows counts as so many rows.
const SHRUNK: f64 = 10.0;
/// Least variance of a row, nT²: the products keep no more.
const LEAST: f64 = 1e-4;

/// Numbers by kind of place and direction.
pub type Kinds = [[f64; DIRECTIONS]; PLACES];
type OfWindow = [[Products; DIRECTIONS]; PLACES];

/// The products of a camera's rows.
pub struct Flight<'a> {
    /// Of each window its time, from −1 to 1, and its products.
    windows: Vec<(f64, &'a OfWindow)>,
    /// Half of the time that is covered, s.
    pub half_span_s: f64,
    /// TAI less UTC in the middle of it, s.
    pub leap_s: Option<f64>,
    pub count: usize,
}

#[derive(Clone, Debug)]
pub struct Fit {
    /// A unit for each direction.
    pub values: Vec<f64>,
    /// Variances of the rows, nT².
    pub variances: Kinds,
    pub covariance: Mat<f64>,
    /// The same with few windows correlated.
    pub short: Mat<f64>,
}

/// Normal equations about a state: the matrix and the right side.
struct Normal {
    matrix: Mat<f64>,
    right: Col<f64>,
}

/// Values with the normal equations of each window about them, their sum and its inverse.
struct Solved {
    values: Vec<f64>,
    normals: Vec<Normal>,
    whole: Normal,
    nominal: Mat<f64>,
}

impl<'a> Flight<'a> {
    pub fn of(partial: &'a Partial, camera: usize) -> Self {
        let windows: Vec<(f64, &OfWindow)> =
            partial.windows().map(|(time, window)| (time, &window[camera])).collect();
        let first = windows.first().map_or(0.0, |(time, _)| *time);
        let last = windows.last().map_or(0.0, |(time, _)| *time);
        let half_span_s = (0.5 * (last - first)).max(1.0);
        let middle = 0.5 * (first + last);
        let windows = windows.into_iter().map(|(time, window)| ((time - middle) / half_span_s, window));
        let (leap_s, count) = (mainfield::leap_s(middle), partial.layout.signals(camera).len());
        Self { windows: windows.collect(), half_span_s, leap_s, count }
    }

    pub fn windows(&self) -> usize {
        self.windows.len()
    }

    /// Lags up to which windows are taken as correlated: a quarter of all, and a few.
    fn lags(&self) -> [usize; 2] {
        let long = self.windows.len() / 4;
        [long, long.min(3)]
    }

    /// Degrees of freedom of Student's t that has the factor of 95 % intervals with a covariance by these (N. M. Kiefer,
    /// T. J. Vogelsang, Econometric Theory 21 (2005) 1130, table 1, Bartlett's kernel).
    pub fn freedom(&self) -> [f64; 2] {
        self.lags().map(|lags| {
            let share = (lags + 1) as f64 / self.windows.len() as f64;
            let factor = 1.96 + share * (2.9694 + share * (0.4160 - 0.5324 * share));
            let (mut low, mut high) = (1.0f64, 1e4f64);
            for _ in 0..60 {
                let middle = (low * high).sqrt();
                *(if coverage_factor(0.95, middle) > factor { &mut low } else { &mut high }) = middle;
            }
            low
        })
    }

    /// What is left of the field at a time by the coefficients, as a combination of the columns of the products.
    fn left(&self, directions: &[Direction], values: &[f64], time: f64) -> Vec<f64> {
        let mut all = vec![0.0; 3 * self.count + DELAYS];
        for (one, value) in directions.iter().zip(values) {
            one.coefficients.iter().for_each(|(place, size)| all[*place] -= value * size * one.factor(time));
        }
        all.push(1.0);
        all
    }

    /// The products of each window, each kind of row by the weight of its variance.
    pub fn weighted(&self, variances: &Kinds) -> Vec<Mat<f64>> {
        let width = 3 * self.count + DELAYS + 1;
        let of = |(_, window): &(f64, &OfWindow)| {
            let mut sum = Mat::zeros(width, width);
            let all = window.iter().flatten().zip(variances.iter().flatten());
            all.for_each(|(products, variance)| products.add_to(&mut sum, 1.0 / variance));
            sum
        };
        self.windows.iter().map(of).collect()
    }

    fn normal(&self, directions: &[Direction], values: &[f64], weighted: &[Mat<f64>]) -> Vec<Normal> {
        let count = directions.len();
        let of = |((time, _), sum): (&(f64, &OfWindow), &Mat<f64>)| {
            let mut normal = Normal { matrix: Mat::zeros(count, count), right: Col::zeros(count) };
            let left = combined(sum, self.left(directions, values, *time).into_iter().enumerate());
            let places = |one: &'_ Direction| -> Vec<(usize, f64)> {
                let factor = one.factor(*time);
                one.coefficients.iter().map(|(place, size)| (*place, size * factor)).collect()
            };
            let columns: Vec<Vec<f64>> =
                directions.iter().map(|one| combined(sum, places(one).into_iter())).collect();
            for (i, one) in directions.iter().enumerate() {
                let own = places(one);
                let along =
                    |column: &[f64]| own.iter().map(|(place, size)| column[*place] * size).sum::<f64>();
                normal.right[i] = along(&left);
                (0..=i).for_each(|j| normal.matrix[(i, j)] = along(&columns[j]));
            }
            normal.matrix = mirrored(normal.matrix);
            normal
        };
        self.windows.iter().zip(weighted).map(of).collect()
    }

    pub fn mean(&self, layout: &Layout, signal: &Signal) -> f64 {
        let signals = layout.signals(0);
        let place = |of: &Signal| signals.iter().position(|one| one == of).unwrap_or_default();
        let (one, of) = (place(&Signal::One), place(signal));
        let windows = self.weighted(&[[1.0; DIRECTIONS]; PLACES]);
        let [sum, rows] =
            [of, one].map(|place| windows.iter().map(|window| window[(one, place)]).sum::<f64>());
        sum / rows
    }

    pub fn rows(&self) -> Kinds {
        let mut rows = Kinds::default();
        for (_, window) in &self.windows {
            let all = rows.iter_mut().flatten().zip(window.iter().flatten());
            all.for_each(|(sum, products)| *sum += products.rows);
        }
        rows
    }

    fn variances(&self, directions: &[Direction], values: &[f64]) -> Kinds {
        let mut found = Kinds::default();
        for (time, window) in &self.windows {
            let left = self.left(directions, values, *time);
            let all = found.iter_mut().flatten().zip(window.iter().flatten());
            all.for_each(|(sum, products)| *sum += products.squares(&left));
        }
        // Of few rows it is shrunk towards that of the place with the most.
        let rows = self.rows();
        let most = usize::from(rows[1][0] > rows[0][0]);
        let usual: [f64; DIRECTIONS] = std::array::from_fn(|k| found[most][k] / rows[most][k].max(1.0));
        for (variances, rows) in found.iter_mut().zip(&rows) {
            for (direction, variance) in variances.iter_mut().enumerate() {
                let sum = *variance + SHRUNK * usual[direction];
                *variance = (sum / (rows[direction] + SHRUNK)).max(LEAST);
            }
        }
        found
    }

    /// The values by weights as they are, with the normal equations about them and their inverse.
    /// Errors: what the rows do not determine.
    fn solve(&self, directions: &[Direction], weighted: &[Mat<f64>]) -> Result<Solved, Error> {
        let mut values = vec![0.0; directions.len()];
        // Once more, for the digits that the first step loses.
        for _ in 0..2 {
            let whole = Normal::sum(&self.normal(directions, &values, weighted));
            let step = inverse(&whole.matrix)? * &whole.right;
            values.iter_mut().zip(step.iter()).for_each(|(value, step)| *value += step);
        }
        let normals = self.normal(directions, &values, weighted);
        let whole = Normal::sum(&normals);
        let nominal = inverse(&whole.matrix)?;
        Ok(Solved { values, normals, whole, nominal })
    }

    /// The fit with weights as they are. Errors: what the rows do not determine.
    pub fn fit(
        &self,
        directions: &[Direction],
        variances: Kinds,
        weighted: &[Mat<f64>],
    ) -> Result<Fit, Error> {
        let solved = self.solve(directions, weighted)?;
        let moved = moved(&solved);
        let Solved { values, nominal, .. } = solved;
        let [covariance, short] = self.lags().map(|lags| by_windows(&moved, &nominal, lags));
        Ok(Fit { values, variances, covariance, short })
    }

    /// The fit with the weights that follow from it, from some that are near. Errors: what the rows do not determine.
    pub fn settled(&self, directions: &[Direction], from: &Kinds) -> Result<Fit, Error> {
        let mut variances = *from;
        for _ in 0..ROUNDS {
            let solved = self.solve(directions, &self.weighted(&variances))?;
            variances = self.variances(directions, &solved.values);
        }
        self.fit(directions, variances, &self.weighted(&variances))
    }
}

impl Normal {
    fn sum(all: &[Self]) -> Self {
        let count = all.first().map_or(0, |one| one.right.nrows());
        let mut sum = Self { matrix: Mat::zeros(count, count), right: Col::zeros(count) };
        for one in all {
            sum.matrix += &one.matrix;
            sum.right += &one.right;
        }
        sum
    }
}

fn combined(sum: &Mat<f64>, places: impl Iterator<Item = (usize, f64)>) -> Vec<f64> {
    let mut all = vec![0.0; sum.nrows()];
    for (place, size) in places {
        all.iter_mut().zip(sum.col_as_slice(place)).for_each(|(one, value)| *one += size * value);
    }
    all
}

/// The inverse of a matrix of normal equations. Errors: one that is singular.
fn inverse(matrix: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let count = matrix.nrows();
    let scale: Vec<f64> = (0..count).map(|k| matrix[(k, k)].sqrt().recip()).collect();
    let undetermined = || {
        Error::Unanswerable("the rows do not determine the calibration: the field, seen from the camera, lies in too few directions. Record more attitudes or more of the orbit".into())
    };
    if scale.iter().any(|scale| !scale.is_finite()) {
        return Err(undetermined());
    }
    let scaled = Mat::from_fn(count, count, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let own = scaled.self_adjoint_eigenvalues(Side::Lower).map_err(|_| undetermined())?;
    if own.iter().any(|value| *value < UNDETERMINED) {
        return Err(undetermined());
    }
    let factor = scaled.llt(Side::Lower).map_err(|_| undetermined())?;
    let inverse = factor.solve(Mat::<f64>::identity(count, count));
    Ok(Mat::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

/// How the values move without each window (jackknife).
fn moved(Solved { normals, whole, nominal, .. }: &Solved) -> Vec<Col<f64>> {
    let of = |normal: &Normal| -> Col<f64> {
        let right = &normal.right - &whole.right * faer::Scale(1.0 / normals.len() as f64);
        match (&whole.matrix - &normal.matrix).llt(Side::Lower) {
            Ok(without) => -without.solve(&right),
            Err(_) => -(nominal * &right),
        }
    };
    normals.iter().map(of).collect()
}

/// The covariance by these, windows up to some lag being correlated (W. K. Newey, K. D. West, Econometrica 55 (1987)
/// 703). No variance is below that of independent rows, and the correlations by few windows are shrunk towards those.
fn by_windows(moved: &[Col<f64>], nominal: &Mat<f64>, lags: usize) -> Mat<f64> {
    let (count, all) = (moved.len(), nominal.nrows());
    if count < 2 {
        return nominal.clone();
    }
    let mut sum = Mat::<f64>::zeros(all, all);
    for lag in 0..=lags.min(count - 1) {
        let weight = 1.0 - lag as f64 / (lags + 1) as f64;
        for (one, other) in moved.iter().zip(&moved[lag..]) {
            let product = one * other.transpose();
            sum += if lag == 0 { product } else { (&product + product.transpose()) * faer::Scale(weight) };
        }
    }
    let share = (count as f64 - 1.0) / count as f64;
    let own = |k: usize| (share * sum[(k, k)]).max(f64::MIN_POSITIVE);
    let std: Vec<f64> = (0..all).map(|k| own(k).max(nominal[(k, k)]).sqrt()).collect();
    let shrunk = all as f64 / (all + count) as f64;
    Mat::from_fn(all, all, |i, j| {
        let by_windows = share * sum[(i, j)] / (own(i) * own(j)).sqrt();
        let independent = nominal[(i, j)] / (nominal[(i, i)] * nominal[(j, j)]).sqrt();
        std[i] * std[j] * ((1.0 - shrunk) * by_windows + shrunk * independent)
    })
}
