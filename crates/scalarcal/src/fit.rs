//! The calibration of least squares from the factors of the products.

use estimate::{Options, Svd, solve};
use faer::{ColRef, Mat, RowRef, Scale, Side};

use crate::Error;
use crate::given::Given;
use crate::linear::{Linear, RANK_TOLERANCE};
use crate::model::{Model, Problem, State};
use crate::terms::{Factor, ONE, added_by_noise};

/// Rounds in which the noise that is taken off, the size of the residuals and the parameters settle.
const ROUNDS: usize = 4;
/// Noise may be at most this share of what the products show in a direction.
const NOISE_ALONE: f64 = 1.0 - 1e-6;
/// A direction of the products below this share of the largest is not there.
const ABSENT: f64 = 1e-14;
/// No magnetometer reads better than this share of the magnitude; below, rounding would hide the minimum.
const FINEST: f64 = 1e-9;

/// A calibration; variances are over the square of the typical magnitude times [`Model::scale`].
#[derive(Clone, Debug)]
pub struct FittedState {
    pub state: State,
    pub covariance: Mat<f64>,
    /// What the readings alone say: a factor of the whitened derivatives, with what is held.
    pub jacobian: Mat<f64>,
    /// The decomposition of that.
    pub seen: Svd,
    pub variance: f64,
    /// Variance of the noise along a sensor that was allowed for.
    pub sensor: f64,
    /// Variance of the noise of the reference that was allowed for.
    pub reference: f64,
    pub freedom: f64,
}

/// Fits products of rows from the best of the starts. Of noise that is not declared the sensors have what the
/// residuals scatter, less that of the reference. The least squares of the products as they were read are
/// biased by the noise in them, which [`added_by_noise`] gives and [`without`] takes off. `held` is what no
/// reading shows, `known` that with what is known beforehand.
///
/// Errors: [`Error::Unanswerable`] without more rows than parameters, [`Error::Fit`] without a minimum.
pub fn fit(
    given: &Given,
    model: &Model,
    plain: &Factor,
    (held, known): (&Linear, &Linear),
    starts: &[State],
) -> Result<FittedState, Error> {
    let (rows, count) = (plain.rows, model.parameters.len());
    let freedom = rows as f64 - count as f64;
    if freedom < 1.0 {
        return Err(Error::Unanswerable(format!(
            "{rows} complete rows for {count} parameters; expected more rows than parameters"
        )));
    }
    let upper = plain.upper();
    // Least squares that begin at a state, with residuals of a variance and with the scale of that state.
    let round = |start: &State, variance: f64| -> Result<FittedState, Error> {
        let variance = variance.max(FINEST * FINEST);
        let declared = given.sensor.map(|sensor| sensor / model.scale(start).powi(2));
        let sensor = declared.unwrap_or((variance - given.reference).max(0.0));
        let added = added(model, start, (sensor, given.reference), plain);
        let adjusted = without(&upper, added) * Scale(1.0 / variance.sqrt());
        let problem = Problem { model, upper: &adjusted, known };
        let fit = solve(&problem, start.clone(), None, &Options::default())?;
        let jacobian = fit.jacobian.subrows(0, adjusted.nrows() + held.right.len()).to_owned();
        let variance = self::variance(model, &upper, &fit.state, freedom).max(FINEST * FINEST);
        Ok(FittedState {
            covariance: fit.svd.covariance(),
            state: fit.state,
            seen: Svd::of(jacobian.as_ref(), RANK_TOLERANCE)?,
            jacobian,
            variance,
            sensor,
            reference: given.reference,
            freedom,
        })
    };
    // The residuals of a start may be no noise at all: of offsets that are known loosely they are far larger.
    // Where no minimum is found so, they are taken to be as linear least squares leaves them.
    let begin = |explains: bool| -> Result<FittedState, Error> {
        let mut failed = Error::Unanswerable("there is no calibration to begin with".into());
        let mut best: Option<FittedState> = None;
        for start in starts {
            let left = match explained(model, &upper, start) {
                Some((_, squares)) if explains => squares / freedom,
                _ => variance(model, &upper, start, freedom),
            };
            match round(start, left) {
                Ok(found) if best.as_ref().is_none_or(|best| scatter(&found) < scatter(best)) => {
                    best = Some(found)
                }
                Ok(_) => {}
                Err(error) => failed = error,
            }
        }
        let mut found = best.ok_or(failed)?;
        for _ in 1..ROUNDS {
            found = round(&found.state, found.variance)?;
        }
        Ok(found)
    };
    begin(false).or_else(|error| begin(true).map_err(|_| error))
}

/// Variance of the residuals in the unit of the readings: without sensitivity no residual would be left.
fn scatter(found: &FittedState) -> f64 {
    found.variance / found.state[..3].iter().product::<f64>().abs().powf(2.0 / 3.0)
}

/// What noise of sensors and reference, over the squared magnitude, adds to the products of a factor.
fn added(model: &Model, state: &State, (sensor, reference): (f64, f64), plain: &Factor) -> Mat<f64> {
    let mut noise = vec![0.0; model.terms.columns + 1];
    let scale = model.scale(state);
    (0..3).for_each(|axis| noise[axis] = sensor * (scale / state[axis]).powi(2));
    noise[model.terms.columns] = reference;
    let one = model.terms.product(ONE, ONE);
    let moments = |f: usize, g: usize| model.terms.place(f, g).map_or(0.0, |place| plain.product(place, one));
    added_by_noise(&model.terms, &noise, moments)
}

/// Rows about a fit, as a factor of each of some factors of the products: what is to be explained, and its
/// derivatives by the parameters. Of the derivatives is taken off what the noise that is to be explained
/// makes of them: they would be correlated with it.
pub fn about(model: &Model, found: &FittedState, plain: &[&Factor]) -> Option<Vec<Mat<f64>>> {
    let (coefficients, slopes) = (model.coefficients(&found.state)?, model.slopes(&found.state)?);
    let map = Mat::from_fn(slopes.nrows(), 1 + slopes.ncols(), |i, j| {
        if j == 0 { -coefficients[i] } else { slopes[(i, j - 1)] }
    });
    let of = |factor: &&Factor| {
        let added = added(model, &found.state, (found.sensor, found.reference), factor);
        let scatter = factor.rows as f64 * found.variance;
        let mut shares = RowRef::from_slice(&coefficients) * added * &map * Scale(-1.0 / scatter);
        shares[0] = 0.0;
        let rows = factor.upper() * &map;
        &rows - rows.col(0) * shares
    };
    Some(plain.iter().map(of).collect())
}

/// Variance of the residuals of a state: r is the row of products times their coefficients.
pub fn variance(model: &Model, upper: &Mat<f64>, state: &State, freedom: f64) -> f64 {
    let Some(coefficients) = model.coefficients(state) else { return f64::INFINITY };
    (upper * ColRef::from_slice(&coefficients)).squared_norm_l2() / freedom
}

/// The derivatives of the residuals at a state, and the sum of squares that linear least squares leave.
pub fn explained(model: &Model, upper: &Mat<f64>, state: &State) -> Option<(Mat<f64>, f64)> {
    let (coefficients, slopes) = (model.coefficients(state)?, model.slopes(state)?);
    let jacobian = upper * slopes;
    let residual = upper * ColRef::from_slice(&coefficients);
    let step =
        Svd::of(jacobian.as_ref(), RANK_TOLERANCE).ok()?.solve(residual.try_as_col_major()?.as_slice());
    let left = residual - &jacobian * ColRef::from_slice(&step);
    Some((jacobian, left.squared_norm_l2()))
}

/// A factor of UᵀU − C: with U = Q Σ Vᵀ it is (1 − K)^½ Σ Vᵀ, K = Σ⁻¹ Vᵀ C V Σ⁻¹. Where C is small K is, and
/// no digits are lost, as they would be in the difference itself.
fn without(upper: &Mat<f64>, added: Mat<f64>) -> Mat<f64> {
    let count = upper.nrows();
    let Ok(svd) = upper.svd() else { return upper.clone() };
    let (sigma, v) = (svd.S().column_vector(), svd.V());
    let largest = sigma.iter().copied().fold(0.0, f64::max);
    let there: Vec<usize> = (0..count).filter(|k| sigma[*k] > ABSENT * largest).collect();
    let over = Mat::from_fn(count, there.len(), |i, k| v[(i, there[k])] / sigma[there[k]]);
    let share = over.transpose() * added * &over;
    let Ok(own) = share.self_adjoint_eigen(Side::Lower) else { return upper.clone() };
    let times = Mat::from_fn(there.len(), count, |k, j| sigma[there[k]] * v[(j, there[k])]);
    let turned = own.U().transpose() * times;
    let left = |k: usize| (1.0 - own.S()[k].min(NOISE_ALONE)).sqrt();
    Mat::from_fn(count, count, |k, j| if k < there.len() { left(k) * turned[(k, j)] } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::mat;

    #[test]
    fn what_noise_adds_is_taken_off_a_factor() {
        let upper = Mat::from_fn(3, 3, |i, j| if i <= j { 1.0 + (2 * i + j) as f64 } else { 0.0 });
        let added = mat![[0.1, 0.02, 0.0], [0.02, 0.3, 0.01], [0.0, 0.01, 0.2]];
        let found = without(&upper, added.clone());
        let expected = upper.transpose() * &upper - added;
        assert!((found.transpose() * &found - expected).norm_max() < 1e-12);
    }
}
