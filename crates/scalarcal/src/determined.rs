//! Whether the rotations determine the calibration, and what to do where they do not.

use common::WeakestDirection;
use common::number::significant;
use faer::Mat;

use crate::declared::Given;
use crate::design::Rows;
use crate::directions::frame;
use crate::fit::{FittedState, Sums, explained, fit};
use crate::kalman::Memory;
use crate::linear::{Linear, RANK_TOLERANCE, stacked};
use crate::model::{Model, NINE, Parameter, State};
use crate::solved::{Detail, Solved};
use crate::weakest::UNDETERMINED;
use crate::{Error, weakest};

/// A parameter more than this many times as uncertain as the mean residual counts as undetermined: small
/// unmodelled effects would decide it.
const MOST_WEAK: f64 = 1000.0;
/// Standard uncertainties with which parameters are held where they begin, when a fit finds no minimum
/// without.
const LOOSELY: [f64; 3] = [0.3, 0.1, 0.03];

/// The largest standard uncertainty of a parameter that is determined, by the variance of a residual.
fn most(variance: f64, rows: u64) -> f64 {
    // A mean of all rows has the uncertainty s/√n.
    UNDETERMINED.min(MOST_WEAK * (variance / rows as f64).sqrt())
}

/// That the rotations determine every parameter, by what is left as if it were white: of an offset that
/// wanders they say no more, but that is no fault of theirs.
pub fn determined(
    given: &Given<'_>,
    solved: &Solved,
    by_rotations: &FittedState,
    detail: &Detail,
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
    let all = stacked(&found.jacobian, &solved.known.jacobian);
    let full = estimate::Svd::of(all.as_ref(), RANK_TOLERANCE)?.rank() == model.parameters.len();
    // Where the scale is that of something known, it is no better than that.
    let scaled = given.options.known || model.place(&Parameter::Magnitude).is_some();
    let most = if scaled { UNDETERMINED } else { most(found.variance, solved.scalar.rows) };
    if full && worst <= most {
        return Ok(());
    }
    let rows = detail.rows(solved.scales);
    Err(message(given, model, &all, &rows, &solved.found.state, solved.beforehand.rows.is_empty()))
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
    given: &Given<'_>,
    model: &Model,
    sums: &Sums<'_>,
    rows: &Rows<'_>,
    starts: &[State],
    nothing_known: bool,
) -> Option<Error> {
    let (count, number) = (model.parameters.len(), sums.plain.rows);
    if number <= count as u64 {
        return None;
    }
    let loosely = |std: &f64| {
        let jacobian = Mat::from_fn(count, count, |i, j| if i == j { 1.0 / std } else { 0.0 });
        Linear { jacobian, right: starts[0].iter().map(|value| value / std).collect() }
    };
    let found = LOOSELY.iter().find_map(|std| fit(model, sums, &loosely(std), starts).ok());
    let (state, jacobian, variance) = match found {
        Some(found) => (found.state, found.jacobian, found.variance),
        // Not even those are found: the derivatives where they begin, and what is left when they are
        // followed.
        None => {
            let (jacobian, squares) = explained(model, &sums.plain.upper(), &starts[0])?;
            let variance = (squares / number as f64).max(f64::MIN_POSITIVE);
            (starts[0].clone(), jacobian * faer::Scale(1.0 / variance.sqrt()), variance)
        }
    };
    let (least, _) = weakest::least(&(jacobian.transpose() * &jacobian))?;
    let undetermined = least < most(variance, number).powi(-2);
    undetermined.then(|| message(given, model, &jacobian, rows, &state, nothing_known))
}

fn message(
    given: &Given<'_>,
    model: &Model,
    jacobian: &Mat<f64>,
    rows: &Rows<'_>,
    state: &State,
    nothing_known: bool,
) -> Error {
    let mu = frame(state, &given.mu);
    let directions: Vec<_> =
        weakest::directions(rows, model, state, &mu).into_iter().map(|(_, _, field)| field).collect();
    let found = weakest::weakest(model, state, jacobian, (&directions, rows.scales.magnitude_nt), &mu);
    let (words, remedy) = match &found {
        Some(WeakestDirection { words, remedy, .. }) => (words.as_str(), remedy.as_str()),
        None => ("the directions of the field do not differ", "rotate the block about all three axes"),
    };
    let remedy = remedy.split(": this would determine").next().unwrap_or_default();
    let known = match (nothing_known, given.options.known) {
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
        capital(remedy)
    ))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
