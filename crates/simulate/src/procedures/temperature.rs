use common::number::bare;
use common::{Axis, Error, procedure};
use serde::{Deserialize, Serialize};

use super::{Sequence, count, whole};
use crate::bench::{Bench, filled, on, positive, samples, sweep};
use crate::planned::{Planned, Rows, Step};

/// Sensitivity and offset at ΔT = 0, 5, 15, 30 and back, then −5, −15, −30 and back: of the sensor with the
/// electronics at its nominal temperature, then of the electronics with the sensor at its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TemperatureProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The sensors; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// What is heated and cooled, one after the other.
    #[serde(default = "both")]
    pub parts: Vec<HeatedPart>,
    /// The coil along which each sensor is turned; absent: its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil: Option<Axis>,
    /// Nominal temperature, degC.
    #[serde(default = "whole::<23>")]
    pub nominal_c: f64,
    /// Deviations from it in order, K.
    #[serde(default = "report")]
    pub deviations_k: Vec<f64>,
    /// Largest field, nT.
    #[serde(default = "whole::<50_000>")]
    pub to_nt: f64,
    /// Fields from −to to +to at each temperature.
    #[serde(default = "count::<11>")]
    pub steps: usize,
    /// While a temperature settles, read without drive so often, s; absent: not at all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub monitor_s: Option<f64>,
    /// Time constant with which an enclosure takes its temperature, s.
    #[serde(default = "whole::<300>")]
    pub enclosure_s: f64,
}

/// What is heated and cooled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum HeatedPart {
    /// The sensors.
    Sensor,
    /// The electronics.
    Electronics,
}

impl HeatedPart {
    fn name(self) -> &'static str {
        if self == HeatedPart::Sensor { "sensor" } else { "electronics" }
    }
}

fn both() -> Vec<HeatedPart> {
    vec![HeatedPart::Sensor, HeatedPart::Electronics]
}

fn report() -> Vec<f64> {
    vec![0.0, 5.0, 15.0, 30.0, 15.0, 5.0, 0.0, -5.0, -15.0, -30.0, -15.0, -5.0, 0.0]
}

impl Sequence for TemperatureProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("to_nt", self.to_nt), ("enclosure_s", self.enclosure_s)])?;
        positive(path, [("monitor_s", self.monitor_s.unwrap_or(1.0))])?;
        filled(path, "parts", &self.parts, "at least one entry")?;
        filled(path, "deviations_k", &self.deviations_k, "at least one entry")?;
        let settle = bench.timing.temperature_settle_s;
        if let Some(every) = self.monitor_s.filter(|every| *every > settle) {
            let found = format!("{every}, longer than the {settle} s of timing.temperature_settle_s");
            return Err(Error::document(format!("{path}.monitor_s"), found, "a shorter time, or no key"));
        }
        let sensors = bench.sensors(&self.sensors, path)?;
        for sensor in &sensors {
            bench.within(self.coil.unwrap_or(*sensor), self.to_nt, &format!("{path}.to_nt"))?;
        }
        let monitored = self.monitor_s.map_or(0.0, |step| settle / step);
        let rows = (self.steps as f64 + monitored) * self.deviations_k.len() as f64;
        samples(&format!("{path}.steps"), self.steps as f64, 2.0)?;
        Ok(samples(path, rows, 2.0)? * (self.parts.len() * sensors.len()) as f64)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let sensors = bench.sensors(&self.sensors, path)?;
        let mut planned = Vec::new();
        for part in &self.parts {
            planned.extend(sensors.iter().map(|sensor| self.run(bench, path, *part, *sensor)));
        }
        Ok(planned)
    }
}

impl TemperatureProcedure {
    fn run(&self, bench: &Bench<'_>, path: &str, part: HeatedPart, sensor: Axis) -> Planned {
        let coil = self.coil.unwrap_or(sensor);
        let id = format!("{}-{}-{sensor}", self.id, part.name());
        let mut aligned = bench.along(&id, sensor, coil, 0.0, 0.0);
        let mut reached = self.nominal_c;
        for deviation in &self.deviations_k {
            let target = self.nominal_c + deviation;
            self.settle(bench, part, reached, target, &mut aligned.rows);
            reached = target;
            for field in sweep(self.to_nt, self.steps) {
                let step = bench.set(format!("{} nT on coil {coil}", bare(field)), on(coil, field), 1);
                self.row(bench, part, target, step, &mut aligned.rows);
            }
        }
        aligned.recording(procedure::TEMPERATURE_RUN, id, path, &[coil])
    }

    /// Waits until a temperature is reached, with readings on the way where they are wanted.
    fn settle(&self, bench: &Bench<'_>, part: HeatedPart, from: f64, to: f64, rows: &mut Rows) {
        let wait = bench.timing.temperature_settle_s;
        let action = format!("{} to {} degC", part.name(), bare(to));
        let Some(every) = self.monitor_s else {
            return self.row(bench, part, to, Step::still(action, wait, 0, 0.0), rows);
        };
        let readings = (wait / every).floor() as usize;
        for reading in 1..=readings {
            let passed = reading as f64 * every;
            let temperature = to + (from - to) * (-passed / self.enclosure_s).exp();
            let length = if reading == readings { wait - passed } else { 0.0 };
            self.row(bench, part, temperature, Step::still(action.clone(), every, 1, length), rows);
        }
    }

    fn row(&self, bench: &Bench<'_>, part: HeatedPart, temperature: f64, step: Step, rows: &mut Rows) {
        let (sensor, electronics) = match part {
            HeatedPart::Sensor => (temperature, self.nominal_c),
            HeatedPart::Electronics => (self.nominal_c, temperature),
        };
        let more = [("sensor_temperature_c", sensor), ("electronics_temperature_c", electronics)];
        rows.step(Step { temperatures_c: Some([sensor, electronics]), ..step }, bench.timing, &more);
    }
}
