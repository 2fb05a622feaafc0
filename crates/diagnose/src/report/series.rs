//! Residuals before and after, against time and what the difference follows.

use common::ResidualSeries;
use nalgebra::Vector3;

use super::effects::places_of;
use super::guilty::Guilty;
use crate::channel::Channel;
use crate::covariates;
use crate::drawn::Drawn;
use crate::model::Model;
use crate::{Error, Outcome};

/// Most recordings whose residuals are given along time.
const RECORDINGS: usize = 12;

pub(super) fn series(
    model: &Model<'_>,
    outcome: &Outcome,
    labels: &[String],
    guilty: &Guilty,
    fields: &[Vec<Vector3<f64>>],
) -> Result<Vec<ResidualSeries>, Error> {
    let contributions = contributions(model, outcome, labels)?;
    let drawn = |channel: &Channel, values: &[f64]| -> Drawn {
        let rows: Vec<usize> = channel.range().collect();
        let of = |values: &[f64]| rows.iter().map(|row| values[*row]).collect();
        Drawn {
            x: channel.rows.iter().map(|row| values[*row]).collect(),
            before: of(&outcome.before),
            after: of(&outcome.fit.residual),
            recorded: Vec::new(),
            contributions: contributions.iter().map(|(label, values)| (label.clone(), of(values))).collect(),
        }
    };
    let channels = || guilty.channels.iter().map(|number| &model.observed.channels[*number]);
    let mut all = Vec::new();
    let mut recordings: Vec<usize> = channels().map(|channel| channel.run).collect();
    recordings.dedup();
    recordings.truncate(RECORDINGS);
    for channel in channels().filter(|channel| recordings.contains(&channel.run)) {
        let run = &model.observed.runs[channel.run];
        let Some(time) = run.time_s else { continue };
        let recorded = channel.readings.iter().map(|reading| reading * channel.to_nt).collect();
        let drawn = Drawn { recorded, ..drawn(channel, time) };
        all.extend(drawn.series(Some(run.recording.id.clone()), &channel.column, "time_s"));
    }
    let mut columns: Vec<&str> = channels().map(|channel| channel.column.as_str()).collect();
    columns.sort_unstable();
    columns.dedup();
    for column in columns {
        for covariate in &guilty.covariates {
            let mut along = Drawn::default();
            for channel in channels().filter(|channel| channel.column == column) {
                let values = covariates::values(model, fields, channel.run, channel.axis(), covariate);
                values.into_iter().for_each(|values| along.append(drawn(channel, &values)));
            }
            all.extend(along.series(None, column, covariate));
        }
    }
    Ok(all)
}

/// By how much the residual is larger without each of what was found, the calibration and the others as they were
/// fitted, nT.
fn contributions(
    model: &Model<'_>,
    outcome: &Outcome,
    labels: &[String],
) -> Result<Vec<(String, Vec<f64>)>, Error> {
    let without = |number: usize| {
        let (effects, singles) = places_of(outcome, number);
        let mut state = outcome.fit.state.clone();
        state.singles.drain(singles);
        state.keep_effects(|effect| !effects.contains(&effect));
        let residual = model.residual(&state)?;
        let larger = residual.iter().zip(&outcome.fit.residual).map(|(without, with)| without - with);
        Ok((labels[number].clone(), larger.collect()))
    };
    (0..outcome.found.len()).map(without).collect()
}
