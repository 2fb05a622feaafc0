use common::{Axis, Conditions, Error, procedure};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::reversal::no_gain;
use super::sequence::Sequence;
use crate::bench::{Bench, filled, positive, samples};
use crate::planned::{Planned, Reads, Rows, Surroundings};

/// Noise of the sensors in a shield: a day at 60 s, an hour at 1 s, a minute at 10 ms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NoiseProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The sensors; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// The series.
    #[serde(default = "report")]
    pub series: Vec<NoiseSeries>,
    /// What a code of the converter is divided by: the report's amplifier of about 40.
    #[serde(default = "no_gain")]
    pub amplification: f64,
}

/// A series at even steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NoiseSeries {
    /// Length, s.
    pub length_s: f64,
    /// From one sample to the next, s.
    pub step_s: f64,
}

fn report() -> Vec<NoiseSeries> {
    [(86_400.0, 60.0), (3600.0, 1.0), (60.0, 0.01)]
        .map(|(length_s, step_s)| NoiseSeries { length_s, step_s })
        .to_vec()
}

impl Sequence for NoiseProcedure {
    fn rows(&self, _: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, "amplification", self.amplification)?;
        filled(path, "series", &self.series)?;
        let mut rows = 0.0;
        for (index, series) in self.series.iter().enumerate() {
            let path = format!("{path}.series[{index}]");
            positive(&path, "length_s", series.length_s)?;
            positive(&path, "step_s", series.step_s)?;
            rows += samples(&path, series.length_s / series.step_s, 2.0)?;
        }
        Ok(rows)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let sensors = bench.sensors(&self.sensors, path)?;
        let series = self.series.iter().enumerate();
        Ok(series
            .map(|(number, series)| {
                let mut rows = Rows::new("sensors into the shield", bench.timing.orientation_s);
                let action = format!("record {} s at {} s", series.length_s, series.step_s);
                let step = bench.record(action, series.length_s, series.step_s);
                rows.series(step, series.step_s, |_| nalgebra::Vector3::zeros());
                let id = format!("{}-{}", self.id, number + 1);
                Planned {
                    reads: Reads::Sensors(sensors.clone()),
                    surroundings: Surroundings::Shield,
                    amplification: self.amplification,
                    ..Planned::new(procedure::SENSOR_NOISE, id, path.into(), Conditions::default(), rows, &[])
                }
            })
            .collect())
    }
}
