//! From the recordings to the calibration.

use common::number::counted;
use common::{Document, Noise};
use nalgebra::Matrix3;
use physics::{Basic, EffectInstance, Unit};

use crate::declared::{declared_form, reference_variance, sensor_variance};
use crate::design::{Rows, Scales};
use crate::determined::{determined, short, wandering};
use crate::effects::{Following, asked, following, taken_off};
use crate::factor::Factor;
use crate::fit::{FittedState, PriorRows, Sums, fit};
use crate::kalman::WHITE;
use crate::known::{Beforehand, beforehand};
use crate::model::{Model, NINE, Parameter, State};
use crate::noise::Groups;
use crate::read::{Series, Source, is_stated, read};
use crate::solved::{Detail, Solved};
use crate::weakest::frame;
use crate::{Error, Options, checks, robust, start};

/// Rounds in which what effects follow, and what those of the model add, settle with the sensors.
const ROUNDS: usize = 3;
/// Relative standard uncertainty with which a scale that nothing shows is held.
const HELD: f64 = 1e-9;

/// Finds the calibration.
///
/// # Errors
///
/// As [`read`] and [`fit`]; rotations that do not determine the calibration.
pub fn solve(document: &Document, options: &Options) -> Result<(Solved, Detail), Error> {
    let (unit, mut series) = read(document, options)?;
    let mut told = Vec::new();
    let mut left_out = checks::saturated(checks::without_saturated(&mut series));
    let repeated = checks::without_repeated(&mut series);
    if repeated > 0 {
        left_out.push(("repeated readings".into(), repeated as u64));
    }
    unlike(&mut series, &mut told);
    series.retain(|one| one.len() > 0);
    let constant = series.iter().all(|one| one.source == Source::Constant);
    if constant && !is_stated(document, unit) {
        let expected = "`instrument.nominal_sensitivity_nt_per_v` or `conditions.magnitude_nt`, to set the scale of the field";
        let found = "neither a sensitivity nor a magnitude, with --constant-magnitude";
        return Err(Error::document("instrument", found, expected));
    }
    if constant && series.len() > 1 {
        told.push(format!("one magnitude is assumed for all {}", counted(series.len(), "recording")));
    }
    let scales = start::scales(document, unit, &series);
    if constant {
        series.iter_mut().for_each(|one| one.magnitude_nt.fill(scales.magnitude_nt));
    }
    let effects = asked(document, options)?;
    let mut adopted = physics::adopt(document).map_err(|error| error.at("model"))?;
    // What is fitted anew is not taken off.
    adopted.retain(|one| !effects.iter().any(|other| replaces(other, one)));
    let stated = stated_magnitude(document, &series)?;
    let read = series.iter().any(|one| matches!(one.source, Source::Scalar | Source::Ambient));
    let reference = reference_variance(document, read, &scales);
    let sensor = sensor_variance(document, unit, &scales);
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
    let mut last: Option<(Model, Beforehand, FittedState, Factor)> = None;
    let rounds = if effects.is_empty() && adopted.is_empty() { 1 } else { ROUNDS };
    for _ in 0..rounds {
        if let Some((_, _, found, _)) = &last {
            let basic = basic(&found.state, &scales, &like);
            current = taken_off(document, &raw, &basic, &adopted)?;
            follow = following(document, &current, &scales, &basic, &effects)?;
        }
        let columns = follow.columns[0].len();
        let model = Model::new(crate::terms::ONE + 1 + columns, more(&follow));
        let rows = Rows { series: &current, scales, follows: follow.columns.clone(), weights: None };
        let plain = rows.factor(&model.terms);
        let beforehand = beforehand(document, unit, &scales, &model)?;
        let held = held(&model, &beforehand, options, (constant, stated));
        let starts = match &last {
            Some((_, _, before, _)) => {
                let mut neutral = model.nominal();
                neutral[..NINE].copy_from_slice(&before.state[..NINE]);
                vec![neutral]
            }
            None => start::starts(document, unit, &scales, &model, &plain)?,
        };
        let sums = Sums { plain: &plain, sensor, reference, held: &held };
        let found = fit(&model, &sums, &used(&beforehand, options), &starts).map_err(|error| {
            short(&model, &sums, &rows, &starts, &like, options, &beforehand).unwrap_or(error)
        })?;
        last = Some((model, beforehand, found, plain));
    }
    let (model, beforehand, mut found, mut plain) =
        last.ok_or_else(|| Error::Unanswerable("no rows".into()))?;
    let held = held(&model, &beforehand, options, (constant, stated));
    let known = used(&beforehand, options);
    let mut kept = current;
    let mut follows = follow.columns;
    if options.robust {
        let mut rows = Rows { series: &kept, scales, follows: follows.clone(), weights: None };
        let keep = robust::kept(&model, &mut rows, (sensor, reference), (&held, &known), &found.state)?;
        let mut count = 0;
        for ((one, columns), keep) in kept.iter_mut().zip(&mut follows).zip(&keep) {
            count += keep.iter().filter(|keep| !**keep).count() as u64;
            checks::retain(one, keep);
            for column in columns.iter_mut() {
                let mut flags = keep.iter();
                column.retain(|_| *flags.next().unwrap_or(&true));
            }
        }
        left_out.push(("outliers (--robust)".into(), count));
        let rows = Rows { series: &kept, scales, follows: follows.clone(), weights: None };
        plain = rows.factor(&model.terms);
        let sums = Sums { plain: &plain, sensor, reference, held: &held };
        found = fit(&model, &sums, &known, std::slice::from_ref(&found.state))?;
    }
    let rows = Rows { series: &kept, scales, follows: follows.clone(), weights: None };
    let unit_nt = scales.magnitude_nt * model.scale(&found.state);
    let alone = Noise { white_rms_nt: Some(found.variance.sqrt() * unit_nt), ..Noise::default() };
    let declared = declared_form(document, sensor.map(|sensor| sensor + reference), &scales);
    let white = declared == Some(WHITE);
    let groups = if white { None } else { Groups::of(&rows, &model, &found, true) };
    let by_rotations = found.clone();
    let averaged = groups
        .map(|groups| {
            groups.average(
                &mut found,
                (&held, &known),
                (declared.unwrap_or(WHITE), declared.is_none(), unit_nt),
            )
        })
        .transpose()?
        .flatten();
    let (form, noise) = averaged.unwrap_or((WHITE, alone));
    let residuals = rows.residuals(&model, &found.state);
    let mu = frame(&found.state, &like);
    let mut sources: Vec<Source> = kept.iter().map(|one| one.source).collect();
    sources.sort_unstable();
    sources.dedup();
    let mut solved = Solved {
        unit,
        scales,
        units: follow.units,
        effects,
        noise,
        form,
        white,
        beforehand,
        known: held.iter().chain(&known).cloned().collect(),
        held,
        mu,
        recordings: kept.iter().map(|one| one.id.clone()).collect(),
        sources,
        rows: kept.iter().map(|one| one.len() as u64).sum(),
        missing: kept.iter().map(|one| one.missing as u64).sum(),
        left_out,
        told,
        body: None,
        includes_body: true,
        vector: None,
        model,
        found,
    };
    let detail = Detail { series: kept, residuals, follows, plain };
    determined(&solved, &by_rotations, &detail, options)?;
    solved.told.extend(wandering(&solved));
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

/// Whether a fitted effect takes the place of one of the model: the same of all recordings at all times.
fn replaces(fitted: &EffectInstance, one: &EffectInstance) -> bool {
    let of = |effect: &EffectInstance| {
        (effect.kind, effect.axis, effect.column.clone(), effect.recording.clone(), effect.within)
    };
    of(fitted) == of(one)
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

/// Relative standard uncertainty of a stated magnitude.
///
/// # Errors
///
/// Magnitudes that are stated with an uncertainty beside another reference, or several: each would need a
/// scale of its own.
fn stated_magnitude(document: &Document, series: &[Series]) -> Result<Option<f64>, Error> {
    let of = |one: &Series| {
        let stated = document.recordings[one.index].conditions.extra.get(crate::read::MAGNITUDE)?;
        let quantity = serde_json::from_value::<common::Quantity>(stated.clone()).ok()?;
        Some((quantity.value(), quantity.relative_std()?))
    };
    let stated: Vec<Option<(f64, f64)>> = series.iter().map(of).collect();
    let Some(first) = stated.iter().flatten().next().copied() else { return Ok(None) };
    if let Some(other) = stated.iter().position(|one| *one != Some(first)) {
        let path = format!("{}.conditions.{}", series[other].path(), crate::read::MAGNITUDE);
        let found = "a magnitude stated with an uncertainty, and recordings with a different magnitude";
        let expected = "one magnitude for all recordings, or none with an uncertainty; otherwise calibrate them one by one";
        return Err(Error::document(path, found, expected));
    }
    Ok(Some(first.1))
}

/// The rows for scales that nothing shows.
fn held(
    model: &Model,
    beforehand: &Beforehand,
    options: &Options,
    (constant, stated): (bool, Option<f64>),
) -> PriorRows {
    let mut rows = PriorRows::new();
    if let Some(place) = model.place(&Parameter::Magnitude) {
        let mut weights = vec![0.0; model.parameters.len()];
        match stated {
            Some(std) => {
                weights[place] = 1.0 / std;
                rows.push((weights, 1.0 / std));
            }
            // Only the ratio of magnitude and sensitivities is seen: the mean sensitivity is held at what is
            // known of it.
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

/// What is known beforehand, where it is to be used.
pub fn used(beforehand: &Beforehand, options: &Options) -> PriorRows {
    if options.known { beforehand.rows.clone() } else { PriorRows::new() }
}
