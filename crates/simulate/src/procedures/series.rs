use common::number::{bare, duration};
use common::{Axis, Conditions, Error, procedure};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{MONTH_S, Sequence, whole};
use crate::bench::{Bench, filled, positive, samples};
use crate::outside::Site;
use crate::planned::{Begins, Planned, Reads, Rows, Surroundings};

/// What the nulling leaves at the coils' centre: in each condition of the site 8 hours at 0.2 Hz, one hour at
/// 2 Hz and one minute at 128 Hz.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NullingProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The conditions.
    #[serde(default = "all")]
    pub sites: Vec<Site>,
    /// The series in each.
    #[serde(default = "nulling_report")]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

fn nulling_report() -> Vec<NullingSeries> {
    [(28_800.0, 0.2), (3600.0, 2.0), (60.0, 128.0)]
        .map(|(length_s, rate_hz)| NullingSeries { length_s, rate_hz })
        .to_vec()
}

/// Samples of several series in all; `of` gives the two numbers of one, which are positive, and its samples.
fn in_all<Series>(
    path: &str,
    all: &[Series],
    of: impl Fn(&Series) -> ([(&str, f64); 2], f64),
) -> Result<f64, Error> {
    filled(path, "series", all, "at least one entry")?;
    let mut rows = 0.0;
    for (index, series) in all.iter().enumerate() {
        let (path, (numbers, count)) = (format!("{path}.series[{index}]"), of(series));
        positive(&path, numbers)?;
        rows += samples(&path, count, 2.0)?;
    }
    Ok(rows)
}

impl Sequence for NullingProcedure {
    fn rows(&self, _: &Bench<'_>, path: &str) -> Result<f64, Error> {
        filled(path, "sites", &self.sites, "at least one entry")?;
        let rows = in_all(path, &self.series, |NullingSeries { length_s, rate_hz }| {
            ([("length_s", *length_s), ("rate_hz", *rate_hz)], length_s * rate_hz)
        })?;
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
                let (length, rate) = (duration(series.length_s), bare(series.rate_hz));
                let action = format!("record {length} at {rate} Hz, {}", site.name());
                let step = bench.record(action, series.length_s, 1.0 / series.rate_hz);
                rows.series(step, 1.0 / series.rate_hz, |_| Vector3::zeros());
                let mut conditions = Conditions::default();
                conditions.extra.insert("site".into(), site.name().into());
                let id = format!("{}-{}-{}", self.id, site.name(), number + 1);
                let (day, hour) = site.when();
                planned.push(Planned {
                    reads: Reads::Sensors(sensors.clone()),
                    outside: self.outside,
                    begins: if number == 0 { Begins::At { day, hour } } else { Begins::Next },
                    ..Planned::new(procedure::NULLING_RESIDUAL, id, path, conditions, rows, &[])
                });
            }
        }
        Ok(planned)
    }
}

/// Noise of the sensors in a shield: a day at 60 s, an hour at 1 s, a minute at 10 ms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NoiseProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The sensors; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// The series.
    #[serde(default = "noise_report")]
    pub series: Vec<NoiseSeries>,
    /// What a code of the converter is divided by: the report's amplifier of about 40.
    #[serde(default = "whole::<1>")]
    pub amplification: f64,
}

/// A series at even steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NoiseSeries {
    /// Length, s.
    pub length_s: f64,
    /// From one sample to the next, s.
    pub step_s: f64,
}

fn noise_report() -> Vec<NoiseSeries> {
    [(86_400.0, 60.0), (3600.0, 1.0), (60.0, 0.01)]
        .map(|(length_s, step_s)| NoiseSeries { length_s, step_s })
        .to_vec()
}

impl Sequence for NoiseProcedure {
    fn rows(&self, _: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("amplification", self.amplification)])?;
        in_all(path, &self.series, |NoiseSeries { length_s, step_s }| {
            ([("length_s", *length_s), ("step_s", *step_s)], length_s / step_s)
        })
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let sensors = bench.sensors(&self.sensors, path)?;
        let of = |(number, series): (usize, &NoiseSeries)| {
            let mut rows = Rows::new("sensors into the shield", bench.timing.orientation_s);
            let action = format!("record {} s at {} s", series.length_s, series.step_s);
            let step = bench.record(action, series.length_s, series.step_s);
            rows.series(step, series.step_s, |_| Vector3::zeros());
            let id = format!("{}-{}", self.id, number + 1);
            Planned {
                reads: Reads::Sensors(sensors.clone()),
                surroundings: Surroundings::Shield,
                amplification: self.amplification,
                ..Planned::new(procedure::SENSOR_NOISE, id, path, Conditions::default(), rows, &[])
            }
        };
        Ok(self.series.iter().enumerate().map(of).collect())
    }
}

/// A reference and a test magnetometer side by side in the natural field: a month at one sample a minute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DifferentialProcedure {
    /// The recording's id.
    pub id: String,
    /// Length, s.
    #[serde(default = "whole::<MONTH_S>")]
    pub length_s: f64,
    /// From one sample to the next, s.
    #[serde(default = "whole::<60>")]
    pub step_s: f64,
}

impl Sequence for DifferentialProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("length_s", self.length_s), ("step_s", self.step_s)])?;
        if bench.outside.is_none() {
            let expected = "the natural field that both magnetometers see: main_field_nt and its variations";
            return Err(Error::document("truth.outside", "no such key", expected));
        }
        if bench.differential.is_none() {
            let expected = "the axes and scales of the two magnetometers";
            return Err(Error::document("truth.differential", "no such key", expected));
        }
        samples(path, self.length_s / self.step_s, 5.0)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let mut rows = Rows::new("both magnetometers on their pillars", bench.timing.orientation_s);
        let action = format!("record {} at {} s", duration(self.length_s), bare(self.step_s));
        let step = bench.record(action, self.length_s, self.step_s);
        rows.series(step, self.step_s, |_| Vector3::zeros());
        let (id, kind) = (self.id.clone(), procedure::DIFFERENTIAL);
        Ok(vec![Planned {
            reads: Reads::Differential,
            surroundings: Surroundings::Open,
            ..Planned::new(kind, id, path, Conditions::default(), rows, &[])
        }])
    }
}
