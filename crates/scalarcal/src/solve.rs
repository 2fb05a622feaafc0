//! From the recordings to the calibration.

use common::number::counted;
use common::{Code, Document, Finding, Findings};
use estimate::robust::{bisquare, scale_of};
use nalgebra::Matrix3;
use physics::{Basic, Unit};

use crate::design::{Rows, Scales};
use crate::directions::frame;
use crate::effects::{asked, following, taken_off};
use crate::given::Given;
use crate::model::{Model, Parameter, State};
use crate::noise::Groups;
use crate::read::{Series, Source, is_stated, read};
use crate::solved::{Solved, wandering};
use crate::terms::ONE;
use crate::{Error, Options, checks, start};

/// Rounds in which what effects follow, and what those of the model add, settle with the sensors.
const ROUNDS: usize = 3;
const REWEIGHTINGS: usize = 30;
/// Weights that change by less are settled.
const SETTLED: f64 = 1e-6;

/// Finds the calibration, with the rows that were used, without what the effects of the model add.
///
/// Errors: as [`read`] and [`crate::fit::fit`]; rotations that do not determine the calibration.
pub fn solve(document: &Document, options: &Options) -> Result<(Solved, Vec<Series>), Error> {
    let (unit, mut series) = read(document, options)?;
    let mut left_out = checks::saturated(checks::without_saturated(&mut series));
    let repeated = checks::without_repeated(&mut series);
    if repeated > 0 {
        left_out.push(("repeated readings".into(), repeated));
    }
    let mut told = Findings::default();
    told.extend(unlike(&mut series));
    series.retain(|one| one.len() > 0);
    let constant = series.iter().all(|one| one.source == Source::Constant);
    if constant && !is_stated(document, unit) {
        let expected = "`instrument.nominal_sensitivity_nt_per_v` or `conditions.magnitude_nt`, to set the scale of the field";
        let found = "neither a sensitivity nor a magnitude, with --constant-magnitude";
        return Err(Error::document("instrument", found, expected));
    }
    if constant && series.len() > 1 {
        let words = format!("one magnitude is assumed for all {}", counted(series.len(), "recording"));
        told.push(Code::MagnitudeAssumed.said(words));
    }
    let scales = start::scales(document, unit, &series);
    if constant {
        series.iter_mut().for_each(|one| one.magnitude_nt.fill(scales.magnitude_nt));
    }
    let effects = asked(document, options)?;
    let mut adopted = physics::adopt(document).map_err(|error| error.at("model"))?;
    // What is fitted anew is not taken off.
    adopted.retain(|one| !effects.iter().any(|other| other.is_same(one) && other.within == one.within));
    let stated = stated_magnitude(document, &series)?;
    let mut given = Given::of(document, &options.fit, unit, scales)?;
    (given.constant, given.stated) = (constant, stated);
    if !series.iter().any(|one| matches!(one.source, Source::Scalar | Source::Ambient)) {
        given.reference = 0.0;
    }

    let fit = |current: &[Series], effects: Vec<Parameter>, before: Option<&Solved>| {
        let mut more = effects;
        if options.fit.reference_offset && !constant {
            more.push(Parameter::ReferenceOffset);
        }
        if constant || stated.is_some() {
            more.push(Parameter::Magnitude);
        }
        let model = Model::new(ONE + 1 + current[0].follows.len(), more);
        let rows = Rows::new(current, scales);
        let plain = rows.factor(&model.terms);
        Solved::fit(given.clone(), model, &rows, before, plain)
    };
    let mut solved = fit(&series, Vec::new(), None)?;
    let mut current = series.clone();
    let rounds = if effects.is_empty() && adopted.is_empty() { 1 } else { ROUNDS };
    for _ in 1..rounds {
        let basic = basic(&solved.found.state, &scales, &given.mu);
        current = taken_off(document, &series, &basic, &adopted)?;
        let parameters = following(document, &mut current, &scales, &basic, &effects)?;
        solved = fit(&current, parameters, Some(&solved))?;
    }
    solved.effects = effects;
    if options.robust {
        let keep = kept(&solved, &mut Rows::new(&current, scales))?;
        let count = keep.iter().flatten().filter(|keep| !**keep).count();
        left_out.push(("outliers (--robust)".into(), count as u64));
        current.iter_mut().zip(&keep).for_each(|(one, keep)| checks::retain(one, keep));
        solved.plain = Rows::new(&current, scales).factor(&solved.model.terms);
        solved.found = solved.again(&solved.plain, &solved.found.state)?;
    }
    let rows = Rows::new(&current, scales);
    let groups = |solved: &Solved| Groups::of(&rows, &solved.model, &solved.found, true);
    solved.finish(&rows, groups, Groups::average)?;
    told.extend(wandering(&solved));
    solved.scalar.findings = told;
    solved.scalar.left_out.extend(left_out);
    Ok((solved, current))
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

/// Leaves out recordings of a magnitude that is not known beside ones where it is; says so in a sentence.
fn unlike(series: &mut Vec<Series>) -> Option<Finding> {
    let known = series.iter().any(|one| one.source != Source::Constant);
    let before = series.len();
    series.retain(|one| !known || one.source != Source::Constant);
    let left = before - series.len();
    (left > 0).then(|| {
        let recordings = counted(left, "recording");
        let words = format!("{recordings} without a known magnitude left out: others have one");
        Code::MagnitudeUnknownInSome.said(words)
    })
}

/// Share by which the relative uncertainties of a model's magnitudes at one place differ at most.
const ALIKE: f64 = 0.05;

/// Relative standard uncertainty of a stated magnitude.
///
/// Errors: uncertain magnitudes beside another reference, or several: each would need a scale of its own.
fn stated_magnitude(document: &Document, series: &[Series]) -> Result<Option<f64>, Error> {
    let of = |one: &Series| {
        let conditions = &document.recordings[one.index].conditions;
        let stated =
            conditions.quantity(crate::read::MAGNITUDE, "").ok()?.filter(|_| one.source == Source::Stated)?;
        Some((stated.value(), stated.relative_std()?, conditions.extra.contains_key("field_model")))
    };
    let stated: Vec<Option<(f64, f64, bool)>> = series.iter().map(of).collect();
    let Some(first) = stated.iter().flatten().next().copied() else { return Ok(None) };
    // What a model lacks is common to all days of a place: the same share of magnitudes that hardly differ.
    let common = |(value, share, modelled): (f64, f64, bool)| {
        (value, share) == (first.0, first.1) || (modelled && first.2 && (share / first.1 - 1.0).abs() < ALIKE)
    };
    if let Some(other) = stated.iter().position(|one| !one.is_some_and(common)) {
        let path = format!("{}.conditions.{}", series[other].path(), crate::read::MAGNITUDE);
        let found = "a magnitude stated with an uncertainty, and recordings with a different magnitude";
        let expected = "one magnitude for all recordings, or none with an uncertainty; otherwise calibrate them one by one";
        return Err(Error::document(path, found, expected));
    }
    Ok(Some(first.1))
}

/// Which rows of each recording were not disturbed: those to which Tukey's bisquare gives a weight, after
/// fits with weights until these settle. Of normal errors one in 350 000 is left out, so that the fit of the
/// others is that of least squares.
///
/// Errors: [`Error::Unanswerable`] where more than half of the residuals are zero.
fn kept(solved: &Solved, rows: &mut Rows<'_>) -> Result<Vec<Vec<bool>>, Error> {
    let mut state = solved.found.state.clone();
    for _ in 0..REWEIGHTINGS {
        let residuals = rows.residuals(&solved.model, &state);
        let mut sizes: Vec<f64> = residuals.iter().flatten().map(|value| value.abs()).collect();
        let scale = scale_of(&mut sizes);
        if scale <= 0.0 || scale.is_nan() {
            break;
        }
        let weigh = |values: &Vec<f64>| values.iter().map(|value| bisquare(value / scale)).collect();
        let weights: Vec<Vec<f64>> = residuals.iter().map(weigh).collect();
        let change = rows.weights.as_ref().map_or(f64::INFINITY, |before| {
            let pairs = before.iter().flatten().zip(weights.iter().flatten());
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        });
        rows.weights = Some(weights);
        if change < SETTLED {
            break;
        }
        state = solved.again(&rows.factor(&solved.model.terms), &state)?.state;
    }
    let no_scale = "more than half of the residuals are zero; --robust cannot estimate a scale";
    let weights = rows.weights.take().ok_or_else(|| Error::Unanswerable(no_scale.into()))?;
    Ok(weights.iter().map(|weights| weights.iter().map(|weight| *weight > 0.0).collect()).collect())
}
