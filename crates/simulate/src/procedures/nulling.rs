use common::number::{bare, duration};
use common::{Axis, Conditions, Error, procedure};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::sequence::Sequence;
use crate::bench::{Bench, filled, positive, samples};
use crate::outside::Site;
use crate::planned::{Begins, Planned, Reads, Rows};

/// What the nulling leaves at the coils' centre: in each condition of the site 8 hours at 0.2 Hz, one hour at
/// 2 Hz and one minute at 128 Hz.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NullingProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The conditions.
    #[serde(default = "all")]
    pub sites: Vec<Site>,
    /// The series in each.
    #[serde(default = "report")]
    pub series: Vec<NullingSeries>,
    /// The sensors that are read; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// Record the natural field outside beside.
    #[serde(default)]
    pub outside: bool,
}

/// A series at an even rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NullingSeries {
    /// Length, s.
    pub length_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

fn all() -> Vec<Site> {
    Site::ALL.to_vec()
}

fn report() -> Vec<NullingSeries> {
    [(28_800.0, 0.2), (3600.0, 2.0), (60.0, 128.0)]
        .map(|(length_s, rate_hz)| NullingSeries { length_s, rate_hz })
        .to_vec()
}

impl Sequence for NullingProcedure {
    fn rows(&self, _: &Bench<'_>, path: &str) -> Result<f64, Error> {
        filled(path, "sites", &self.sites)?;
        filled(path, "series", &self.series)?;
        let mut rows = 0.0;
        for (index, series) in self.series.iter().enumerate() {
            let path = format!("{path}.series[{index}]");
            positive(&path, "length_s", series.length_s)?;
            positive(&path, "rate_hz", series.rate_hz)?;
            rows += samples(&path, series.length_s * series.rate_hz, 2.0)?;
        }
        Ok(rows * self.sites.len() as f64)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let sensors = bench.sensors(&self.sensors, path)?;
        let mut planned = Vec::new();
        for site in &self.sites {
            for (number, series) in self.series.iter().enumerate() {
                let setup =
                    if number == 0 { "sensors along the coils, field nulled" } else { "same setting" };
                let mut rows = Rows::new(setup, 0.0);
                let action = format!(
                    "record {} at {} Hz, {}",
                    duration(series.length_s),
                    bare(series.rate_hz),
                    site.name()
                );
                let step = bench.record(action, series.length_s, 1.0 / series.rate_hz);
                rows.series(step, 1.0 / series.rate_hz, |_| nalgebra::Vector3::zeros());
                let mut conditions = Conditions::default();
                conditions.extra.insert("site".into(), site.name().into());
                let id = format!("{}-{}-{}", self.id, site.name(), number + 1);
                let mut recording =
                    Planned::new(procedure::NULLING_RESIDUAL, id, path.into(), conditions, rows, &[]);
                recording.reads = Reads::Sensors(sensors.clone());
                recording.outside = self.outside;
                if number == 0 {
                    let (day, hour) = site.when();
                    recording.begins = Begins::At { day, hour };
                }
                planned.push(recording);
            }
        }
        Ok(planned)
    }
}
