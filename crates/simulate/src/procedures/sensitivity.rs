use common::number::bare;
use common::{Axis, Error, procedure};
use serde::{Deserialize, Serialize};

use super::{Sequence, count, whole};
use crate::bench::{Bench, deviation, on, positive, samples, sweep};
use crate::planned::Planned;

/// Readings of each sensor, turned along a coil, against the coil's field: 101 steps of 1 000 nT over ±50 000
/// nT.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SensitivityProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The sensors; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// The coil along which each is turned; absent: its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil: Option<Axis>,
    /// Largest field, nT.
    #[serde(default = "whole::<50_000>")]
    pub to_nt: f64,
    /// Fields from −to to +to.
    #[serde(default = "count::<101>")]
    pub steps: usize,
    /// Readings of each.
    #[serde(default = "count::<1>")]
    pub repeats: usize,
    /// How far the sensor may miss the coil's direction after adjustment (standard deviation), arcmin.
    #[serde(default)]
    pub alignment_std_arcmin: f64,
    /// Record the natural field outside beside.
    #[serde(default)]
    pub outside: bool,
}

impl Sequence for SensitivityProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("to_nt", self.to_nt), ("repeats", self.repeats as f64)])?;
        deviation(path, "alignment_std_arcmin", self.alignment_std_arcmin)?;
        let sensors = bench.sensors(&self.sensors, path)?;
        for sensor in &sensors {
            bench.within(self.coil.unwrap_or(*sensor), self.to_nt, &format!("{path}.to_nt"))?;
        }
        let rows = samples(&format!("{path}.steps"), self.steps as f64 * self.repeats as f64, 2.0)?;
        Ok(rows * sensors.len() as f64)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let of = |sensor: Axis| {
            let coil = self.coil.unwrap_or(sensor);
            let id = format!("{}-{sensor}", self.id);
            let mut aligned = bench.along(&id, sensor, coil, self.alignment_std_arcmin, 0.0);
            for field in sweep(self.to_nt, self.steps) {
                let action = format!("{} nT on coil {coil}", bare(field));
                let step = bench.set(action, on(coil, field), self.repeats);
                aligned.rows.step(step, bench.timing, &[]);
            }
            let recording = aligned.recording(procedure::SENSOR_SENSITIVITY, id, path, &[coil]);
            Planned { outside: self.outside, ..recording }
        };
        Ok(bench.sensors(&self.sensors, path)?.into_iter().map(of).collect())
    }
}
