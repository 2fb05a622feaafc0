//! Whether the rotations determine the calibration, and what to do where they do not.

use common::number::significant;
use faer::Mat;
use nalgebra::Matrix3;

use crate::design::Rows;
use crate::factor::Factor;
use crate::fit::{FittedState, PriorRows, Sums, explained, fit};
use crate::kalman::Memory;
use crate::known::Beforehand;
use crate::linear::RANK_TOLERANCE;
use crate::model::{Model, NINE, Parameter, State};
use crate::solved::{Detail, Solved};
use crate::weakest::{UNDETERMINED, frame};
use crate::{Error, Options, weakest};

/// A parameter more than this many times as uncertain as the mean residual counts as undetermined: small
/// unmodelled effects would decide it.
const MOST_WEAK: f64 = 1000.0;
/// Standard uncertainties with which parameters are held where they begin, when a fit finds no minimum
/// without.
const LOOSELY: [f64; 3] = [0.3, 0.1, 0.03];

/// The largest standard uncertainty of a parameter that is determined.
fn most(found: &FittedState, rows: u64) -> f64 {
    // A mean of all rows has the uncertainty s/√n.
    UNDETERMINED.min(MOST_WEAK * (found.variance / rows as f64).sqrt())
}

/// That the rotations determine every parameter, by what is left as if it were white: of an offset that
/// wanders they say no more, but that is no fault of theirs.
pub fn determined(
    solved: &Solved,
    by_rotations: &FittedState,
    detail: &Detail,
    options: &Options,
) -> Result<(), Error> {
    let (model, found) = (&solved.model, by_rotations);
    // A scale of sensors and field together, where that of the field is a parameter, is as uncertain as what
    // is known of it: the rest counts.
    let scale = model.scale(&found.state);
    let apart = Mat::from_fn(NINE, model.parameters.len(), |i, j| {
        let own = if i == j { 1.0 } else { 0.0 };
        let scaled = model.place(&Parameter::Magnitude).is_some() && i < 6 && j < 3;
        own - if scaled { found.state[i] / (3.0 * scale) } else { 0.0 }
    });
    let covariance = &apart * &found.covariance * apart.transpose();
    let worst = (0..NINE).map(|k| covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    let rows = found.jacobian.nrows();
    let all = Mat::from_fn(rows + solved.known.len(), model.parameters.len(), |i, j| {
        if i < rows { found.jacobian[(i, j)] } else { solved.known[i - rows].0[j] }
    });
    let full = estimate::Svd::of(all.as_ref(), RANK_TOLERANCE)?.rank() == model.parameters.len();
    // Where the scale is that of something known, it is no better than that.
    let scaled = options.known || model.place(&Parameter::Magnitude).is_some();
    let most = if scaled { UNDETERMINED } else { most(found, solved.rows) };
    if full && worst <= most {
        return Ok(());
    }
    let rows = detail.rows(solved.scales);
    let state = &solved.found.state;
    Err(message(&solved.model, &all, &rows, state, &solved.mu, &solved.beforehand, options))
}

/// That offsets are known badly because they wander, in a sentence.
pub fn wandering(solved: &Solved) -> Option<String> {
    let offset = (3..6).map(|k| solved.found.covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    let wanders = solved.form.of == Memory::Sensors && solved.form.ratio > 0.0;
    (wanders && offset > UNDETERMINED).then(|| {
        format!(
            "the residuals change slowly and rotate with the sensors, like drifting offsets: longer recordings of this kind will not reduce their uncertainty of {} nT. Check for iron or currents nearby, a different field where the block was moved to, and an instrument that corrects itself",
            significant(offset * solved.scales.magnitude_nt, 2)
        )
    })
}

/// What [`determined`] says, for a fit that found no minimum: with the parameters held loosely where they
/// begin there is one, and it says what the readings do not.
pub fn short(
    model: &Model,
    sums: &Sums<'_>,
    rows: &Rows<'_>,
    starts: &[State],
    like: &Matrix3<f64>,
    options: &Options,
    beforehand: &Beforehand,
) -> Option<Error> {
    if sums.plain.rows() <= model.parameters.len() as u64 {
        return None;
    }
    let loosely = |place: usize, std: f64| {
        let mut weights = vec![0.0; model.parameters.len()];
        weights[place] = 1.0 / std;
        (weights, starts[0][place] / std)
    };
    let held =
        |std: &f64| -> PriorRows { (0..model.parameters.len()).map(|place| loosely(place, *std)).collect() };
    let found = LOOSELY.iter().find_map(|std| fit(model, sums, &held(std), starts).ok());
    let (state, jacobian, most) = match found {
        Some(found) => (found.state.clone(), found.jacobian.clone(), most(&found, sums.plain.rows())),
        // Not even those are found: the derivatives where they begin, and what is left when they are
        // followed.
        None => linear(model, sums.plain, &starts[0])?,
    };
    let (least, _) = weakest::least(&(jacobian.transpose() * &jacobian))?;
    let mu = frame(&state, like);
    (least < most.powi(-2)).then(|| message(model, &jacobian, rows, &state, &mu, beforehand, options))
}

/// Linear least squares at a state: the state, its derivatives over the standard deviation of what they
/// leave, and the largest standard uncertainty of a parameter that is determined.
fn linear(model: &Model, plain: &Factor, state: &State) -> Option<(State, Mat<f64>, f64)> {
    let (jacobian, squares) = explained(model, &plain.upper(), state)?;
    let rows = plain.rows() as f64;
    let variance = (squares / rows).max(f64::MIN_POSITIVE);
    let most = UNDETERMINED.min(MOST_WEAK * (variance / rows).sqrt());
    Some((state.clone(), jacobian * faer::Scale(1.0 / variance.sqrt()), most))
}

fn message(
    model: &Model,
    jacobian: &Mat<f64>,
    rows: &Rows<'_>,
    state: &State,
    mu: &Matrix3<f64>,
    beforehand: &Beforehand,
    options: &Options,
) -> Error {
    let directions: Vec<_> =
        weakest::directions(rows, model, state, mu).into_iter().map(|(_, _, field)| field).collect();
    let found = weakest::weakest(model, state, jacobian, (&directions, rows.scales.magnitude_nt), mu);
    let (words, remedy) = found.map_or_else(
        || {
            (
                "the directions of the field do not differ".into(),
                "rotate the block about all three axes".to_string(),
            )
        },
        |weakest| {
            (weakest.words, weakest.remedy.split(": this would determine").next().unwrap_or("").to_string())
        },
    );
    let known = match (beforehand.rows.is_empty(), options.known) {
        (true, _) => {
            "state prior values of the sensors with their uncertainty under `calibration`, and give --known"
        }
        (false, false) => "give --known, which uses the stated calibration of the sensors as a prior",
        (false, true) => {
            "state more prior values of the sensors under `calibration`, or smaller uncertainties"
        }
    };
    Error::Unanswerable(format!(
        "the rotations do not determine the calibration: {words}. {}; or {known}",
        capital(&remedy)
    ))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
