//! What is recorded: an instrument, its facility, and runs whose drives, temperatures and fields are known at
//! every instant.

use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

use crate::signal::Signal;

/// Letters of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// How the block stands: GEO to SEN at a time.
pub type Attitude = Arc<dyn Fn(f64) -> Matrix3<f64> + Send + Sync>;

/// What is true of the instrument and of the facility.
#[derive(Clone, Debug)]
pub struct Bench {
    /// nT for an ampere, each coil.
    pub coil_nt_per_a: [f64; 3],
    /// Columns: the coils' axes in GEO; of a pair η of test = R η + d.
    pub eta: Matrix3<f64>,
    /// Columns: the sensors' axes in SEN.
    pub mu: Matrix3<f64>,
    /// nT for a nT of reading, each sensor.
    pub sensitivity: [f64; 3],
    /// nT, each sensor; of a pair d.
    pub offset_nt: [f64; 3],
}

/// The field of a run.
#[derive(Clone)]
pub enum World {
    /// Currents in the coils, A, the natural field nulled.
    Coils([Signal; 3]),
    /// The natural field, GEO, nT.
    Natural([Signal; 3]),
    /// The natural field as the reference of a pair reads it, nT.
    Pair([Signal; 3]),
}

/// One recording.
#[derive(Clone)]
pub struct Run {
    /// Its neutral name.
    pub id: String,
    /// Moments of its readings on the campaign's clock, s.
    pub times: Vec<f64>,
    /// What the sensors feel.
    pub world: World,
    /// How the block stands.
    pub attitude: Attitude,
    /// Whether it stands still.
    pub still: bool,
    /// Temperatures of sensor, electronics and coil, degC.
    pub temperatures: [Signal; 3],
    /// Further columns by name; those that are switched are rounded.
    pub columns: Vec<(String, Signal)>,
}

impl Run {
    /// The field, GEO, nT.
    pub fn field_geo(&self, bench: &Bench, t: f64) -> Vector3<f64> {
        match &self.world {
            World::Coils(current) => {
                bench.eta * Vector3::from_fn(|k, _| bench.coil_nt_per_a[k] * current[k](t))
            }
            World::Natural(field) | World::Pair(field) => Vector3::from_fn(|k, _| field[k](t)),
        }
    }

    /// The field in the block, SEN, nT.
    pub fn field_sen(&self, bench: &Bench, t: f64) -> Vector3<f64> {
        (self.attitude)(t) * self.field_geo(bench, t)
    }

    /// The field along a sensor, nT.
    pub fn along(&self, bench: &Bench, sensor: usize, t: f64) -> f64 {
        self.sensor_axis(bench, sensor).dot(&self.field_sen(bench, t))
    }

    /// The direction of a sensor, SEN; of a pair the row of its response to the reference.
    pub fn sensor_axis(&self, bench: &Bench, sensor: usize) -> Vector3<f64> {
        match self.world {
            World::Pair(_) => bench.eta.column(sensor).into(),
            _ => bench.mu.column(sensor).into(),
        }
    }

    /// A field in GEO as the three sensors read it, nT.
    pub fn geo_to_sensors(&self, bench: &Bench, t: f64, geo: &Vector3<f64>) -> [f64; 3] {
        let sen = (self.attitude)(t) * geo;
        std::array::from_fn(|sensor| self.sensor_axis(bench, sensor).dot(&sen))
    }

    /// The current of a coil, where there are coils.
    pub fn current(&self, coil: usize) -> Option<&Signal> {
        match &self.world {
            World::Coils(current) => Some(&current[coil]),
            _ => None,
        }
    }

    /// Time from one reading to the next.
    pub fn step_s(&self) -> f64 {
        match self.times[..] {
            [first, second, ..] => second - first,
            _ => 1.0,
        }
    }

    /// A further column.
    pub fn column(&self, name: &str) -> Option<&Signal> {
        self.columns.iter().find(|(own, _)| own == name).map(|(_, signal)| signal)
    }

    /// The field along a sensor at every instant.
    pub fn along_signal(&self, bench: &Bench, sensor: usize) -> Signal {
        let (run, bench) = (self.clone(), bench.clone());
        Arc::new(move |t| run.along(&bench, sensor, t))
    }
}

/// A campaign: the instrument and its runs.
#[derive(Clone)]
pub struct Campaign {
    /// What is true.
    pub bench: Bench,
    /// The recordings.
    pub runs: Vec<Run>,
    /// Temperatures at which the calibration holds, degC: sensor, electronics, coil.
    pub reference_c: [f64; 3],
    /// Width of a code, nT.
    pub code_nt: f64,
    /// How the recordings are made, in a word.
    pub kind: SceneKind,
    /// Whether the two thermometers go apart.
    pub apart: bool,
}

/// Ways to record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneKind {
    /// Three runs in different orientations under slow drives, temperatures up and down.
    Coils,
    /// One run under drives of some Hz, read fast.
    Fast,
    /// The coils held, read hundreds of times a second.
    Held,
    /// A day or less at a site, the outside field, tilts, one orientation.
    Site,
    /// On board: the natural field under changing attitude, arrays, Sun and eclipse.
    Craft,
    /// Two magnetometers in the natural field.
    Pair,
}

impl SceneKind {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            SceneKind::Coils => "three runs in coils",
            SceneKind::Fast => "a fast run in coils",
            SceneKind::Held => "coils held, read fast",
            SceneKind::Site => "a site",
            SceneKind::Craft => "on board",
            SceneKind::Pair => "a pair",
        }
    }
}

/// What is read, nT, run by run, sensor by sensor, row by row.
pub type Readings = Vec<[Vec<f64>; 3]>;

impl Campaign {
    /// What a unit of a sensor's reading means, nT.
    pub fn reading_nt(&self, sensor: usize) -> f64 {
        let pair = self.runs.iter().any(|run| matches!(run.world, World::Pair(_)));
        if pair { 1.0 } else { self.bench.sensitivity[sensor] }
    }

    /// What the sensors' converters get without noise and without anything concealed, B − O, nT.
    pub fn plain(&self) -> Readings {
        self.runs.iter().map(|run| self.plain_run(run)).collect()
    }

    fn plain_run(&self, run: &Run) -> [Vec<f64>; 3] {
        std::array::from_fn(|sensor| {
            let pair = matches!(run.world, World::Pair(_));
            // T = R η + d adds the offset, B = k M + O takes it away.
            let offset = if pair { -self.bench.offset_nt[sensor] } else { self.bench.offset_nt[sensor] };
            run.times.iter().map(|t| run.along(&self.bench, sensor, *t) - offset).collect()
        })
    }
}
