//! What explains the measurements beside the time: steps, columns of the variometer, measurements that are off.

use common::{Document, Error, procedure};
use estimate::stats::{mean, rms};
use indexmap::IndexMap;

use crate::evidence::{Data, Mixture, Regressor};
use crate::variometer::Series;

/// ln of the posterior odds from which a step, a column or a measurement that is off is taken.
const TAKEN: f64 = 3.0;
/// Standard deviation of a step or of a measurement that is off, nT.
const STEP_NT: f64 = 10.0;
/// The same of what a column makes, in its rms.
const FOLLOWS_NT: f64 = 5.0;
/// Most of them.
const MOST: usize = 12;
/// A column is known at a measurement from readings no further apart, s.
const LONGEST_GAP_S: f64 = 86_400.0;

#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// Before this measurement.
    Step(usize),
    /// This measurement alone.
    Off(usize),
    Column(usize),
}

/// A column of the variometer at the measurements, over its rms.
pub struct Follows {
    pub name: String,
    pub mean: f64,
    pub rms: f64,
    pub at: Vec<f64>,
}

/// Temperatures and tilts beside the variometer, where they change.
pub fn follows(document: &Document, times_s: &[f64]) -> Vec<Follows> {
    let mut points: IndexMap<&str, Vec<(f64, f64)>> = IndexMap::new();
    for recording in document.recordings.iter().filter(|one| one.procedure == procedure::VARIOMETER) {
        let Some((start, times)) = recording.start().zip(recording.column("time_s")) else { continue };
        for (name, column) in &recording.columns {
            if name.ends_with("_c") || name.ends_with("_rad") {
                let all = times.iter().zip(column.iter()).filter(|(_, value)| value.is_finite());
                let all = all.map(|(time, value)| (start.unix_s + time, *value));
                points.entry(name).or_default().extend(all);
            }
        }
    }
    let of = |(name, all): (&str, Vec<(f64, f64)>)| {
        let series = Series::of(all);
        let at = times_s.iter().map(|time| series.at(*time, LONGEST_GAP_S)).collect::<Option<Vec<f64>>>()?;
        let mean = mean(&at);
        let rms = rms(&at.iter().map(|value| value - mean).collect::<Vec<_>>());
        (rms > 0.0 && times_s.len() > 3).then(|| Follows {
            name: name.to_string(),
            mean,
            rms,
            at: at.iter().map(|value| (value - mean) / rms).collect(),
        })
    };
    points.into_iter().filter_map(of).collect()
}

/// A cause at the measurements.
pub fn regressor(cause: &Cause, count: usize, follows: &[Follows]) -> Regressor {
    let from = |is: &dyn Fn(usize) -> bool| (0..count).map(|i| f64::from(u8::from(is(i)))).collect();
    match cause {
        Cause::Step(before) => Regressor { at: from(&|i| i >= *before), prior_nt: STEP_NT },
        Cause::Off(at) => Regressor { at: from(&|i| i == *at), prior_nt: STEP_NT },
        Cause::Column(column) => Regressor { at: follows[*column].at.clone(), prior_nt: FOLLOWS_NT },
    }
}

/// Takes causes one by one, each time that of most evidence, while the readings are for it. Those of one kind share
/// the prior odds of one; a step where another component has `stepped` has them alone.
pub fn explained(
    data: &Data,
    follows: &[Follows],
    stepped: &[usize],
) -> Result<(Vec<(Cause, f64)>, Mixture), Error> {
    let (count, columns) = (data.years.len(), follows.len());
    // On either side of a step are two measurements.
    let places = 2..count.saturating_sub(1);
    let all: Vec<Cause> = (places.clone().map(Cause::Step))
        .chain((0..if count > 3 { count } else { 0 }).map(Cause::Off))
        .chain((0..columns).map(Cause::Column))
        .collect();
    let of = |causes: &mut dyn Iterator<Item = &Cause>| {
        causes.map(|cause| regressor(cause, count, follows)).collect()
    };
    let mut taken: Vec<(Cause, f64)> = Vec::new();
    loop {
        let regressors: Vec<Regressor> = of(&mut taken.iter().map(|(cause, _)| cause));
        let mixture = Mixture::of(data, &regressors)?;
        let others: Vec<&Cause> =
            all.iter().filter(|cause| !taken.iter().any(|(other, _)| other == *cause)).collect();
        let more: Vec<Regressor> = of(&mut others.iter().copied());
        let best = (others.into_iter().zip(mixture.log_bayes_factors(&more)))
            .map(|(cause, factor)| {
                let members = match cause {
                    Cause::Column(_) => columns,
                    Cause::Step(before) if stepped.contains(before) => 1,
                    Cause::Step(_) => places.len(),
                    Cause::Off(_) => count,
                };
                (cause, factor, factor - (members as f64).ln())
            })
            .max_by(|a, b| a.2.total_cmp(&b.2));
        match best.filter(|(_, _, odds)| *odds > TAKEN && taken.len() < MOST) {
            Some((cause, factor, _)) => taken.push((cause.clone(), factor)),
            None => return Ok((taken, mixture)),
        }
    }
}
