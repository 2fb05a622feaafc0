use common::number::{bare, signed};
use common::{Axis, Conditions, Error, procedure};
use serde::{Deserialize, Serialize};

use super::{Sequence, count, whole};
use crate::bench::{Bench, positive, samples};
use crate::planned::{Begins, Planned, Reads, Rows, Step, Surroundings};

/// Offset of each sensor in a shield, turned by 180° again and again: + − − + + − − + …, so that a drift of
/// the shield's field falls out of each pair of pairs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ReversalProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The sensors; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// Pairs of positions.
    #[serde(default = "count::<10>")]
    pub pairs: usize,
    /// What a code of the converter is divided by.
    #[serde(default = "whole::<1>")]
    pub amplification: f64,
}

/// Reversals at dates: once a week for a year.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DriftProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The sensors; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// Dates.
    #[serde(default = "count::<53>")]
    pub dates: usize,
    /// From one to the next, s.
    #[serde(default = "whole::<604_800>")]
    pub interval_s: f64,
    /// Pairs of positions at each.
    #[serde(default = "count::<10>")]
    pub pairs: usize,
    /// What a code of the converter is divided by.
    #[serde(default = "whole::<1>")]
    pub amplification: f64,
}

impl Sequence for ReversalProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("pairs", self.pairs as f64), ("amplification", self.amplification)])?;
        let sensors = bench.sensors(&self.sensors, path)?.len() as f64;
        Ok(samples(path, 2.0 * self.pairs as f64, 2.0)? * sensors)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let sensors = bench.sensors(&self.sensors, path)?.into_iter();
        let kind = procedure::SENSOR_OFFSET_REVERSAL;
        let one = |sensor| reversal(bench, kind, format!("{}-{sensor}", self.id), path, sensor, self.pairs);
        Ok(sensors.map(|sensor| Planned { amplification: self.amplification, ..one(sensor) }).collect())
    }
}

impl Sequence for DriftProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("dates", self.dates as f64), ("interval_s", self.interval_s)])?;
        positive(path, [("pairs", self.pairs as f64), ("amplification", self.amplification)])?;
        if bench.start.is_none() {
            let expected = "the moment at which the campaign begins, so that each date has its `start`";
            return Err(Error::document("start", "no such key", expected));
        }
        let sensors = bench.sensors(&self.sensors, path)?.len() as f64;
        let rows = 2.0 * self.pairs as f64 * self.dates as f64 * sensors;
        samples(path, rows, 2.0)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let sensors = bench.sensors(&self.sensors, path)?;
        let mut planned = Vec::new();
        for date in 0..self.dates {
            for (number, sensor) in sensors.iter().enumerate() {
                let id = format!("{}-{sensor}-{:02}", self.id, date + 1);
                let one = reversal(bench, procedure::OFFSET_DRIFT, id, path, *sensor, self.pairs);
                let at = date as f64 * self.interval_s + number as f64 * one.length_s();
                planned.push(Planned { begins: Begins::After(at), amplification: self.amplification, ..one });
            }
        }
        Ok(planned)
    }
}

fn reversal(bench: &Bench<'_>, kind: &str, id: String, path: &str, sensor: Axis, pairs: usize) -> Planned {
    let timing = bench.timing;
    let mut rows = Rows::new(format!("sensor {sensor} into the shield"), timing.orientation_s);
    let mut last = 0.0;
    for row in 0..2 * pairs {
        let position = if matches!(row % 4, 0 | 3) { 1.0 } else { -1.0 };
        let turned = row > 0 && position != last;
        last = position;
        let (action, wait_s) = (format!("position {}", signed(&bare(position))), timing.reversal_s);
        let step = Step::still(action, if turned { wait_s } else { 0.0 }, 1, timing.reading_s);
        rows.step(step, timing, &[("position", position)]);
    }
    let conditions = Conditions { sensor: Some(sensor), ..Conditions::default() };
    Planned {
        reads: Reads::Sensors(vec![sensor]),
        surroundings: Surroundings::Shield,
        ..Planned::new(kind, id, path, conditions, rows, &[])
    }
}
