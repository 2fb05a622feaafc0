use common::IteratedDrift;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::{Columns, Joint};
use crate::Error;
use estimate::cosine::dot;

/// Most rounds.
const MOST_ROUNDS: usize = 500;
/// The drift stands when all rounds to come would move it by less than this share of the difference, each of them by as much less
/// than the one before as the last two.
const STANDS: f64 = 1e-9;
/// Most steps of the drift's fit in one round.
const MOST_STEPS: usize = 30;
/// A fit of the drift ends when ln τ moves less.
const ACCURACY: f64 = 1e-10;
/// A step of less is to a minimum that no sum of squares can tell from where it began.
const NEAR: f64 = 1e-6;
/// A step is halved so often.
const HALVINGS: usize = 12;

/// The drift of least squares for one τ.
#[derive(Clone, Default)]
struct Shape {
    ln_tau: f64,
    /// b (nT/day) and a (nT).
    linear: [f64; 2],
    /// Step of ln τ to the minimum if the sum of squares were parabolic.
    step: f64,
    explained: f64,
    drift: Vec<f64>,
}

/// The source's way, from η without a drift: the drift b t + a e^(−t/τ) is fitted to T − R η by least squares and taken from T,
/// η is fitted again, until the drift stands. Its end is the least-squares fit of all together: what each step lowers is the
/// same sum of squares.
///
/// Source: DIFF, "linear regression method", the paragraph after eq. 20.
pub fn iterate(columns: &Columns<'_>, test: &[f64], joint: &Joint) -> Result<IteratedDrift, Error> {
    let reference = columns.pair.reference.each_ref().map(|column| centred(column));
    let test = centred(test);
    let gram = Matrix3::from_fn(|i, j| dot(&reference[i], &reference[j]));
    let inverse = gram.try_inverse().ok_or_else(|| {
        Error::Undetermined("the three axes of the reference depend on each other".to_owned())
    })?;
    let matrix = |y: &[f64]| -> Vector3<f64> { inverse * Vector3::from_fn(|i, _| dot(&reference[i], y)) };
    let difference = |eta: &Vector3<f64>| -> Vec<f64> {
        let row = |k: usize| test[k] - (0..3).map(|i| eta[i] * reference[i][k]).sum::<f64>();
        (0..test.len()).map(row).collect()
    };
    let mut eta = matrix(&test);
    let d = difference(&eta);
    let mut shape = columns
        .search
        .iter()
        .map(|(ln_tau, _)| at(columns, &d, *ln_tau))
        .max_by(|a, b| a.explained.total_cmp(&b.explained))
        .unwrap_or_default();
    let (mut rounds, mut settled, mut moved_before) = (0, false, f64::INFINITY);
    while rounds < MOST_ROUNDS && !settled {
        rounds += 1;
        let d = difference(&eta);
        let before = shape.drift;
        shape = fit(columns, &d, shape.ln_tau);
        let corrected: Vec<f64> = test.iter().zip(&shape.drift).map(|(t, drift)| t - drift).collect();
        eta = matrix(&corrected);
        let moved = shape.drift.iter().zip(&before).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let ratio = moved / moved_before;
        settled = rounds > 1 && moved <= STANDS * (1.0 / ratio - 1.0) * dot(&d, &d).sqrt();
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
        from_joint_std: std::array::from_fn(|i| (found[i] - values[i]) / covariance[i][i].sqrt()),
    })
}

fn centred(values: &[f64]) -> Vec<f64> {
    let middle = crate::regression::mean(values);
    values.iter().map(|value| value - middle).collect()
}

/// b and a for one τ, and the step to a better one.
fn at(columns: &Columns<'_>, d: &[f64], ln_tau: f64) -> Shape {
    let [plain, slope] = columns.exponential(ln_tau).map(|column| centred(&column));
    let all = [&columns.days, &plain, &slope];
    let gram = Matrix3::from_fn(|i, j| dot(all[i], all[j]));
    let right = Vector3::from_fn(|i, _| dot(all[i], d));
    let two: Matrix2<f64> = gram.fixed_view::<2, 2>(0, 0).into();
    let linear = two.try_inverse().map_or(Vector2::zeros(), |inverse| inverse * right.fixed_rows::<2>(0));
    // Kaufman's step: what the slope explains beside the two, as a change of ln τ.
    let all_three = gram.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * right);
    let drift = columns.days.iter().zip(&plain).map(|(t, e)| linear[0] * t + linear[1] * e).collect();
    Shape {
        ln_tau,
        linear: linear.into(),
        step: all_three[2] / all_three[1],
        explained: linear.dot(&right.fixed_rows::<2>(0)),
        drift,
    }
}

/// The drift of least squares from a start of τ.
fn fit(columns: &Columns<'_>, d: &[f64], start: f64) -> Shape {
    let (low, high) = columns.limits();
    let mut best = at(columns, d, start);
    for _ in 0..MOST_STEPS {
        let mut step = best.step.clamp(-1.0, 1.0);
        let mut better = None;
        for _ in 0..HALVINGS {
            let next = at(columns, d, (best.ln_tau + step).clamp(low, high));
            if next.explained > best.explained || step.abs() < NEAR {
                better = Some(next);
                break;
            }
            step /= 2.0;
        }
        let Some(next) = better else { break };
        let moved = (next.ln_tau - best.ln_tau).abs();
        best = next;
        if moved < ACCURACY {
            break;
        }
    }
    best
}
