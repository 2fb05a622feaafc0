//! A calibration from the factor of the products, of rows at hand and of streams alike, with all that stands
//! behind it; whether the rotations determine it, and what to do where they do not.

use common::number::significant;
use common::{Code, Finding, Noise, ScalarCalibration, WeakestDirection};
use estimate::Svd;
use faer::{Mat, Scale};
use nalgebra::Matrix3;
use physics::EffectInstance;

use crate::design::Rows;
use crate::directions::frame;
use crate::fit::{FittedState, explained, fit};
use crate::given::Given;
use crate::kalman::{Form, Memory, WHITE};
use crate::linear::{Linear, RANK_TOLERANCE, stacked};
use crate::model::{Model, NINE, Parameter, State};
use crate::noise::Groups;
use crate::read::Source;
use crate::terms::Factor;
use crate::weakest::{self, UNDETERMINED};
use crate::{Error, start};

/// A parameter more than this many times as uncertain as the mean residual is undetermined: small effects decide.
const MOST_WEAK: f64 = 1000.0;
/// Standard uncertainties with which parameters are held at the start, when no minimum is found without.
const LOOSELY: [f64; 3] = [0.3, 0.1, 0.03];

pub struct Solved {
    pub given: Given,
    pub model: Model,
    pub effects: Vec<EffectInstance>,
    /// Rows of the fit for what no reading shows and is held.
    pub held: Linear,
    /// Those, and the rows for what is known beforehand and used.
    pub known: Linear,
    pub found: FittedState,
    pub plain: Factor,
    pub mu: Matrix3<f64>,
    pub form: Form,
    /// Whether the noise is declared white: the factor then holds all that the rows say.
    pub white: bool,
    pub sources: Vec<Source>,
    /// |B| − F in each row that is at hand, nT.
    pub residuals: Vec<Vec<f64>>,
    /// What is said of it, as far as it is known.
    pub scalar: ScalarCalibration,
}

impl Solved {
    /// Fits the factor of rows, from the sensors of a fit before or from those that the document states.
    ///
    /// Errors: as [`fit`], in the words of [`determined`] where rotations are missing.
    pub fn fit(
        given: Given,
        model: Model,
        rows: &Rows<'_>,
        before: Option<&Self>,
        plain: Factor,
    ) -> Result<Self, Error> {
        let held = given.held(&model);
        let known =
            if given.known { held.and(&given.prior.padded(model.parameters.len())) } else { held.clone() };
        let starts = match before {
            Some(before) => vec![model.with(&before.found.state)],
            None => start::starts(&given, &model, &plain)?,
        };
        let found = fit(&given, &model, &plain, (&held, &known), &starts)
            .map_err(|error| short(&given, &model, &plain, &held, rows, &starts).unwrap_or(error))?;
        Ok(Self {
            effects: Vec::new(),
            mu: given.mu,
            form: WHITE,
            white: false,
            sources: Vec::new(),
            residuals: Vec::new(),
            scalar: ScalarCalibration { includes_body: true, ..ScalarCalibration::default() },
            given,
            model,
            held,
            known,
            found,
            plain,
        })
    }

    /// Fits again from a state.
    ///
    /// Errors: as [`fit`].
    pub fn again(&self, plain: &Factor, from: &State) -> Result<FittedState, Error> {
        fit(&self.given, &self.model, plain, (&self.held, &self.known), std::slice::from_ref(from))
    }

    /// Averages the fit over the forms of noise of rows about it, where white noise is not declared, and takes
    /// what follows from it. Gives whether noise with memory was looked for.
    ///
    /// Errors: as `average`; rotations that do not determine the calibration.
    pub fn finish(
        &mut self,
        rows: &Rows<'_>,
        groups: impl FnOnce(&Self) -> Option<Groups>,
        average: impl FnOnce(
            &Groups,
            &mut FittedState,
            (&Linear, &Linear),
            (Form, bool, f64),
        ) -> Result<Option<(Form, Noise)>, Error>,
    ) -> Result<bool, Error> {
        determined(self, rows)?;
        let Given { sensor, reference, .. } = self.given;
        let declared = sensor.and_then(|sensor| self.given.form(sensor + reference));
        self.white = declared == Some(WHITE);
        let groups = if self.white { None } else { groups(self) };
        let forms = (declared.unwrap_or(WHITE), declared.is_none(), self.unit_nt());
        let noise = match groups {
            Some(groups) => average(&groups, &mut self.found, (&self.held, &self.known), forms)?,
            None => None,
        };
        let (looked, white_rms_nt) = (noise.is_some(), Some(self.found.variance.sqrt() * self.unit_nt()));
        let (form, noise) = noise.unwrap_or((WHITE, Noise { white_rms_nt, ..Noise::default() }));
        self.form = form;
        self.mu = frame(&self.found.state, &self.given.mu);
        self.sources = rows.series.iter().map(|one| one.source).collect();
        self.sources.sort_unstable();
        self.sources.dedup();
        self.residuals = rows.residuals(&self.model, &self.found.state);
        let scalar = &mut self.scalar;
        scalar.recordings = rows.series.iter().map(|one| one.id.clone()).collect();
        scalar.rows = self.plain.rows;
        scalar.missing = rows.series.iter().map(|one| one.missing as u64).sum();
        scalar.noise = noise;
        Ok(looked)
    }

    pub fn unit_nt(&self) -> f64 {
        self.given.scales.magnitude_nt * self.model.scale(&self.found.state)
    }

    /// Variance of the white noise of a residual over the square of that.
    pub fn white_variance(&self) -> f64 {
        (self.scalar.noise.white_rms_nt.unwrap_or(0.0) / self.unit_nt()).powi(2)
    }

    /// Rows about a fit as they are whitened; `plain` is their factor, where white noise is declared.
    pub fn groups(
        &self,
        rows: &Rows<'_>,
        plain: Option<&Factor>,
        model: &Model,
        found: &FittedState,
    ) -> Option<Groups> {
        match plain.filter(|_| self.white) {
            Some(plain) => Groups::of_factors(&[([0.0; 2], plain)], model, found),
            None => Groups::of(rows, model, found, self.form != WHITE),
        }
    }
}

/// The largest standard uncertainty of a parameter that is determined, by the variance of a residual.
fn most(variance: f64, rows: u64) -> f64 {
    // A mean of all rows has the uncertainty s/√n.
    UNDETERMINED.min(MOST_WEAK * (variance / rows as f64).sqrt())
}

/// That the rotations determine every parameter, by a fit that takes what is left to be white: of an offset
/// that wanders they say no more, but that is no fault of theirs.
fn determined(solved: &Solved, rows: &Rows<'_>) -> Result<(), Error> {
    let Solved { given, model, found, .. } = solved;
    // A scale of sensors and field together is as uncertain as what is known of it: the rest counts.
    let scale = model.scale(&found.state);
    let apart = Mat::from_fn(NINE, model.parameters.len(), |i, j| {
        let own = if i == j { 1.0 } else { 0.0 };
        let scaled = model.place(&Parameter::Magnitude).is_some() && i < 6 && j < 3;
        own - if scaled { found.state[i] / (3.0 * scale) } else { 0.0 }
    });
    let covariance = &apart * &found.covariance * apart.transpose();
    let worst = (0..NINE).map(|k| covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    let all = stacked(&found.jacobian, &solved.known.jacobian);
    let full = Svd::of(all.as_ref(), RANK_TOLERANCE)?.rank() == model.parameters.len();
    // Where the scale is that of something known, it is no better than that.
    let scaled = given.known || model.place(&Parameter::Magnitude).is_some();
    let most = if scaled { UNDETERMINED } else { most(found.variance, solved.plain.rows) };
    if full && worst <= most {
        return Ok(());
    }
    Err(message(given, model, &all, rows, &found.state))
}

/// That offsets are known badly because they wander, in a sentence.
pub fn wandering(solved: &Solved) -> Option<Finding> {
    let offset = (3..6).map(|k| solved.found.covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    let wanders = solved.form.of == Memory::Sensors && solved.form.ratio > 0.0;
    (wanders && offset > UNDETERMINED).then(|| {
        Code::OffsetsWander.said(format!(
            "the residuals change slowly and rotate with the sensors, like drifting offsets: longer recordings of this kind will not reduce their uncertainty of {} nT. Check for iron or currents nearby, a different field where the block was moved to, and an instrument that corrects itself",
            significant(offset * solved.given.scales.magnitude_nt, 2)
        ))
    })
}

/// What [`determined`] says, for a fit that found no minimum: with the parameters held loosely where they
/// begin there is one, and it says what the readings do not.
fn short(
    given: &Given,
    model: &Model,
    plain: &Factor,
    held: &Linear,
    rows: &Rows<'_>,
    starts: &[State],
) -> Option<Error> {
    let (count, number) = (model.parameters.len(), plain.rows);
    if number <= count as u64 {
        return None;
    }
    let loosely = |std: &f64| {
        let jacobian = Mat::from_fn(count, count, |i, j| if i == j { 1.0 / std } else { 0.0 });
        held.and(&Linear { jacobian, right: starts[0].iter().map(|value| value / std).collect() })
    };
    let found = LOOSELY.iter().find_map(|std| fit(given, model, plain, (held, &loosely(std)), starts).ok());
    let (state, jacobian, variance) = match found {
        Some(found) => (found.state, found.jacobian, found.variance),
        // Not even those: the derivatives where they begin, and what is left along them.
        None => {
            let (jacobian, squares) = explained(model, &plain.upper(), &starts[0])?;
            let variance = (squares / number as f64).max(f64::MIN_POSITIVE);
            (starts[0].clone(), jacobian * Scale(1.0 / variance.sqrt()), variance)
        }
    };
    let (least, _) = weakest::least(&(jacobian.transpose() * &jacobian))?;
    let undetermined = least < most(variance, number).powi(-2);
    undetermined.then(|| message(given, model, &jacobian, rows, &state))
}

fn message(given: &Given, model: &Model, jacobian: &Mat<f64>, rows: &Rows<'_>, state: &State) -> Error {
    let mu = frame(state, &given.mu);
    let directions: Vec<_> =
        weakest::directions(rows, model, state, &mu).into_iter().map(|(_, _, field)| field).collect();
    let found = weakest::weakest(model, state, jacobian, (&directions, rows.scales.magnitude_nt), &mu);
    let (words, remedy) = match &found {
        Some(WeakestDirection { words, remedy, .. }) => (words.as_str(), remedy.as_str()),
        None => ("the directions of the field do not differ", "rotate the block about all three axes"),
    };
    let remedy = remedy.split(": this would determine").next().unwrap_or_default();
    let known = match (given.prior.is_empty(), given.known) {
        (true, _) => {
            "state prior values of the sensors with their uncertainty under `calibration`, and give --known; limits of scale factors and angles can be given with --scales-within and --angles-within"
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
