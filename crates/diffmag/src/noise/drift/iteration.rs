use common::IteratedDrift;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::columns::Columns;
use super::joint::Joint;
use super::moments::Moments;
use crate::Error;
use estimate::dot;
use estimate::line_search;
use paired::residual::centred;

const MOST_ROUNDS: usize = 500;
/// The drift stands when all rounds to come would move it by less than this share of the difference, each of
/// them by as much less than the one before as the last two.
const STANDS: f64 = 1e-9;
/// A fit of the drift ends when ln τ moves less.
const ACCURACY: f64 = 1e-10;
/// A step of less is to a minimum that no sum of squares can tell from where it began.
const NEAR: f64 = 1e-6;

/// The drift of least squares for one τ.
#[derive(Clone, Default)]
struct Shape {
    ln_tau: f64,
    /// b (nT/day) and a (nT).
    linear: [f64; 2],
    /// Step of ln τ to the minimum if the sum of squares were parabolic.
    step: f64,
    explained: f64,
    /// Sums of products of the days, the exponential and its derivative with respect to ln τ, each less its
    /// mean.
    gram: Matrix3<f64>,
}

impl Shape {
    /// Root of the sum of squares of what the drift changed by, to first order in ln τ.
    fn moved(&self, before: &Self) -> f64 {
        let [straight, amplitude] = self.linear;
        let turned = amplitude * (self.ln_tau - before.ln_tau);
        let along = Vector3::new(straight - before.linear[0], amplitude - before.linear[1], turned);
        along.dot(&(self.gram * along)).max(0.0).sqrt()
    }
}

/// The source's way, from η without a drift: the drift b t + a e^(−t/τ) is fitted to T − R η by least squares
/// and taken from T, η is fitted again, until the drift stands. Its end is the least-squares fit of all
/// together: what each step lowers is the same sum of squares.
///
/// Source: DIFF, "linear regression method", the paragraph after eq. 20.
pub fn iterate(columns: &Columns<'_>, test: &[f64], joint: &Joint) -> Result<IteratedDrift, Error> {
    let sums = Sums::of(columns, test);
    let dependent = || Error::Unanswerable("the three axes of the reference depend on each other".into());
    let inverse = sums.reference.try_inverse().ok_or_else(dependent)?;
    let mut eta = inverse * sums.test;
    let d = sums.difference(&eta);
    let starts = columns.search().map(|(ln_tau, _)| sums.at(&d, ln_tau));
    let mut shape = starts.max_by(|a, b| a.explained.total_cmp(&b.explained)).unwrap_or_default();
    let (mut rounds, mut settled, mut moved_before) = (0, false, f64::INFINITY);
    while rounds < MOST_ROUNDS && !settled {
        rounds += 1;
        let d = sums.difference(&eta);
        let next = sums.fit(&d, shape.ln_tau, columns.limits());
        let moved = next.moved(&shape);
        shape = next;
        eta = inverse * (sums.test - sums.of_drift(&shape));
        let ratio = moved / moved_before;
        settled = rounds > 1 && moved <= STANDS * (1.0 / ratio - 1.0) * d.size;
        moved_before = moved;
    }
    let [straight, amplitude] = shape.linear;
    let found = [eta[0], eta[1], eta[2], straight, amplitude, shape.ln_tau];
    let (values, covariance) = (joint.values(), joint.covariance());
    Ok(IteratedDrift {
        rounds,
        settled,
        eta: eta.into(),
        straight_nt_per_day: straight,
        amplitude_nt: amplitude,
        time_constant_s: shape.ln_tau.exp(),
        from_joint_std: std::array::from_fn(|i| (found[i] - values[i]) / covariance[(i, i)].sqrt()),
    })
}

/// All that the iteration needs of the rows: products of the columns, each less its mean, and moments for
/// those with an exponential.
struct Sums {
    rows: f64,
    step_s: f64,
    /// Of the reference's axes with each other, with the test axis and with the days.
    reference: Matrix3<f64>,
    test: Vector3<f64>,
    reference_days: Vector3<f64>,
    /// Of the test axis with itself and with the days, of the days with themselves.
    squares: f64,
    test_days: f64,
    days_days: f64,
    moments_of_reference: [Moments; 3],
    moments_of_test: Moments,
    moments_of_days: Moments,
    /// Of ones, and of the numbers of the rows.
    moments_of_ones: Moments,
    moments_of_rows: Moments,
}

/// T − R η.
struct Difference {
    moments: Moments,
    /// Its product with the days.
    days: f64,
    /// Root of its sum of squares.
    size: f64,
}

impl Sums {
    fn of(columns: &Columns<'_>, test: &[f64]) -> Self {
        let (reference, days) = (columns.pair.reference.each_ref().map(|of| centred(of)), &columns.days);
        let test = centred(test);
        let step_s = columns.pair.step_s;
        // An exponential's square decays twice as fast.
        let moments = |values: &[f64]| Moments::of(values, 2.0 * step_s * (-columns.limits().0).exp());
        let numbers: Vec<f64> = (0..days.len()).map(|row| row as f64).collect();
        Self {
            rows: days.len() as f64,
            step_s,
            reference: Matrix3::from_fn(|i, j| dot(&reference[i], &reference[j])),
            test: Vector3::from_fn(|i, _| dot(&reference[i], &test)),
            reference_days: Vector3::from_fn(|i, _| dot(&reference[i], days)),
            squares: dot(&test, &test),
            test_days: dot(&test, days),
            days_days: dot(days, days),
            moments_of_reference: reference.each_ref().map(|of| moments(of)),
            moments_of_test: moments(&test),
            moments_of_days: moments(days),
            moments_of_ones: moments(&vec![1.0; days.len()]),
            moments_of_rows: moments(&numbers),
        }
    }

    fn difference(&self, eta: &Vector3<f64>) -> Difference {
        let squares = self.squares - 2.0 * eta.dot(&self.test) + eta.dot(&(self.reference * eta));
        Difference {
            moments: self.moments_of_test.less(&self.moments_of_reference, (*eta).into()),
            days: self.test_days - eta.dot(&self.reference_days),
            size: squares.max(0.0).sqrt(),
        }
    }

    fn rate(&self, ln_tau: f64) -> f64 {
        self.step_s * (-ln_tau).exp()
    }

    /// Products of a drift with the reference's axes.
    fn of_drift(&self, shape: &Shape) -> Vector3<f64> {
        let rate = self.rate(shape.ln_tau);
        let plain = Vector3::from_fn(|i, _| self.moments_of_reference[i].sums(rate)[0]);
        shape.linear[0] * self.reference_days + shape.linear[1] * plain
    }

    /// Products of the days, e^(−t/τ) and its derivative with respect to ln τ with each other, each less its
    /// mean.
    fn gram(&self, rate: f64) -> Matrix3<f64> {
        let [plain, slope] = self.moments_of_ones.sums(rate);
        let [days_plain, days_slope] = self.moments_of_days.sums(rate);
        let [plain_plain, twice_plain_slope] = self.moments_of_ones.sums(2.0 * rate);
        let [_, rows_slope] = self.moments_of_rows.sums(2.0 * rate);
        let plain_plain = plain_plain - plain * plain / self.rows;
        let plain_slope = 0.5 * twice_plain_slope - plain * slope / self.rows;
        let slope_slope = 0.5 * rate * rows_slope - slope * slope / self.rows;
        Matrix3::from([
            [self.days_days, days_plain, days_slope],
            [days_plain, plain_plain, plain_slope],
            [days_slope, plain_slope, slope_slope],
        ])
    }

    /// b and a for one τ, and the step to a better one.
    fn at(&self, d: &Difference, ln_tau: f64) -> Shape {
        let rate = self.rate(ln_tau);
        let gram = self.gram(rate);
        let [plain, slope] = d.moments.sums(rate);
        let right = Vector3::new(d.days, plain, slope);
        let two: Matrix2<f64> = gram.fixed_view::<2, 2>(0, 0).into();
        let linear = two.try_inverse().map_or(Vector2::zeros(), |inverse| inverse * right.fixed_rows::<2>(0));
        // Kaufman's step: what the slope explains beside the two, as a change of ln τ.
        let all_three = gram.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * right);
        Shape {
            ln_tau,
            linear: linear.into(),
            step: all_three[2] / all_three[1],
            explained: linear.dot(&right.fixed_rows::<2>(0)),
            gram,
        }
    }

    fn fit(&self, d: &Difference, start: f64, limits: (f64, f64)) -> Shape {
        let step = |(_, shape): &(f64, Shape)| Some(shape.step);
        let above = |(before, shape): &(f64, Shape), ln_tau: f64| {
            let next = self.at(d, ln_tau);
            (next.explained > shape.explained || (ln_tau - before).abs() < NEAR).then_some(next)
        };
        line_search::climb((start, self.at(d, start)), limits, ACCURACY, step, above).1
    }
}
