//! What was found, as the document's `diagnosis`.

use common::{
    Axis, BaseShift, Detectable, Diagnosis, DoubtfulValue, ExplainedEffect, Quantity, Remaining, Residual,
    ResidualOf, Rival, Share, Verdict,
};
use estimate::screen::Screen;
use estimate::stats::chi_squared_quantile;
use indexmap::IndexMap;
use physics::{EffectInstance, Parameter, Place, Role};

use crate::adopt::on_coil;
use crate::candidates::{What, named};
use crate::fit::{Fitter, HeldOut};
use crate::model::{Instrument, Model, Unknown};
use crate::search::{Addition, Searcher};
use crate::words::chance;
use crate::{Error, Found, Options, Outcome, next};

/// Standard deviations that make nine claims of ten out of five.
const NINE_OF_TEN: f64 = 1.2816;

/// The entry of a document.
pub fn report(
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    outcome: &Outcome,
    options: &Options,
) -> Result<Diagnosis, Error> {
    let rest = outcome.last.rest;
    let omnibus = rest.omnibus();
    let left = !outcome.last.clean(options.level);
    let equal: Vec<&Found> = outcome.found.iter().filter(|found| !found.rivals.equal.is_empty()).collect();
    let verdict = match (outcome.found.is_empty(), left, equal.is_empty()) {
        (true, false, _) => Verdict::Agrees,
        (true, true, _) => Verdict::Unexplained,
        (false, _, false) => Verdict::Ambiguous,
        (false, true, true) => Verdict::PartlyExplained,
        (false, false, true) => Verdict::Explained,
    };
    let fitter = Fitter { model, noise: &outcome.noise };
    let effects = explained(model, outcome, &fitter)?;
    let structure = structure(outcome, options);
    let mut places: Vec<Share> =
        outcome.found.iter().enumerate().map(|(k, _)| share(model, outcome, k)).collect();
    if left {
        places.extend(nameless_share(outcome, options));
    }
    let mut recordings: Vec<String> =
        places.iter().flat_map(|share| share.recordings.iter().cloned()).collect();
    recordings.sort();
    recordings.dedup();
    let next_experiment = match verdict {
        Verdict::Ambiguous => {
            let words =
                equal.iter().map(|found| next::between(&found.refined.proposal.name, &found.rivals.equal[0]));
            Some(words.collect::<Vec<_>>().join("; "))
        }
        Verdict::Unexplained | Verdict::PartlyExplained => {
            outcome.last.structures.first().map(|s| match &s.what {
                What::Smooth { covariate, .. } => next::unexplained(covariate),
                What::Dependence { column, .. } => next::unexplained(column),
                What::Physics(_) => String::new(),
            })
        }
        _ => None,
    };
    let first = outcome.first.rest.omnibus();
    let in_words = |p: Option<f64>| p.map_or("not declared".to_string(), |p| format!("p = {p:.2e}"));
    let mut reasons = vec![
        format!(
            "sum of squares over degrees of freedom {:.3} with the calibration fitted again ({}), {:.3} with what was found ({})",
            outcome.first.rest.sum_of_squares / outcome.first.rest.freedom,
            in_words(first),
            rest.sum_of_squares / rest.freedom,
            in_words(omnibus)
        ),
        format!(
            "most striking structure by chance: {:.2e} before, {:.2e} after, level {}",
            outcome.first.least_p, outcome.last.least_p, options.level
        ),
    ];
    if left {
        reasons.extend(outcome.refused.iter().map(|(name, why)| format!("not {name}: {why}")));
    }
    reasons.extend(model.observed.notes.iter().map(|note| format!("left aside: {note}")));
    let ambiguity = equal
        .iter()
        .flat_map(|found| std::iter::once(&found.refined.proposal.name).chain(&found.rivals.equal))
        .map(|name| vec![name.clone()])
        .collect();
    Ok(Diagnosis {
        verdict,
        reasons,
        recordings,
        places,
        effects,
        ambiguity,
        fit: Some(fit(model, outcome, &fitter)?),
        base_shift: base_shift(model, outcome),
        detectable: detectable(searcher, outcome, &fitter, options)?,
        remaining: Some(Remaining {
            white: !left,
            p_value: omnibus,
            p_adjusted: outcome.last.least_p,
            structure,
        }),
        next_experiment,
        extra: common::Extra::new(),
    })
}

/// The number of an effect of the state that a found thing is, or of a column.
fn place_of(outcome: &Outcome, number: usize) -> usize {
    let same = |found: &&Found| {
        matches!(found.refined.proposal.addition, Addition::Effect(_))
            == matches!(outcome.found[number].refined.proposal.addition, Addition::Effect(_))
    };
    outcome.found[..number].iter().filter(same).count()
}

/// The effect of a found thing at the final fit.
fn effect_of(outcome: &Outcome, number: usize) -> Option<(usize, &EffectInstance)> {
    match outcome.found[number].refined.proposal.addition {
        Addition::Effect(_) => {
            let at = outcome.base.state.effects.len() + place_of(outcome, number);
            Some((at, &outcome.fit.state.effects[at]))
        }
        Addition::Column(_) => None,
    }
}

/// Parameters of an effect of the final state with their uncertainty.
pub fn effect_quantities(model: &Model<'_>, outcome: &Outcome, effect: usize) -> IndexMap<String, Quantity> {
    let state = &outcome.fit.state;
    let free = model.free(state);
    let scale = outcome.last.rest.scale();
    let instance = &state.effects[effect];
    let parameters = instance.kind.parameters().iter().zip(&instance.parameters).enumerate();
    parameters
        .map(|(number, (info, value))| {
            let at = free.iter().position(|(e, p)| (*e, *p) == (effect, number));
            let variance = at.map_or(0.0, |at| {
                let at = model.unknowns.len() + at;
                outcome.fit.covariance[(at, at)] * scale
            });
            let factor = if info.role == Role::Shape { *value } else { 1.0 };
            let std = Some(variance.sqrt() * factor).filter(|std| std.is_finite());
            (info.name.to_string(), std.map_or(Quantity::Bare(*value), |std| Quantity::new(*value, std)))
        })
        .collect()
}

/// Share of the energy of the unknowns from `from` on that the base model leaves.
fn visible(fitter: &Fitter<'_, '_>, outcome: &Outcome, of: &[usize]) -> Result<f64, Error> {
    let base: Vec<usize> = (0..fitter.model.unknowns.len()).collect();
    let jacobian = &outcome.fit.jacobian;
    let screen = Screen::of(&fitter.products(jacobian, &outcome.fit.white)).given(&base)?;
    let (mut left, mut whole) = (0.0, 0.0);
    for column in of {
        let energy: f64 = jacobian.col_as_slice(*column).iter().map(|value| value * value).sum();
        (left, whole) = (left + screen.visible(*column) * energy, whole + energy);
    }
    Ok(if whole > 0.0 { left / whole } else { 0.0 })
}

fn explained(
    model: &Model<'_>,
    outcome: &Outcome,
    fitter: &Fitter<'_, '_>,
) -> Result<Vec<ExplainedEffect>, Error> {
    let base = model.unknowns.len();
    let free = model.free(&outcome.fit.state);
    let floor = floor(outcome);
    outcome
        .found
        .iter()
        .enumerate()
        .map(|(number, found)| {
            let rivals = found
                .rivals
                .lost
                .iter()
                .map(|(effect, why_not)| Rival { effect: effect.clone(), why_not: why_not.clone() });
            let count = outcome.fit.residual.len() as f64;
            let gains: Vec<f64> =
                found.refined.held_out.iter().map(|gain| in_nt(*gain, count / 6.0, floor)).collect();
            let mut effect = ExplainedEffect {
                p_adjusted: found.refined.p_adjusted,
                held_out_gain_nt: in_nt(found.refined.held_out.iter().sum(), count, floor),
                held_out_by_block_nt: gains,
                rivals: rivals.collect(),
                ..ExplainedEffect::default()
            };
            match effect_of(outcome, number) {
                Some((at, instance)) => {
                    let about = instance.kind.about();
                    let coil = on_coil(instance);
                    let own: Vec<usize> =
                        (0..free.len()).filter(|k| free[*k].0 == at).map(|k| base + k).collect();
                    effect.effect = about.name.into();
                    effect.sensor = instance.axis.filter(|_| !coil);
                    effect.coil = instance.axis.filter(|_| coil);
                    effect.column = instance.column.clone();
                    effect.recording = instance.recording.clone();
                    effect.title = about.title.into();
                    effect.physics = about.physics.into();
                    effect.equation = about.equation.into();
                    effect.source = about.source.into();
                    effect.parameters = effect_quantities(model, outcome, at);
                    effect.visible_fraction = visible(fitter, outcome, &own)?;
                }
                None => {
                    let place = place_of(outcome, number);
                    let column = &outcome.fit.state.columns[place];
                    let at = base + free.len() + place;
                    let std = (outcome.fit.covariance[(at, at)] * outcome.last.rest.scale()).sqrt();
                    let single = found.refined.proposal.local;
                    effect.effect = if single { "spike" } else { "dependence" }.into();
                    effect.title = column.what.clone();
                    if let Some((name, axis)) = &column.follows {
                        (effect.column, effect.sensor) = (Some(name.clone()), Some(*axis));
                    }
                    effect.equation =
                        if single { "dB = h in one reading" } else { "dB = c times the column, lagged" }
                            .into();
                    let name = if single { "height_nt" } else { "coefficient_nt_per_unit" };
                    effect.parameters.insert(name.into(), Quantity::new(column.coefficient, std));
                    effect.visible_fraction = visible(fitter, outcome, &[at])?;
                }
            }
            Ok(effect)
        })
        .collect()
}

/// A change of a sum of squares as a change of rms, nT.
fn in_nt(gain: f64, count: f64, floor: f64) -> f64 {
    gain.signum() * (gain.abs() / count).sqrt() * floor
}

/// Rms of the noise over all readings, nT.
fn floor(outcome: &Outcome) -> f64 {
    let std = &outcome.noise.std_nt;
    let mean: f64 = std.iter().map(|std| std * std).sum::<f64>() / std.len().max(1) as f64;
    (mean * outcome.last.rest.scale()).sqrt()
}

fn share(model: &Model<'_>, outcome: &Outcome, number: usize) -> Share {
    let found = &outcome.found[number];
    let excess = (outcome.first.rest.sum_of_squares - outcome.last.rest.freedom * outcome.last.rest.scale())
        .max(found.gain);
    let energy_share = Some((found.gain / excess).clamp(0.0, 1.0));
    let Some((at, effect)) = effect_of(outcome, number) else {
        let column = &outcome.fit.state.columns[place_of(outcome, number)];
        let mut share = Share { energy_share, description: column.what.clone(), ..Share::default() };
        if found.refined.proposal.local {
            share.readings = single(model, column);
            share.recordings = share.readings.iter().map(|reading| reading.recording.clone()).collect();
        }
        return share;
    };
    let about = effect.kind.about();
    let runs = model.observed.runs.iter().zip(&outcome.fit.state.acts[at]);
    let frame = match effect.kind.place() {
        Place::Sensor | Place::Electronics | Place::Logger | Place::Spacecraft => "SEN",
        Place::Facility | Place::Environment | Place::Sites => "GEO",
    };
    let mut covariates: Vec<String> =
        about.needs.iter().filter(|need| !need.contains(' ')).map(|need| (*need).into()).collect();
    covariates.extend(effect.column.clone());
    let sensors = if on_coil(effect) { Vec::new() } else { effect.axis.into_iter().collect() };
    let frequency = about.parameters.iter().position(|info| info.name == "frequency_hz");
    let moment = about.parameters.iter().position(|info| info.role == Role::Epoch);
    Share {
        place: Some(effect.kind.place().word().into()),
        sensors,
        frame: Some(frame.into()),
        covariates,
        energy_share,
        recordings: runs.filter(|(_, acts)| **acts).map(|(run, _)| run.recording.id.clone()).collect(),
        time_s: moment.map(|at| [effect.parameters[at]; 2]),
        band_hz: frequency.map(|at| [effect.parameters[at]; 2]),
        description: about.title.into(),
        ..Share::default()
    }
}

/// The one reading that a column is.
fn single(model: &Model<'_>, column: &crate::model::Column) -> Vec<DoubtfulValue> {
    let hit = |channel: &&crate::observed::Channel| channel.range().any(|row| column.values[row] != 0.0);
    let found = model.observed.channels.iter().filter(hit).map(|channel| {
        let row = channel.range().position(|row| column.values[row] != 0.0).unwrap_or(0);
        DoubtfulValue {
            recording: model.observed.runs[channel.run].recording.id.clone(),
            column: channel.column.clone(),
            row: channel.rows[row],
            departure_nt: Quantity::Bare(column.coefficient),
        }
    });
    found.collect()
}

/// Where structure without a name lies.
fn nameless_share(outcome: &Outcome, options: &Options) -> Option<Share> {
    let line = outcome.last.line.as_ref().filter(|line| line.p < options.level / 3.0);
    let Some(structure) = outcome.last.structures.first() else {
        return line.map(|line| Share {
            recordings: vec![line.recording.clone()],
            band_hz: Some([line.frequency_hz; 2]),
            description: format!("a line at {:.6} Hz", line.frequency_hz),
            ..Share::default()
        });
    };
    let (covariate, axis): (String, Option<Axis>) = match &structure.what {
        What::Smooth { covariate, axis } => (covariate.clone(), Some(*axis)),
        What::Dependence { column, axis } => (column.clone(), Some(*axis)),
        What::Physics(effect) => (named(effect), effect.axis),
    };
    let rest = &outcome.last.rest;
    Some(Share {
        sensors: axis.into_iter().collect(),
        covariates: vec![covariate],
        energy_share: Some((structure.gain / rest.sum_of_squares).clamp(0.0, 1.0)),
        description: structure.what.name(),
        ..Share::default()
    })
}

fn structure(outcome: &Outcome, options: &Options) -> String {
    let mut words = Vec::new();
    if let Some(structure) = outcome.last.structures.first() {
        words.push(format!("{} ({})", structure.what.name(), chance(structure.p_adjusted)));
    }
    if let Some(line) = outcome.last.line.as_ref().filter(|line| line.p < options.level / 3.0) {
        words.push(format!(
            "a line at {:.6} Hz in \"{}\" ({})",
            line.frequency_hz,
            line.recording,
            chance(line.p)
        ));
    }
    words.extend(
        outcome.last.proposals.iter().take(3).map(|p| format!("looks like {} ({})", p.name, chance(p.p))),
    );
    words.join("; ")
}

fn fit(model: &Model<'_>, outcome: &Outcome, fitter: &Fitter<'_, '_>) -> Result<Residual, Error> {
    let rms =
        |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt();
    let floor = floor(outcome);
    let scale = outcome.last.rest.scale().sqrt();
    let held = |out: HeldOut, unit: f64| (out.parts.iter().sum::<f64>() / out.rows.max(1.0)).sqrt() * unit;
    let base = Fitter { model, noise: &outcome.base_noise };
    let base_mean: f64 =
        outcome.base_noise.std_nt.iter().map(|s| s * s).sum::<f64>() / outcome.base_noise.std_nt.len() as f64;
    let mean: f64 =
        outcome.noise.std_nt.iter().map(|s| s * s).sum::<f64>() / outcome.noise.std_nt.len() as f64;
    Ok(Residual {
        rms_before_nt: rms(&outcome.before),
        rms_refitted_nt: rms(&outcome.base.residual),
        rms_after_nt: rms(&outcome.fit.residual),
        held_out_before_nt: held(base.held_out(&outcome.base)?, base_mean.sqrt()),
        held_out_after_nt: held(fitter.held_out(&outcome.fit)?, mean.sqrt()),
        noise_floor_nt: floor,
        noise_source: outcome.noise.source.into(),
        by_recording: model
            .observed
            .channels
            .iter()
            .zip(&outcome.noise.std_nt)
            .map(|(channel, std)| ResidualOf {
                recording: model.observed.runs[channel.run].recording.id.clone(),
                column: channel.column.clone(),
                rms_before_nt: rms(&outcome.before[channel.range()]),
                rms_after_nt: rms(&outcome.fit.residual[channel.range()]),
                noise_floor_nt: std * scale,
            })
            .collect(),
        extra: common::Extra::new(),
    })
}

fn base_shift(model: &Model<'_>, outcome: &Outcome) -> Vec<BaseShift> {
    let scale = outcome.last.rest.scale();
    let name = |unknown: &Unknown| match unknown {
        Unknown::Chain(parameter, instrument) => {
            let test = if *instrument == Instrument::Pair { "test." } else { "" };
            match parameter {
                Parameter::Sensitivity(axis) => format!("{test}sensors.{axis}.sensitivity"),
                Parameter::SensorOffset(axis) => format!("{test}sensors.{axis}.offset_nt"),
                Parameter::SensorTurn(axis, which) => format!("{test}axes.sensors.{axis}.turn_{which}_rad"),
                Parameter::CoilConstant(axis) => format!("coils.{axis}.constant_nt_per_a"),
                Parameter::CoilOffset(axis) => format!("coils.{axis}.offset_nt"),
                Parameter::CoilTurn(axis, which) => format!("axes.coils.{axis}.turn_{which}_rad"),
                Parameter::Effect(effect, parameter) => format!("effects[{effect}][{parameter}]"),
            }
        }
        Unknown::Field(axis) => format!("axes.residual_field_nt.{axis}"),
        Unknown::Level(channel) => {
            let channel = &model.observed.channels[*channel];
            format!(
                "field of the shield in \"{}\", {}, nt",
                model.observed.runs[channel.run].recording.id, channel.column
            )
        }
        Unknown::Turn { setting, about } => format!("setting {setting} of the block about axis {about}, rad"),
    };
    let shifts = model.unknowns.iter().zip(&outcome.fit.state.base).enumerate();
    shifts
        .filter(|(k, (_, shift))| **shift != 0.0 && outcome.fit.covariance[(*k, *k)].is_finite())
        .map(|(k, (unknown, shift))| BaseShift {
            parameter: name(unknown),
            shift: Quantity::new(*shift, (outcome.fit.covariance[(k, k)] * scale).sqrt()),
        })
        .collect()
}

/// For each candidate of the catalogue that was not found, the smallest size that would have been claimed nine times in ten.
fn detectable(
    searcher: &mut Searcher<'_>,
    outcome: &Outcome,
    fitter: &Fitter<'_, '_>,
    options: &Options,
) -> Result<Vec<Detectable>, Error> {
    let (screen, base) = searcher.screen(fitter, &outcome.fit)?;
    let scale = outcome.last.rest.scale();
    let mut all = Vec::new();
    for (number, candidate) in searcher.candidates().iter().enumerate() {
        let What::Physics(effect) = &candidate.what else { continue };
        if outcome.fit.state.effects.iter().any(|other| named(other) == named(effect)) {
            continue;
        }
        let amplitudes: Vec<&str> = effect
            .kind
            .parameters()
            .iter()
            .filter(|info| (info.role == Role::Amplitude) != candidate.finite)
            .map(|info| info.name)
            .collect();
        let threshold =
            chi_squared_quantile(1.0 - searcher.threshold(number, options.level), amplitudes.len() as f64);
        let z = threshold.sqrt() + NINE_OF_TEN;
        let mut smallest: IndexMap<String, f64> = IndexMap::new();
        let mut visible = 0.0_f64;
        for trial in &candidate.trials {
            for (name, column) in amplitudes.iter().zip(&trial.columns) {
                visible = visible.max(screen.visible(base + column));
                let one = screen.gain(&[base + column])?;
                if one.rank == 0 {
                    continue;
                }
                let mut size = z * (one.covariance[(0, 0)] * scale).sqrt();
                if candidate.finite {
                    // The column is what the effect does at this shape, so that a share of it is about that share of the shape.
                    match trial.shape.filter(|_| size <= 1.0) {
                        Some(shape) => size *= shape,
                        None => continue,
                    }
                }
                let entry = smallest.entry((*name).to_string()).or_insert(f64::INFINITY);
                *entry = entry.min(size);
            }
        }
        let target = effect.axis.map(|axis| axis.to_string()).or_else(|| effect.column.clone());
        all.push(Detectable {
            effect: effect.kind.name().into(),
            target,
            smallest,
            visible_fraction: visible,
        });
    }
    Ok(all)
}
