//! Residuals before and after, against time and what the difference follows, as a few points for plots.

use common::ResidualSeries;
use estimate::grouped::{Grouped, grouped};
use indexmap::IndexMap;
use nalgebra::Vector3;

use super::effects::places_of;
use super::places::Guilty;
use crate::channel::Channel;
use crate::model::Model;
use crate::{Error, Outcome, covariates};

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
            after: of(&outcome.now.fit.residual),
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

/// By how much the residual is larger without each of what was found, all else as it was fitted, nT.
fn contributions(
    model: &Model<'_>,
    outcome: &Outcome,
    labels: &[String],
) -> Result<Vec<(String, Vec<f64>)>, Error> {
    let without = |number: usize| {
        let (effects, singles) = places_of(outcome, number);
        let mut state = outcome.now.fit.state.clone();
        state.singles.drain(singles);
        state.keep_effects(|effect| !effects.contains(&effect));
        let residual = model.residual(&state)?;
        let larger = residual.iter().zip(&outcome.now.fit.residual).map(|(without, with)| without - with);
        Ok((labels[number].clone(), larger.collect()))
    };
    (0..outcome.found.len()).map(without).collect()
}

/// Most points of a series.
const POINTS: usize = 160;

/// What is drawn of some readings along one thing.
#[derive(Default)]
pub struct Drawn {
    pub x: Vec<f64>,
    /// The residual before and after, nT.
    pub before: Vec<f64>,
    pub after: Vec<f64>,
    /// The readings, nT; empty where they are not drawn.
    pub recorded: Vec<f64>,
    /// By how much the residual is larger without an effect, with the effect's label, nT.
    pub contributions: Vec<(String, Vec<f64>)>,
}

impl Drawn {
    /// Adds what is drawn of other readings, of the same effects.
    pub fn append(&mut self, other: Self) {
        self.x.extend(other.x);
        self.before.extend(other.before);
        self.after.extend(other.after);
        self.recorded.extend(other.recorded);
        if self.contributions.is_empty() {
            self.contributions = other.contributions;
        } else {
            let pairs = self.contributions.iter_mut().zip(other.contributions);
            pairs.for_each(|((_, own), (_, other))| own.extend(other));
        }
    }

    /// Means of neighbours; None where all stand at one place.
    pub fn series(&self, recording: Option<String>, column: &str, along: &str) -> Option<ResidualSeries> {
        let recorded = Some(&self.recorded).filter(|recorded| !recorded.is_empty());
        let of_effects = self.contributions.iter().map(|(_, of)| of);
        let columns = [&self.before, &self.after].into_iter().chain(recorded).chain(of_effects);
        let columns: Vec<&[f64]> = columns.map(Vec::as_slice).collect();
        let Grouped { x, columns, points } = grouped(&self.x, &columns, POINTS)?;
        let mut columns = columns.into_iter();
        let mut next = || columns.next().unwrap_or_default();
        let (before_nt, after_nt) = (next(), next());
        let recorded_nt = if recorded.is_some() { next() } else { Vec::new() };
        // Several of one label are one contribution.
        let mut contributions_nt: IndexMap<String, Vec<f64>> = IndexMap::new();
        for ((label, _), values) in self.contributions.iter().zip(columns) {
            let sum = contributions_nt.entry(label.clone()).or_insert_with(|| vec![0.0; values.len()]);
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
        Some(ResidualSeries {
            recording,
            column: column.into(),
            along: along.into(),
            x,
            before_nt,
            after_nt,
            recorded_nt,
            contributions_nt,
            readings: points,
            ..ResidualSeries::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_column_keeps_its_place() {
        let one = |at: f64| Drawn {
            x: vec![at],
            before: vec![2.0],
            after: vec![1.0],
            recorded: vec![9.0],
            contributions: vec![("a".into(), vec![at]), ("b".into(), vec![-at])],
        };
        let mut drawn = one(1.0);
        drawn.append(one(2.0));
        let series = drawn.series(None, "sensor_x_nt", "time_s").expect("a series");
        assert_eq!(
            [series.recorded_nt, series.before_nt, series.after_nt].concat(),
            [9.0, 9.0, 2.0, 2.0, 1.0, 1.0]
        );
        assert_eq!(series.contributions_nt["b"], [-1.0, -2.0]);
        assert_eq!(one(1.0).series(None, "", ""), None);
    }
}
