//! Residuals before and after, against time and what the difference follows.

use common::ResidualSeries;
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

/// Points in rising order, neighbours together where there are many; None where all stand at one place.
fn one(
    recording: Option<String>,
    column: &str,
    along: &str,
    mut points: Vec<Point>,
) -> Option<ResidualSeries> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    if points.first()?.x == points.last()?.x {
        return None;
    }
    let readings = points.len().div_ceil(POINTS);
    let mean = |of: fn(&Point) -> f64| -> Vec<f64> {
        points.chunks(readings).map(|some| some.iter().map(of).sum::<f64>() / some.len() as f64).collect()
    };
    Some(ResidualSeries {
        recording,
        column: column.into(),
        along: along.into(),
        x: mean(|point| point.x),
        before_nt: mean(|point| point.before),
        after_nt: mean(|point| point.after),
        readings,
    })
}
