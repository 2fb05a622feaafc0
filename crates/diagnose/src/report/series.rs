//! Residuals before and after, against time and what the difference follows.

use common::ResidualSeries;
use estimate::grouped::{Grouped, grouped};
use nalgebra::Vector3;

use super::guilty::Guilty;
use crate::Outcome;
use crate::channel::Channel;
use crate::covariates;
use crate::model::Model;

/// Most points of a series.
const POINTS: usize = 160;
/// Most recordings whose residuals are given along time.
const RECORDINGS: usize = 12;

struct Point {
    x: f64,
    before: f64,
    after: f64,
}

pub(super) fn series(
    model: &Model<'_>,
    outcome: &Outcome,
    guilty: &Guilty,
    fields: &[Vec<Vector3<f64>>],
) -> Vec<ResidualSeries> {
    let points = |channel: &Channel, values: &[f64]| -> Vec<Point> {
        let point = |(row, at): (usize, &usize)| Point {
            x: values[*at],
            before: outcome.before[row],
            after: outcome.fit.residual[row],
        };
        channel.range().zip(&channel.rows).map(point).filter(|point| point.x.is_finite()).collect()
    };
    let channels = || guilty.channels.iter().map(|number| &model.observed.channels[*number]);
    let mut all = Vec::new();
    let mut recordings: Vec<usize> = channels().map(|channel| channel.run).collect();
    recordings.dedup();
    recordings.truncate(RECORDINGS);
    for channel in channels().filter(|channel| recordings.contains(&channel.run)) {
        let run = &model.observed.runs[channel.run];
        let Some(time) = run.time_s else { continue };
        let recording = Some(run.recording.id.clone());
        all.extend(one(recording, &channel.column, "time_s", points(channel, time)));
    }
    let mut columns: Vec<&str> = channels().map(|channel| channel.column.as_str()).collect();
    columns.sort_unstable();
    columns.dedup();
    for column in columns {
        for covariate in &guilty.covariates {
            let of = |channel: &Channel| {
                let values = covariates::values(model, fields, channel.run, channel.axis(), covariate)?;
                Some(points(channel, &values))
            };
            let along = channels().filter(|c| c.column == column).filter_map(of).flatten().collect();
            all.extend(one(None, column, covariate, along));
        }
    }
    all
}

/// Means of neighbours along something; None where all stand at one place.
fn one(recording: Option<String>, column: &str, along: &str, points: Vec<Point>) -> Option<ResidualSeries> {
    let of = |value: fn(&Point) -> f64| -> Vec<f64> { points.iter().map(value).collect() };
    let (before, after) = (of(|point| point.before), of(|point| point.after));
    let Grouped { x, columns: [before_nt, after_nt], points } =
        grouped(&of(|point| point.x), [&before, &after], POINTS)?;
    Some(ResidualSeries {
        recording,
        column: column.into(),
        along: along.into(),
        x,
        before_nt,
        after_nt,
        readings: points,
        ..ResidualSeries::default()
    })
}
