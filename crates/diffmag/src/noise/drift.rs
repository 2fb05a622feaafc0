//! The drift of the difference: b t + a e^(−t/τ) beside η, under correlated noise.

mod change;
mod columns;
mod iteration;
mod joint;
mod moments;
mod weighed;

pub use columns::{Beside, Columns};
pub use joint::{Joint, LEVEL, joint};
pub use weighed::weighed;

use common::{Drift, DriftExplanations, DriftForm, JointDrift, Quantity, WindowMean};
use estimate::cosine::{Errors, Regression};
use estimate::stats;
use faer::MatRef;

use crate::Error;
use joined::DAY_S;
use paired::noise::Noise;

/// Windows of which means are told, and the least samples of one.
const WINDOWS: usize = 12;
const LEAST_OF_WINDOW: usize = 32;

/// Means of a difference, its drift in it, over equal windows, about the mean of all. Their uncertainties are
/// those of the mean of noise over a window, and what the uncertainty of η (`matrix` its covariance) makes of
/// the field's mean there. None of short recordings.
pub fn window_means(
    difference: &[f64],
    columns: &Columns<'_>,
    errors: &Errors,
    matrix: MatRef<'_, f64>,
) -> Vec<WindowMean> {
    let (pair, count) = (columns.pair, difference.len() / WINDOWS);
    if count < LEAST_OF_WINDOW {
        return Vec::new();
    }
    let of_all = stats::mean(difference);
    let field = pair.reference.each_ref().map(|column| stats::mean(column));
    let of = |number: usize| {
        let rows = number * count..(number + 1) * count;
        let mean = columns.cosine.mean_over(rows.clone());
        let noise = errors.covariance_of(&mean, &mean);
        let moved: [f64; 3] =
            std::array::from_fn(|axis| stats::mean(&pair.reference[axis][rows.clone()]) - field[axis]);
        let of_matrix: f64 = (0..9).map(|at| moved[at / 3] * moved[at % 3] * matrix[(at / 3, at % 3)]).sum();
        WindowMean {
            time_s: 0.5 * (pair.time_s(rows.start) + pair.time_s(rows.end - 1)),
            mean_nt: Quantity::new(stats::mean(&difference[rows]) - of_all, (noise + of_matrix).sqrt()),
        }
    };
    (0..WINDOWS).map(of).collect()
}

/// What is said of the drift of one axis: `regression` and `noise` are those that the matrix is from.
pub fn describe(
    columns: &Columns<'_>,
    test: &[f64],
    regression: &Regression,
    noise: &Noise,
    (joint, weighed): (Option<&Joint>, Option<DriftExplanations>),
) -> Result<Drift, Error> {
    let demanded = joint.filter(|joint| joint.p < LEVEL);
    let freedom = noise.freedom(&columns.cosine, &regression.influence[3]);
    let (slope, std) = (regression.coefficients[3], regression.covariance[(3, 3)].sqrt());
    let own =
        (Quantity::new(slope, std * joint::widening(freedom)), stats::two_sided_p(slope / std, freedom));
    let straight = weighed.as_ref().and_then(|weighed| weighed::named(weighed, slope));
    let form = match (straight.is_some(), demanded.is_some()) {
        (false, false) => DriftForm::None,
        (true, false) => DriftForm::Straight,
        (false, true) => DriftForm::Exponential,
        (true, true) => DriftForm::Both,
    };
    let length_s = columns.length_s();
    let over = |days: f64| {
        // What the columns change by after the last row.
        let mut moved = vec![0.0, 0.0, 0.0, days];
        if let Some(joint) = demanded {
            let [now, now_slope] = decayed(length_s, joint.ln_tau);
            let [then, then_slope] = decayed(length_s + days * DAY_S, joint.ln_tau);
            moved.extend([then - now, then_slope - now_slope]);
        }
        let value = moved.iter().zip(&regression.coefficients).map(|(x, c)| x * c).sum();
        let row =
            |i: usize| -> f64 { (0..moved.len()).map(|j| moved[j] * regression.covariance[(i, j)]).sum() };
        let variance: f64 = (0..moved.len()).map(|i| moved[i] * row(i)).sum();
        let drift = (value, variance.sqrt(), freedom);
        change::change(days * DAY_S, drift, noise, (length_s, columns.pair.step_s))
    };
    let (straight_nt_per_day, straight_p) = straight.unwrap_or(own);
    Ok(Drift {
        demanded: form,
        level: LEVEL,
        straight_nt_per_day,
        straight_p,
        exponential_p: joint.map_or(1.0, |joint| joint.p),
        explanations: weighed,
        joint: joint.map(Joint::document),
        iteration: demanded.map(|joint| iteration::iterate(columns, test, joint)).transpose()?,
        per_day: Some(over(1.0)),
        per_month: Some(over(30.4375)),
        per_year: Some(over(365.25)),
        ..Drift::default()
    })
}

/// The exponential drift, where it is demanded.
pub fn exponential(drift: &Drift) -> Option<&JointDrift> {
    drift.joint.as_ref().filter(|_| matches!(drift.demanded, DriftForm::Exponential | DriftForm::Both))
}

/// e^(−t/τ) and its derivative with respect to ln τ.
fn decayed(time_s: f64, ln_tau: f64) -> [f64; 2] {
    let turns = time_s * (-ln_tau).exp();
    [(-turns).exp(), turns * (-turns).exp()]
}
