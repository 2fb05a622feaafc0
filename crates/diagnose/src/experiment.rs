//! The recording that would decide between names: of the recordings that the site can make, the one in which
//! they predict what is most unlike.

mod variants;

use common::{Document, Experiment, Noise, NoiseOfSensors, Recording};
use faer::Mat;
use serde_json::{Value, json};

use physics::EffectInstance;

use crate::additions::{at_shapes, with_additions};
use crate::algebra::square;
use crate::fit::Fitter;
use crate::model::{Model, State};
use crate::observed::Observed;
use crate::proposal::Addition;
use crate::stacked::Stacked;
use crate::verdict::Alternative;
use crate::whitening::NoiseModel;
use crate::{Error, Outcome};
use variants::{Variant, is_reading, variants};

/// Experiments that are told of each open question.
const TOLD: usize = 5;
/// Log odds below which a recording would decide nothing.
const LEAST: f64 = 3.0;
/// Rows of a recording that is planned.
const ROWS: usize = 400;

/// The experiments for each name that stands beside others, the best first, with its plan.
pub fn experiments(model: &Model<'_>, outcome: &Outcome) -> Result<Vec<Experiment>, Error> {
    let mut all = Vec::new();
    let document = model.observed.document;
    let mut bare = document.clone();
    (bare.recordings, bare.diagnosis, bare.history) = (Vec::new(), None, Vec::new());
    if outcome.now.noise.known == 0.0 {
        let noise = Noise { white_rms_nt: Some(outcome.now.noise.variance().sqrt()), ..Noise::default() };
        bare.instrument.get_or_insert_default().noise = Some(NoiseOfSensors::Same(noise));
    }
    for found in outcome.found.iter().filter(|found| !found.equal.is_empty()) {
        let own = Alternative { name: found.name.clone(), additions: found.additions.clone() };
        let names: Vec<Alternative> = std::iter::once(own).chain(found.equal.iter().cloned()).collect();
        let Some(run) = most_affected(model, outcome, &names[0])? else { continue };
        let recording = thinned(model.observed.runs[run].recording);
        let mut ranked: Vec<(f64, Variant)> = Vec::new();
        for variant in variants(&bare, &recording) {
            let log_odds = decides(&bare, &variant, &names)?;
            ranked.push((log_odds, variant));
        }
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        ranked.retain(|(log_odds, _)| *log_odds > LEAST);
        all.extend(ranked.into_iter().take(TOLD).enumerate().map(|(place, (log_odds, variant))| {
            Experiment {
                between: names.iter().map(|name| name.name.clone()).collect(),
                plan: (place == 0).then(|| plan(document, &variant)),
                what: variant.words,
                log_odds,
            }
        }));
    }
    Ok(all)
}

fn most_affected(model: &Model<'_>, outcome: &Outcome, name: &Alternative) -> Result<Option<usize>, Error> {
    let state = &outcome.base.fit.state;
    let does = model.change(state, &with_additions(model, state, &name.additions))?;
    let of = |run: usize| -> f64 {
        model.observed.channels_of(run).map(|channel| square(&does[channel.range()])).sum()
    };
    Ok((0..model.observed.runs.len()).max_by(|a, b| of(*a).total_cmp(&of(*b))))
}

/// No more rows than a plan should have, evenly chosen.
fn thinned(recording: &Recording) -> Recording {
    let step = recording.rows().div_ceil(ROWS).max(1);
    let mut thinned = recording.clone();
    for column in thinned.columns.values_mut() {
        *column = column.iter().copied().step_by(step).collect();
    }
    thinned
}

/// Expected log odds between the two of the names that the recording parts least: half of what of one's
/// prediction the other, with its sizes and shapes and the calibration free, cannot follow, in squares of the
/// noise; as if nothing else were known.
fn decides(bare: &Document, variant: &Variant, names: &[Alternative]) -> Result<f64, Error> {
    let document = Document { recordings: vec![variant.recording.clone()], ..bare.clone() };
    // What cannot be predicted there decides nothing.
    let Ok(observed) = Observed::of(&document) else { return Ok(0.0) };
    let (model, state) = Model::of(observed)?;
    let zeros = vec![0.0; model.observed.rows];
    let noise = NoiseModel::of(&model.observed, &state, &zeros)?;
    let base = noise.whiten_all(&model.observed, &model.base_columns(&state)?);
    let mut predicted = Vec::new();
    for name in names {
        let followed = elsewhere(&name.additions);
        let does = model.change(&state, &with_additions(&model, &state, &followed))?;
        if does.iter().any(|value| !value.is_finite()) {
            return Ok(0.0);
        }
        let own = noise.whiten_all(&model.observed, &columns(&model, &state, &followed)?);
        predicted.push((noise.whiten(&model.observed, &does), [&base[..], &own].concat()));
    }
    let fitter = Fitter { model: &model, noise: &noise };
    let mut least = f64::INFINITY;
    for (k, (one, of_one)) in predicted.iter().enumerate() {
        for (other, of_other) in &predicted[k + 1..] {
            let apart = unexplained(&fitter, one, of_other)? + unexplained(&fitter, other, of_one)?;
            least = least.min(0.25 * apart);
        }
    }
    Ok(if least.is_finite() { least } else { 0.0 })
}

/// Additions as they are in other recordings, where a single reading says nothing.
fn elsewhere(additions: &[Addition]) -> Vec<Addition> {
    let of = |addition: &Addition| match addition {
        Addition::Effect(effect) => {
            Some(Addition::Effect(EffectInstance { recording: None, ..effect.clone() }))
        }
        Addition::Single(_) => None,
    };
    additions.iter().filter_map(of).collect()
}

/// Columns by sizes and shapes of additions.
fn columns(model: &Model<'_>, state: &State, additions: &[Addition]) -> Result<Vec<Vec<f64>>, Error> {
    let mut all = Vec::new();
    for addition in additions {
        match addition {
            Addition::Effect(effect) => {
                let (columns, by_shape) = at_shapes(model, state, effect)?;
                let stacked = columns.iter().chain(&by_shape).filter(|column| column.is_finite());
                all.extend(stacked.map(|column: &Stacked| column.dense(&model.observed)));
            }
            Addition::Single(single) => all.push(model.one_at(single.row)),
        }
    }
    Ok(all)
}

/// Squared length of what some columns leave of a series, all whitened.
fn unexplained(fitter: &Fitter<'_, '_>, series: &[f64], columns: &[Vec<f64>]) -> Result<f64, Error> {
    let all: Vec<usize> = (0..columns.len()).collect();
    Ok(fitter.screen(&Mat::new(), columns, series).given(&all)?.sum_of_squares())
}

/// A plan of one recording for `simulate campaign`: what the document states, and the columns that are set.
fn plan(document: &Document, variant: &Variant) -> Value {
    let recording = &variant.recording;
    let mut columns = recording.columns.clone();
    columns.retain(|name, _| !is_reading(name));
    let mut plan = json!({
        "fluxcal": 1,
        "title": variant.words,
        "procedures": [{"procedure": "free_run", "id": recording.id, "conditions": recording.conditions, "columns": columns}],
    });
    let parts = [
        ("facility", json!(document.facility)),
        ("instrument", json!(document.instrument)),
        ("calibration", json!(document.calibration)),
        ("start", json!(recording.start)),
    ];
    for (key, value) in parts.into_iter().filter(|(_, value)| !value.is_null()) {
        plan[key] = value;
    }
    plan
}
