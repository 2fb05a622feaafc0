//! A real recording as a host: the document that diagnose gets, and the campaign in which an effect can act.

use concealed::base;
use concealed::scene::{AXES, Attitude, Bench, Campaign, Readings, Run, SceneKind, World};
use concealed::signal::{Signal, held};
use nalgebra::Matrix3;
use recorded::Series;
use serde_json::{Value, json};
use std::sync::Arc;

use crate::between;
use crate::hosts::Candidate;
use crate::length::{longer, without_plane};
use crate::matrix::matrix;
use crate::stats::{mean, rms};

/// What diagnose can see of a host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watched {
    /// Each sensor: beside another vector magnetometer, or with nothing to feel but a level.
    Vectors,
    /// The length of the vector alone, beside a scalar magnetometer.
    Length,
}

/// Temperatures that are not recorded are taken as held at this one, degC.
const ROOM_C: f64 = 20.0;

/// A real recording.
#[derive(Clone)]
pub struct Host {
    /// Where it comes from.
    pub candidate: &'static Candidate,
    /// What diagnose gets, its title apart.
    pub document: Value,
    /// What an effect acts in: fields and temperatures are interpolants of what was recorded.
    pub campaign: Campaign,
    /// The same with the field's mean taken off: what is left by a fit is the same, and its sums keep their
    /// digits.
    pub centred: Campaign,
    /// What was recorded, nT.
    pub plain: Readings,
    /// What diagnose can see.
    pub watched: Watched,
    /// Whether the field that the sensors feel is known as it moves.
    pub moves: bool,
    /// Rms of what the basic model leaves of the recording as it came, nT, over all that is seen.
    pub scatter_nt: f64,
}

impl Host {
    /// A host of columns: `reference_*_nt` with `test_*_nt`, or `sensor_*_nt` with `ambient_*_nt`, with
    /// `reference_nt` or alone; None where there are no readings, or too few rows for the constants.
    pub fn of(candidate: &'static Candidate, series: &Series) -> Option<Self> {
        let pair = series.holds("test_x_nt");
        let length = !pair && series.holds("reference_nt");
        let ambient = !pair && series.holds("ambient_x_nt");
        let quantity = if pair { "test" } else { "sensor" };
        if series.rows() < 100 || !series.holds(&format!("{quantity}_z_nt")) {
            return None;
        }
        let column = |quantity: &str, k: usize| series.column(&format!("{quantity}_{}_nt", AXES[k])).to_vec();
        let readings = [0, 1, 2].map(|k| column(quantity, k));
        let times = series.column("time_s").to_vec();
        let mut bench = Bench {
            coil_nt_per_a: [1.0; 3],
            eta: Matrix3::identity(),
            mu: Matrix3::identity(),
            sensitivity: [1.0; 3],
            offset_nt: candidate.offset_nt,
        };
        let fields: [Vec<f64>; 3] = if pair {
            (bench.eta, bench.offset_nt) = matrix(series)?;
            [0, 1, 2].map(|k| column("reference", k))
        } else if ambient {
            [0, 1, 2].map(|k| column("ambient", k))
        } else if length {
            [0, 1, 2].map(|k| readings[k].iter().map(|value| value + bench.offset_nt[k]).collect())
        } else {
            // What the field is nobody knows; the level is taken as what it is, and the offset takes it away.
            let levels = [0, 1, 2].map(|k| mean(&readings[k]));
            bench.offset_nt = levels.map(|level| -level);
            levels.map(|level| vec![level; times.len()])
        };
        let campaign = campaign(series, &times, bench, &fields, pair, candidate.code_nt);
        let centre = [0, 1, 2].map(|k| mean(&fields[k]));
        let about = [0, 1, 2].map(|k| fields[k].iter().map(|value| value - centre[k]).collect());
        let mut centred = campaign.clone();
        centred.runs[0].world = world(pair, &times, &about);
        let procedure = if pair { "differential" } else { "free_run" };
        let mut recording = series.recording("run", procedure);
        if ambient {
            recording["conditions"] = json!({"orientation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]});
        }
        let document = json!({
            "fluxcal": 1,
            "calibration": calibration(&campaign.bench, pair),
            "recordings": [recording],
        });
        let mut host = Self {
            candidate,
            document,
            campaign,
            centred,
            plain: vec![readings],
            watched: if length { Watched::Length } else { Watched::Vectors },
            moves: pair || length || ambient,
            scatter_nt: f64::NAN,
        };
        let residual = host.residual(series);
        let squares = residual.iter().map(|column| rms(column).powi(2)).sum::<f64>();
        host.scatter_nt = (squares / residual.len() as f64).sqrt();
        Some(host)
    }

    /// What the basic model leaves of the recording as it came.
    fn residual(&self, series: &Series) -> Vec<Vec<f64>> {
        match self.watched {
            Watched::Length => {
                let length = |row: usize| {
                    let part = |k: usize| self.plain[0][k][row] + self.campaign.bench.offset_nt[k];
                    (part(0).powi(2) + part(1).powi(2) + part(2).powi(2)).sqrt()
                };
                let reference = series.column("reference_nt").iter().enumerate();
                let off: Vec<f64> = reference.map(|(row, scalar)| length(row) - scalar).collect();
                vec![without_plane(&self.plain[0], &off)]
            }
            Watched::Vectors => self.left(&self.plain),
        }
    }

    /// What is left of `added` when all constants of the basic model are fitted to it, nT, sensor by sensor;
    /// of what is held against a scalar magnetometer one column, the change of the vector's length less a
    /// level and slopes along the three readings, which is all that nine constants do where the field points
    /// one way.
    pub fn left(&self, added: &Readings) -> Vec<Vec<f64>> {
        match self.watched {
            Watched::Vectors => base::left(&self.centred, added).into_iter().flatten().collect(),
            Watched::Length => {
                let longer = longer(&self.plain[0], self.campaign.bench.offset_nt, &added[0]);
                vec![without_plane(&self.plain[0], &longer)]
            }
        }
    }

    /// The measure of sizes: rms of what is left of `added` in the sensor that keeps most of it, nT.
    pub fn size(&self, added: &Readings) -> f64 {
        self.left(added).iter().map(|column| rms(column)).fold(0.0, f64::max)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.plain[0][0].len()
    }

    /// Readings that count: of a length one a row, else three.
    pub fn readings(&self) -> usize {
        if self.watched == Watched::Length { self.rows() } else { 3 * self.rows() }
    }

    /// The name of the columns to which an effect is added.
    pub fn column(&self, sensor: usize) -> String {
        let quantity = if self.campaign.kind == SceneKind::Pair { "test" } else { "sensor" };
        format!("{quantity}_{}_nt", AXES[sensor])
    }

    /// How the mean field points, as what a nT in each sensor adds to the length.
    pub fn along(&self) -> [f64; 3] {
        let field = [0, 1, 2].map(|k| mean(&self.plain[0][k]) + self.campaign.bench.offset_nt[k]);
        let length = field.iter().map(|part| part * part).sum::<f64>().sqrt();
        field.map(|part| part / length)
    }
}

fn world(pair: bool, times: &[f64], fields: &[Vec<f64>; 3]) -> World {
    let signals = [0, 1, 2].map(|k| between::signal(times, &fields[k]));
    if pair { World::Pair(signals) } else { World::Natural(signals) }
}

fn campaign(
    series: &Series,
    times: &[f64],
    bench: Bench,
    fields: &[Vec<f64>; 3],
    pair: bool,
    code_nt: f64,
) -> Campaign {
    let names = ["sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c"];
    let temperature = |name: &str| -> (Signal, f64) {
        match series.column(name) {
            [] => (held(ROOM_C), ROOM_C),
            values => (between::signal(times, values), mean(values)),
        }
    };
    let temperatures = names.map(temperature);
    let attitude: Attitude = Arc::new(|_| Matrix3::identity());
    let run = Run {
        id: "run".into(),
        times: times.to_vec(),
        world: world(pair, times, fields),
        attitude,
        still: true,
        temperatures: temperatures.each_ref().map(|(signal, _)| signal.clone()),
        columns: Vec::new(),
    };
    let reference_c = temperatures.each_ref().map(|(_, mean)| *mean);
    let kind = if pair { SceneKind::Pair } else { SceneKind::Site };
    Campaign { bench, runs: vec![run], reference_c, code_nt, kind, apart: true }
}

fn calibration(bench: &Bench, pair: bool) -> Value {
    let offsets = |nt: fn(f64) -> Value| -> Value {
        AXES.iter().zip(bench.offset_nt).map(|(axis, offset)| (axis.to_string(), nt(offset))).collect()
    };
    if pair {
        let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| bench.eta[(i, j)]));
        return json!({"differential": {"matrix": rows, "offset_nt": offsets(|nt| json!(nt))}});
    }
    json!({"sensors": offsets(|nt| json!({"offset_nt": nt}))})
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{Beside, CANDIDATE, series};

    /// Noise even over a tenth of a nT has 0.1/√12 rms; of a pair both have it, of a length the field's
    /// direction weighs it.
    #[test]
    fn the_scatter_is_what_the_basic_model_leaves() {
        let one = 0.1 / 12.0_f64.sqrt();
        for (beside, wanted) in [
            (Beside::Vector, one * 2.0_f64.sqrt()),
            (Beside::Scalar, one * 2.0_f64.sqrt()),
            (Beside::Thermometer, one),
        ] {
            let host = Host::of(&CANDIDATE, &series(&beside)).expect("a host");
            assert!((host.scatter_nt / wanted - 1.0).abs() < 0.05, "{} for {wanted}", host.scatter_nt);
        }
    }

    #[test]
    fn a_few_rows_or_no_readings_make_no_host() {
        let short = series(&Beside::Scalar).filter(|row| row < 50);
        assert!(Host::of(&CANDIDATE, &short).is_none());
        assert!(Host::of(&CANDIDATE, &Series::default()).is_none());
    }
}
