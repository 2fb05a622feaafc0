//! What a design begins with: what the facility and the instrument err by, and how long things take.

use common::{Axis, Matrix3x3, Noise};
use nalgebra::{DMatrix, Matrix3, Vector3};
use physics::frames::{ARCSEC, face_uncertainty};
use serde::{Deserialize, Serialize};

use super::information::{Information, Pieces, Readings, TURNS};
use crate::means;

/// What is as good as unknown: relative scales and fields, nT.
const UNKNOWN: (f64, f64) = (1.0, 1e4);

/// Errors of facility and instrument.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Given {
    /// Largest field of each coil, nT.
    pub coil_nt: [f64; 3],
    /// Noise of a reading of each sensor.
    pub noise: [Noise; 3],
    /// Noise of each component of the field in the coils.
    pub field_noise: Noise,
    /// Width of one code of the converter, nT.
    pub quantisation_nt: f64,
    /// Standard uncertainty of one theodolite reading, arcsec.
    pub theodolite_arcsec: f64,
    /// Of what the readings of one angle in one setting have in common, arcsec.
    pub theodolite_shared_arcsec: f64,
    /// Of each coil's constant, relative.
    pub coil_relative: [f64; 3],
    /// Of each sensor's sensitivity, relative.
    pub sensor_relative: [f64; 3],
    /// Of each component of the field that nulling leaves, nT; absent: the readings have to show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual_field_nt: Option<f64>,
    /// Of each sensor's offset, nT; absent: the readings have to show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_nt: Option<f64>,
    /// Of each coil's gradient, as a share of its field for each metre.
    pub gradient_per_m: [f64; 3],
    /// Places of the sensors in SEN, m.
    pub positions_m: [[f64; 3]; 3],
    pub times: Times,
}

/// How long things take at the facility, as `timing` of a plan says, with simulate's defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Times {
    /// Turning the block to another orientation and reading the theodolites once, s.
    pub orientation_s: f64,
    /// Reading the theodolites once more, s.
    pub theodolite_s: f64,
    /// From a change of the drive to the first reading, s.
    #[serde(rename(deserialize = "field_settle_s"))]
    pub settle_s: f64,
    /// One reading, s.
    pub reading_s: f64,
    /// One level of temperature, s.
    #[serde(rename(deserialize = "temperature_settle_s"))]
    pub temperature_s: f64,
    /// Levels of temperature, of all sensors and parts together; those of the plan's procedures.
    #[serde(skip_deserializing)]
    pub temperature_levels: usize,
}

impl Default for Times {
    fn default() -> Self {
        Self {
            orientation_s: 900.0,
            theodolite_s: 180.0,
            settle_s: 10.0,
            reading_s: 1.0,
            temperature_s: 1800.0,
            temperature_levels: 0,
        }
    }
}

/// What is recorded in each setting of the block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Setting {
    /// Readings of each theodolite angle.
    pub theodolite_readings: usize,
    /// How often the drives are gone through.
    pub cycles: usize,
    /// How often, in each, the weakest coil is driven in both senses; the others once.
    pub weakest_coil: usize,
    /// Readings of each drive.
    pub readings: usize,
}

impl Given {
    pub fn weakest(&self) -> usize {
        (0..3).min_by(|a, b| self.coil_nt[*a].total_cmp(&self.coil_nt[*b])).unwrap_or(0)
    }

    /// The drives of a setting: each coil as far as it goes, in both senses, one after the other.
    pub fn drives(&self, setting: &Setting) -> Vec<Vector3<f64>> {
        let pair = |coil: usize| {
            let times = if coil == self.weakest() { setting.weakest_coil } else { 1 };
            let both = [1.0, -1.0].map(|sign| Vector3::ith(coil, sign * self.coil_nt[coil]));
            std::iter::repeat_n(both, times).flatten()
        };
        (0..setting.cycles).flat_map(|_| (0..3).flat_map(pair)).collect()
    }

    pub fn readings(&self, setting: &Setting) -> Readings {
        let drives_nt = self.drives(setting);
        let first = self.covariance(setting, &drives_nt, &self.noise[0]);
        let of = |sensor: Axis| match &self.noise[sensor.index()] {
            noise if *noise == self.noise[0] => first.clone(),
            noise => self.covariance(setting, &drives_nt, noise),
        };
        Readings {
            covariance: Axis::ALL.map(of),
            drives_nt,
            gradient_per_m: self.gradient_per_m,
            positions_m: self.positions_m.map(Vector3::from),
        }
    }

    /// Covariance of a sensor's mean readings of the drives, as axescal makes it of a recording.
    pub fn covariance(&self, setting: &Setting, drives_nt: &[Vector3<f64>], noise: &Noise) -> DMatrix<f64> {
        let Times { settle_s, reading_s, .. } = self.times;
        let each_s = settle_s + setting.readings as f64 * reading_s;
        let time =
            |drive: usize, reading: usize| drive as f64 * each_s + settle_s + reading as f64 * reading_s;
        let rows = || {
            (0..drives_nt.len()).flat_map(|drive| (0..setting.readings).map(move |reading| (drive, reading)))
        };
        let times: Vec<f64> = rows().map(|(drive, reading)| time(drive, reading)).collect();
        let driven: Vec<Vector3<f64>> = rows().map(|(drive, _)| drives_nt[drive]).collect();
        let noises = [noise, &self.field_noise];
        let together = means::means(&noises, Some(&times), &driven, self.quantisation_nt, |_| true);
        match together {
            Some((_, covariance)) => covariance,
            None => {
                let white = noises.into_iter().filter_map(|noise| noise.white_rms_nt).fold(0.0, f64::hypot);
                let single = (white * white + self.quantisation_nt.powi(2) / 12.0) / setting.readings as f64;
                DMatrix::identity(drives_nt.len(), drives_nt.len()) * single
            }
        }
    }

    /// What a setting says in each orientation, with theodolites that are still to be given.
    pub fn pieces(&self, candidates: &[Matrix3<f64>], setting: &Setting) -> Vec<Pieces> {
        let readings = self.readings(setting);
        candidates.iter().map(|rotation| Pieces::of(rotation, &faces(rotation), &readings)).collect()
    }

    /// Standard uncertainty of the mean of the theodolites' readings, rad.
    pub fn theodolite_rad(&self, readings: usize) -> f64 {
        self.theodolite_shared_arcsec.hypot(self.theodolite_arcsec / (readings as f64).sqrt()) * ARCSEC
    }

    pub fn has_memory(&self) -> bool {
        self.noise.iter().chain([&self.field_noise]).any(means::has_memory)
    }

    pub fn with_noise(&self, change: fn(&mut Noise)) -> Self {
        let mut given = self.clone();
        given.noise.iter_mut().chain([&mut given.field_noise]).for_each(change);
        given
    }

    /// What is known of scales, residual field and offsets beforehand.
    pub fn prior(&self) -> Information {
        let mut prior = Information::zeros();
        let std = |k: usize| match k {
            0..3 => known(self.sensor_relative[k], UNKNOWN.0),
            3..6 => known(self.coil_relative[k - 3], UNKNOWN.0),
            6..9 => self.residual_field_nt.map_or(UNKNOWN.1, |std| known(std, UNKNOWN.1)),
            _ => self.offset_nt.map_or(UNKNOWN.1, |std| known(std, UNKNOWN.1)),
        };
        (0..12).for_each(|k| prior[(TURNS + k, TURNS + k)] = 1.0 / std(k).powi(2));
        prior
    }

    /// Time of a setting at the facility, h: turning the block, reading the theodolites again, the drives.
    pub fn hours(&self, setting: &Setting) -> [f64; 3] {
        let Times { orientation_s, theodolite_s, settle_s, reading_s, .. } = self.times;
        let drives = (setting.cycles * (4 + 2 * setting.weakest_coil)) as f64;
        [
            orientation_s,
            (setting.theodolite_readings - 1) as f64 * theodolite_s,
            drives * (settle_s + setting.readings as f64 * reading_s),
        ]
        .map(|seconds| seconds / 3600.0)
    }
}

/// A standard uncertainty that is neither zero, which no sum of information can hold, nor more than unknown.
fn known(std: f64, unknown: f64) -> f64 {
    std.clamp(1e-9 * unknown, unknown)
}

/// How the theodolites' face frame errs, where each angle errs by 1 rad and the fixture stands as meant.
pub fn faces(rotation: &Matrix3<f64>) -> Matrix3<f64> {
    rotation * face_uncertainty([1.0; 4])
}

/// Some of the candidates, as JSON writes them.
pub fn listed(candidates: &[Matrix3<f64>], which: &[usize]) -> Vec<Matrix3x3> {
    which.iter().map(|one| physics::frames::rows(&candidates[*one])).collect()
}
