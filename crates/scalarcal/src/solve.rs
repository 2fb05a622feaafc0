//! From the recordings to the calibration.

use common::number::counted;
use common::{Axis, Document, Noise};
use nalgebra::Matrix3;
use physics::{Basic, EffectInstance, Unit};

use crate::design::{Rows, Scales};
use crate::effects::{Following, asked, following, taken_off};
use crate::fit::{Found, Known, Sums, fit};
use crate::kalman::{Form, WHITE};
use crate::known::{Beforehand, beforehand};
use crate::model::{Model, Parameter, State};
use crate::read::{Series, Source, read};
use crate::weakest::{UNDETERMINED, frame};
use crate::{Error, Options, checks, noise, robust, start, weakest};

/// Rounds in which what effects follow, and what those of the model add, settle with the sensors.
const ROUNDS: usize = 3;
/// Relative standard uncertainty with which a scale that nothing shows is held.
const HELD: f64 = 1e-9;
/// A parameter is not determined that is so many times as uncertain as the mean residual: what is small and not in the model decides it then.
const MOST_WEAK: f64 = 1000.0;
/// Standard uncertainties with which parameters are held where they begin, when a fit finds no minimum without.
const LOOSELY: [f64; 3] = [0.3, 0.1, 0.03];

/// A calibration with all that stands behind it.
pub struct Solved {
    /// Unit of the readings.
    pub unit: Unit,
    /// The units of the parameters.
    pub scales: Scales,
    /// The parameters.
    pub model: Model,
    /// What one unit of the state is in the unit of an effect's parameter.
    pub units: Vec<f64>,
    /// The effects that were fitted.
    pub effects: Vec<EffectInstance>,
    /// The fit.
    pub found: Found,
    /// What was known beforehand.
    pub beforehand: Beforehand,
    /// Rows of the fit for what no reading shows and is held.
    pub held: Known,
    /// Those, and the rows for what is known beforehand and used.
    pub known: Known,
    /// μ.
    pub mu: Matrix3<f64>,
    /// Noise of a residual (white) and of the sensors (with memory).
    pub noise: Noise,
    /// Its form.
    pub form: Form,
    /// Names of the recordings.
    pub recordings: Vec<String>,
    /// Where their magnitude comes from.
    pub sources: Vec<Source>,
    /// Rows used.
    pub rows: u64,
    /// Rows that lack a reading.
    pub missing: u64,
    /// Rows left out, by the reason.
    pub left_out: Vec<(String, u64)>,
    /// What was done or assumed, in words.
    pub told: Vec<String>,
}

/// The rows of a calibration, where they are at hand.
pub struct Detail {
    /// The rows that were used, without what the effects of the model add.
    pub series: Vec<Series>,
    /// |B| − F in each row, nT.
    pub residuals: Vec<Vec<f64>>,
    /// The columns that effects follow.
    pub follows: Vec<Vec<Vec<f64>>>,
}

impl Detail {
    /// The rows in the units of the parameters.
    pub fn rows(&self, scales: Scales) -> Rows<'_> {
        Rows { series: &self.series, scales, follows: self.follows.clone(), weights: None }
    }
}

/// Finds the calibration.
///
/// # Errors
///
/// As [`read`] and [`fit`]; rotations that do not determine the calibration.
pub fn solve(document: &Document, options: &Options) -> Result<(Solved, Detail), Error> {
    let (unit, mut series) = read(document, options)?;
    let mut told = Vec::new();
    let mut left_out: Vec<(String, u64)> = checks::without_saturated(&mut series)
        .into_iter()
        .map(|(axis, count)| (format!("sensor {axis} at the end of its range"), count as u64))
        .collect();
    unlike(&mut series, &mut told);
    series.retain(|one| one.len() > 0);
    let scales = start::scales(document, unit, &series);
    let constant = series.iter().all(|one| one.source == Source::Constant);
    if constant {
        series.iter_mut().for_each(|one| one.magnitude_nt.fill(scales.magnitude_nt));
    }
    let effects = asked(document, options)?;
    let adopted =
        physics::adopt(document).map_err(|source| Error::Physics { path: "model".into(), source })?;
    let stated = stated_magnitude(document, &series);
    let reference = reference_variance(document, &series, &scales);
    let sensor = sensor_variance(document, &scales);
    let like = Basic::found(document, unit).mu;

    let more = |following: &Following| {
        let mut more = following.parameters.clone();
        if options.reference_offset && !constant {
            more.push(Parameter::ReferenceOffset);
        }
        if constant || stated.is_some() {
            more.push(Parameter::Magnitude);
        }
        more
    };
    let raw = series;
    let none = Following { parameters: Vec::new(), units: Vec::new(), columns: vec![Vec::new(); raw.len()] };
    let mut current = raw.clone();
    let mut follow = none;
    let mut state: Option<(Model, State)> = None;
    let rounds = if effects.is_empty() && adopted.is_empty() { 1 } else { ROUNDS };
    for _ in 0..rounds {
        if let Some((_, state)) = &state {
            let basic = basic(state, &scales, &like);
            current = taken_off(document, &raw, &basic, &adopted)?;
            follow = following(document, &current, &scales, &basic, &effects)?;
        }
        let columns = follow.columns[0].len();
        let model = Model::new(crate::terms::ONE + 1 + columns, more(&follow));
        let rows = Rows { series: &current, scales, follows: follow.columns.clone(), weights: None };
        let plain = rows.factor(&model.terms);
        let beforehand = beforehand(document, unit, &scales, &model)?;
        let held = held(&model, &beforehand, options, (constant, stated));
        let known = used(&beforehand, options);
        let starts = match &state {
            Some((_, before)) => {
                let mut neutral = model.nominal();
                neutral[..9].copy_from_slice(&before[..9]);
                vec![neutral]
            }
            None => start::starts(document, unit, &scales, &model, &plain)?,
        };
        let sums = Sums { plain: &plain, sensor, reference, held: &held };
        let found = fit(&model, &sums, &known, &starts).map_err(|error| {
            short(&model, &sums, &rows, &starts, &like, options, &beforehand).unwrap_or(error)
        })?;
        state = Some((model, found.state));
    }
    let (model, state) = state.ok_or_else(|| Error::Undetermined("no rows".into()))?;

    let before = beforehand(document, unit, &scales, &model)?;
    let held = held(&model, &before, options, (constant, stated));
    let known = used(&before, options);
    let mut rows = Rows { series: &current, scales, follows: follow.columns.clone(), weights: None };
    let mut found = if options.robust {
        robust::fit_robust(&model, &mut rows, (sensor, reference), (&held, &known), &state)?
    } else {
        let plain = rows.factor(&model.terms);
        fit(&model, &Sums { plain: &plain, sensor, reference, held: &held }, &known, &[state])?
    };
    // What is weighed down most is left out from here on: a spectrum needs rows that are whole.
    let weights = rows.weights.take();
    let mut kept = current;
    let mut follows = follow.columns;
    if let Some(weights) = &weights {
        let mut count = 0;
        for ((one, columns), weights) in kept.iter_mut().zip(&mut follows).zip(weights) {
            let keep: Vec<bool> = weights.iter().map(|weight| *weight > 0.0).collect();
            count += keep.iter().filter(|keep| !**keep).count() as u64;
            checks::retain(one, &keep);
            for column in columns.iter_mut() {
                let mut flags = keep.iter();
                column.retain(|_| *flags.next().unwrap_or(&true));
            }
        }
        left_out.push(("weight zero (--robust)".into(), count));
    }
    let rows = Rows { series: &kept, scales, follows: follows.clone(), weights: None };
    let white = Noise { white_rms_nt: Some(found.variance.sqrt() * scales.magnitude_nt), ..Noise::default() };
    let declared = declared_form(document, sensor.map(|sensor| sensor + reference), &scales);
    let groups = noise::Groups::of(&rows, &model, &found, true);
    let averaged = groups
        .map(|groups| groups.average(&mut found, (&held, &known), (declared, scales.magnitude_nt)))
        .transpose()?
        .flatten();
    let (form, noise) = averaged.unwrap_or((WHITE, white));
    let residuals = rows.residuals(&model, &found.state);
    let mu = frame(&found.state, &like);
    let mut sources: Vec<Source> = kept.iter().map(|one| one.source).collect();
    sources.sort_unstable();
    sources.dedup();
    let solved = Solved {
        unit,
        scales,
        units: follow.units,
        effects,
        noise,
        form,
        beforehand: before,
        known: held.iter().chain(&known).cloned().collect(),
        held,
        mu,
        recordings: kept.iter().map(|one| one.id.clone()).collect(),
        sources,
        rows: kept.iter().map(|one| one.len() as u64).sum(),
        missing: kept.iter().map(|one| one.missing as u64).sum(),
        left_out,
        told,
        model,
        found,
    };
    let detail = Detail { series: kept, residuals, follows };
    determined(&solved, &detail, options)?;
    Ok((solved, detail))
}

/// The chain that a state means; its coils are none.
pub fn basic(state: &State, scales: &Scales, like: &Matrix3<f64>) -> Basic {
    let mut basic = Basic::of(&Document::default(), Unit::Nanotesla);
    basic.mu = frame(state, like);
    for axis in 0..3 {
        basic.sensors[axis].sensitivity = state[axis] * scales.sensitivity[axis];
        basic.sensors[axis].offset_nt = state[3 + axis] * scales.magnitude_nt;
    }
    basic
}

/// Recordings of a magnitude that is not known are of no use beside ones where it is.
fn unlike(series: &mut Vec<Series>, told: &mut Vec<String>) {
    let known = series.iter().any(|one| one.source != Source::Constant);
    let before = series.len();
    series.retain(|one| !known || one.source != Source::Constant);
    if series.len() < before {
        let left = counted(before - series.len(), "recording");
        told.push(format!("{left} without a known magnitude left out: others have one"));
    }
}

/// Relative standard uncertainty of a magnitude that is stated in all recordings.
fn stated_magnitude(document: &Document, series: &[Series]) -> Option<f64> {
    if !series.iter().all(|one| one.source == Source::Stated) {
        return None;
    }
    let of = |one: &Series| {
        let stated = document.recordings[one.index].conditions.extra.get(crate::read::MAGNITUDE)?;
        serde_json::from_value::<common::Quantity>(stated.clone()).ok()?.relative_std()
    };
    series.iter().filter_map(of).reduce(f64::max)
}

/// Variance of the reference over the square of the magnitude.
fn reference_variance(document: &Document, series: &[Series], scales: &Scales) -> f64 {
    let read = series.iter().any(|one| matches!(one.source, Source::Scalar | Source::Ambient));
    let std = document.facility.as_ref().and_then(|facility| facility.reference_std_nt).filter(|_| read);
    (std.unwrap_or(0.0) / scales.magnitude_nt).powi(2)
}

/// Variance of the declared noise along a sensor over the square of the magnitude, in the mean of the sensors.
fn sensor_variance(document: &Document, scales: &Scales) -> Option<f64> {
    let instrument = document.instrument.as_ref()?;
    let of = |axis: Axis| instrument.noise_of(axis)?.white_rms_nt.filter(|rms| *rms > 0.0);
    let all: Vec<f64> = Axis::ALL.into_iter().filter_map(of).collect();
    let code = scales.sensitivity.map(|k| instrument.quantisation_v.map_or(0.0, |width| k * width));
    let rounding = code.iter().map(|width| width * width / 12.0).sum::<f64>() / 3.0;
    let mean = all.iter().map(|rms| rms * rms).sum::<f64>() / 3.0;
    (all.len() == 3).then(|| (mean + rounding) / scales.magnitude_nt.powi(2))
}

/// The rows for scales that nothing shows.
fn held(
    model: &Model,
    beforehand: &Beforehand,
    options: &Options,
    (constant, stated): (bool, Option<f64>),
) -> Known {
    let mut rows = Known::new();
    if let Some(place) = model.place(&Parameter::Magnitude) {
        let mut weights = vec![0.0; model.parameters.len()];
        match stated {
            Some(std) => {
                weights[place] = 1.0 / std;
                rows.push((weights, 1.0 / std));
            }
            // Only the ratio of magnitude and sensitivities is seen: the mean sensitivity is held at what is known of it.
            None if constant && !options.known => {
                let mean = beforehand.nine[..3].iter().sum::<f64>() / HELD;
                weights[..3].fill(1.0 / HELD);
                rows.push((weights, mean));
            }
            None => {}
        }
    }
    rows
}

/// That the fit determines every parameter.
fn determined(solved: &Solved, detail: &Detail, options: &Options) -> Result<(), Error> {
    let covariance = &solved.found.covariance;
    let worst = (0..9).map(|k| covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    // A mean of all rows has the uncertainty s/√n.
    let most = MOST_WEAK * (solved.found.variance / solved.rows as f64).sqrt();
    let full = solved.found.seen.rank() >= solved.model.parameters.len() || options.known;
    let magnitude = solved.model.place(&Parameter::Magnitude).is_some();
    if worst.is_finite() && worst <= UNDETERMINED.min(most) && (full || magnitude) {
        return Ok(());
    }
    let rows = detail.rows(solved.scales);
    let state = &solved.found.state;
    Err(message(&solved.model, &solved.found.jacobian, &rows, state, &solved.mu, &solved.beforehand, options))
}

/// The same for a fit that found no minimum: with the parameters held loosely where they begin there is one, and it says what the
/// readings do not.
fn short(
    model: &Model,
    sums: &Sums<'_>,
    rows: &Rows<'_>,
    starts: &[State],
    like: &Matrix3<f64>,
    options: &Options,
    beforehand: &Beforehand,
) -> Option<Error> {
    let loosely = |place: usize, std: f64| {
        let mut weights = vec![0.0; model.parameters.len()];
        weights[place] = 1.0 / std;
        (weights, starts[0][place] / std)
    };
    let held =
        |std: &f64| -> Known { (0..model.parameters.len()).map(|place| loosely(place, *std)).collect() };
    let found = LOOSELY.iter().find_map(|std| fit(model, sums, &held(std), starts).ok())?;
    let information = found.jacobian.transpose() * &found.jacobian;
    let (least, _) = weakest::least(&information)?;
    let mu = frame(&found.state, like);
    (least < UNDETERMINED.powi(-2))
        .then(|| message(model, &found.jacobian, rows, &found.state, &mu, beforehand, options))
}

/// The form of the declared noise, where all three sensors have one; white where it has no memory.
fn declared_form(document: &Document, variance: Option<f64>, scales: &Scales) -> Option<Form> {
    let instrument = document.instrument.as_ref()?;
    let all: Vec<&Noise> = Axis::ALL.into_iter().filter_map(|axis| instrument.noise_of(axis)).collect();
    let white = variance? * scales.magnitude_nt.powi(2);
    let flicker = all.iter().filter_map(|noise| noise.flicker_nt2_per_hz_at_1hz).sum::<f64>() / 3.0;
    let exponent = all[0].flicker_exponent.unwrap_or(1.0);
    Some(if flicker > 0.0 { Form { ratio: flicker / white, exponent } } else { WHITE })
}

/// What is known beforehand, where it is to be used.
fn used(beforehand: &Beforehand, options: &Options) -> Known {
    if options.known { beforehand.rows.clone() } else { Known::new() }
}

fn message(
    model: &Model,
    jacobian: &faer::Mat<f64>,
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
                "turn the block about all three axes".to_string(),
            )
        },
        |weakest| (weakest.words, weakest.remedy.split(": the combination").next().unwrap_or("").to_string()),
    );
    let known = if options.known || beforehand.rows.is_empty() {
        "; or state what is known of the sensors beforehand under `calibration`, with its uncertainty, and give --known".into()
    } else {
        "; or give --known, which holds what the document states of the sensors within its uncertainty"
            .to_string()
    };
    Error::Undetermined(format!(
        "the rotations do not determine the calibration: {words}. {}{known}",
        capital(&remedy)
    ))
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
