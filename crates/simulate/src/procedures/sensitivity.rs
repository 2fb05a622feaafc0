use common::number::bare;
use common::{Axis, Error, procedure};
use serde::{Deserialize, Serialize};

use super::{Sequence, count, whole};
use crate::bench::{Bench, deviation, filled, on, positive, samples, sweep};
use crate::planned::{Planned, Reads};

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

/// Sensitivity and offset of each sensor with a constant field across it: 0 and ±60 000 nT, or −60 000 to 60
/// 000 nT in steps of 20 000, on each of the two other coils.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CrossFieldProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The sensors; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// The coil along which each is turned; absent: its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil: Option<Axis>,
    /// The coils across it; absent: both others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<Vec<Axis>>,
    /// Quarters of a turn of the block about the sensor: with 1 one strong coil reaches the other side of the
    /// sensor, with 0.5 both sides at once, which alone shows the mixed term.
    #[serde(default)]
    pub quarter_turns: f64,
    /// Whether the other sensors of the block are read as well: with them the fields across are known without
    /// the drive.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub all_sensors: bool,
    /// Fields across, nT.
    #[serde(default = "report")]
    pub levels_nt: Vec<f64>,
    /// Largest field along the sensor, nT.
    #[serde(default = "whole::<50_000>")]
    pub to_nt: f64,
    /// Fields from −to to +to at each level.
    #[serde(default = "count::<11>")]
    pub steps: usize,
}

fn report() -> Vec<f64> {
    vec![0.0, 60_000.0, -60_000.0]
}

impl CrossFieldProcedure {
    /// The coils across a coil.
    fn across(&self, coil: Axis, path: &str) -> Result<Vec<Axis>, Error> {
        let others = || Axis::ALL.into_iter().filter(|axis| *axis != coil).collect();
        let across = self.across.clone().unwrap_or_else(others);
        if across.is_empty() || across.contains(&coil) {
            let found = format!("{across:?} across coil {coil}").to_lowercase();
            return Err(Error::document(format!("{path}.across"), found, "the other coils, at least one"));
        }
        Ok(across)
    }
}

impl Sequence for CrossFieldProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        positive(path, [("to_nt", self.to_nt)])?;
        filled(path, "levels_nt", &self.levels_nt, "at least one transverse field")?;
        let steps = samples(&format!("{path}.steps"), self.steps as f64, 2.0)?;
        let mut rows = 0.0;
        for sensor in bench.sensors(&self.sensors, path)? {
            let coil = self.coil.unwrap_or(sensor);
            bench.within(coil, self.to_nt, &format!("{path}.to_nt"))?;
            for across in self.across(coil, path)? {
                for (index, level) in self.levels_nt.iter().enumerate() {
                    bench.within(across, *level, &format!("{path}.levels_nt[{index}]"))?;
                }
                rows += steps * self.levels_nt.len() as f64;
            }
        }
        Ok(rows)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let mut planned = Vec::new();
        for sensor in bench.sensors(&self.sensors, path)? {
            let coil = self.coil.unwrap_or(sensor);
            for across in self.across(coil, path)? {
                let id = format!("{}-{sensor}-{across}", self.id);
                let mut aligned = bench.along(&id, sensor, coil, 0.0, self.quarter_turns);
                for level in &self.levels_nt {
                    let beside = format!("{} nT on coil {across}", bare(*level));
                    for field in sweep(self.to_nt, self.steps) {
                        let action = format!("{} nT on coil {coil}, {beside}", bare(field));
                        let step = bench.set(action, on(coil, field) + on(across, *level), 1);
                        aligned.rows.step(step, bench.timing, &[]);
                    }
                }
                let mut coils = [coil, across];
                coils.sort();
                let mut recording = aligned.recording(procedure::CROSS_FIELD, id, path, &coils);
                if self.all_sensors {
                    recording.reads = Reads::Sensors(bench.sensors(&None, path)?);
                }
                planned.push(recording);
            }
        }
        Ok(planned)
    }
}
