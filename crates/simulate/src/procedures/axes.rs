use common::number::{bare, vector};
use common::{Axis, Conditions, Error, Matrix3x3, Theodolite, TheodoliteAngle, procedure};
use nalgebra::{Matrix3, Vector3};
use noise::Stream;
use physics::frames::{self, ARCSEC};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::{Sequence, count};
use crate::bench::{Bench, deviation, filled, positive, samples};
use crate::planned::{Planned, Reads, Rows};

/// Turn the block through orientations and drive the coils in each: what the report's MAGSIM (one sensor, one
/// coil) and NEWSIM (three of each) did, with errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AxesProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The orientations.
    pub orientations: Orientations,
    /// Field of a named drive, nT.
    pub drive_nt: f64,
    /// The drives in each orientation.
    #[serde(default = "one_coil_after_the_other")]
    pub drives: Vec<Drive>,
    /// Readings of each drive.
    #[serde(default = "count::<1>")]
    pub repeats: usize,
    /// The sensors that are read; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// Write the theodolites' angles, not the matrix.
    #[serde(default)]
    pub theodolite_angles: bool,
    /// Readings of each of the theodolites' angles in an orientation; more than one is written as angles
    /// only.
    #[serde(default = "count::<1>")]
    pub theodolite_readings: usize,
    /// How far the fixture may miss its nominal orientation (standard deviation), arcmin.
    #[serde(default)]
    pub fixture_std_arcmin: f64,
    /// Drive with a sine; absent: with constant currents.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ac: Option<AcDrive>,
}

/// A sinusoidal drive of all coils in phase (NASA, "Errors in Magnetic Axis Orientation").
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AcDrive {
    /// Frequency, Hz.
    pub hz: f64,
    /// Cycles recorded.
    pub cycles: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Amplitude on the coils that a drive does not name, nT: the dither.
    #[serde(default)]
    pub dither_nt: f64,
}

/// Orientations by name or one by one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "\"cube\", \"nasa_table_3\", \"nasa_figure_9\", or a list of 3x3 rotations")]
pub enum Orientations {
    /// `cube` (24), `nasa_table_3` (7) or `nasa_figure_9` (its first four).
    Named(String),
    /// R, GEO -> SEN, each.
    List(Vec<Matrix3x3>),
}

/// A drive by name or as a vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "\"x\", \"-x\", \"zero\", or [x, y, z] in nT")]
pub enum Drive {
    /// `x`, `-x`, … at the procedure's field, or `zero`.
    Named(String),
    /// Field of each coil, nT.
    Vector([f64; 3]),
}

fn one_coil_after_the_other() -> Vec<Drive> {
    Axis::ALL.iter().map(|axis| Drive::Named(axis.to_string())).collect()
}

impl Sequence for AxesProcedure {
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error> {
        let path_of = |key: &str| format!("{path}.{key}");
        positive(path, [("drive_nt", self.drive_nt), ("repeats", self.repeats as f64)])?;
        positive(path, [("theodolite_readings", self.theodolite_readings as f64)])?;
        if self.theodolite_readings > 1 && !self.theodolite_angles {
            let found = format!("{} beside orientations as matrices", self.theodolite_readings);
            let expected = "1, or \"theodolite_angles\": true, by which each reading is written";
            return Err(Error::document(path_of("theodolite_readings"), found, expected));
        }
        deviation(path, "fixture_std_arcmin", self.fixture_std_arcmin)?;
        filled(path, "drives", &self.drives, "at least one drive")?;
        bench.sensors(&self.sensors, path)?;
        let settings = match &self.orientations {
            Orientations::Named(_) => 24.0,
            Orientations::List(list) => {
                filled(path, "orientations", list, "at least one orientation")?;
                list.len() as f64
            }
        };
        let rows = match &self.ac {
            None => self.repeats as f64,
            Some(ac) => self.samples(ac, path)?,
        };
        let dither = self.ac.as_ref().map_or(0.0, |ac| ac.dither_nt);
        for (index, (field, drive)) in self.drives(path)?.iter().zip(&self.drives).enumerate() {
            let key = match drive {
                Drive::Named(_) => path_of("drive_nt"),
                Drive::Vector(_) => path_of(&format!("drives[{index}]")),
            };
            for coil in Axis::ALL {
                bench.within(coil, field[coil.index()], &key)?;
                bench.within(coil, dither, &path_of("ac.dither_nt"))?;
            }
        }
        Ok(rows * settings * self.drives.len() as f64)
    }

    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error> {
        let mut planned = Vec::new();
        let drives = self.drives(path)?;
        let sensors = bench.sensors(&self.sensors, path)?;
        for (index, nominal) in self.rotations(path)?.into_iter().enumerate() {
            let (id, here) = (format!("{}-{}", self.id, index + 1), format!("{path}.orientations[{index}]"));
            let (rotation, conditions) = self.setting(bench, &id, nominal);
            let recording = |id: String, rows: Rows, conditions: Conditions| Planned {
                rotation,
                nominal,
                reads: Reads::Sensors(sensors.clone()),
                ..Planned::new(procedure::AXES_ORIENTATION, id, &here, conditions, rows, &Axis::ALL)
            };
            let turn = || self.turn(bench, index + 1);
            let Some(ac) = &self.ac else {
                let mut rows = turn();
                for drive in &drives {
                    let action = format!("drive {} nT", vector((*drive).into(), 0.0));
                    rows.step(bench.set(action, *drive, self.repeats), bench.timing, &[]);
                }
                planned.push(recording(id, rows, conditions));
                continue;
            };
            for (number, drive) in drives.iter().enumerate() {
                let amplitude = drive.map(|field| if field == 0.0 { ac.dither_nt } else { field });
                let mut rows = if number == 0 { turn() } else { Rows::new("same orientation", 0.0) };
                let action = format!("drive {} nT at {} Hz", vector(amplitude.into(), 0.0), bare(ac.hz));
                let mut step = bench.record(action, ac.cycles / ac.hz, 1.0 / ac.rate_hz);
                step.current_a = bench.currents(amplitude);
                let current = |t: f64| bench.currents(amplitude * (TAU * ac.hz * t).sin());
                rows.series(step, 1.0 / ac.rate_hz, current);
                let conditions = Conditions { drive_hz: Some(ac.hz), ..conditions.clone() };
                planned.push(recording(format!("{id}-{}", number + 1), rows, conditions));
            }
        }
        Ok(planned)
    }
}

impl AxesProcedure {
    fn samples(&self, ac: &AcDrive, path: &str) -> Result<f64, Error> {
        let path = format!("{path}.ac");
        positive(&path, [("hz", ac.hz), ("cycles", ac.cycles), ("rate_hz", ac.rate_hz)])?;
        let rows = samples(&path, ac.cycles / ac.hz * ac.rate_hz, 5.0)?;
        let zero = |drive: &Drive| matches!(drive, Drive::Named(name) if name == "zero");
        if self.repeats != 1 || self.drives.iter().any(zero) {
            let found = "repeats or a drive \"zero\" beside ac";
            return Err(Error::document(path, found, "neither; cycles repeat by themselves"));
        }
        Ok(rows)
    }

    /// The true rotation of a setting, and what the theodolites say of it.
    fn setting(&self, bench: &Bench<'_>, id: &str, nominal: Matrix3<f64>) -> (Matrix3<f64>, Conditions) {
        let mut stream = Stream::new(bench.seed, &format!("{id}/theodolite"));
        let mut vector = |std: f64| bench.random(&mut stream, std);
        let fixture = frames::small_rotation(&vector(self.fixture_std_arcmin * 60.0 * ARCSEC));
        let rotation = nominal * fixture;
        if self.theodolite_angles {
            let facility = bench.facility();
            let own = facility.and_then(|facility| facility.theodolite_arcsec).unwrap_or(0.0) * ARCSEC;
            let once = |_| {
                let [x, y] = [vector(own), vector(own)];
                [x.x, x.y, y.x, y.y]
            };
            let mut errors: Vec<[f64; 4]> = (0..self.theodolite_readings).map(once).collect();
            let shared = facility.and_then(|facility| facility.theodolite_shared_arcsec).unwrap_or(0.0);
            let mut stream = Stream::new(bench.seed, &format!("{id}/theodolite/shared"));
            let shared: [f64; 4] = std::array::from_fn(|_| stream.normal() * shared * ARCSEC);
            errors.iter_mut().for_each(|errors| errors.iter_mut().zip(shared).for_each(|(e, s)| *e += s));
            let angles = theodolite(&fixture, nominal, &errors);
            return (rotation, Conditions { theodolite: Some(angles), ..Conditions::default() });
        }
        let seen = frames::small_rotation(&vector(bench.theodolite_arcsec() * ARCSEC)) * rotation;
        (rotation, Conditions { orientation: Some(frames::rows(&seen)), ..Conditions::default() })
    }

    /// Turning the block, with the first reading of the theodolites, and reading them again.
    fn turn(&self, bench: &Bench<'_>, number: usize) -> Rows {
        let timing = bench.timing;
        let again = (self.theodolite_readings - 1) as f64 * timing.theodolite_s;
        Rows::new(format!("block to orientation {number}"), timing.orientation_s + again)
    }

    fn rotations(&self, path: &str) -> Result<Vec<Matrix3<f64>>, Error> {
        let path = format!("{path}.orientations");
        let nasa = |count: usize| NASA_TABLE_3.iter().take(count).map(frames::matrix).collect();
        match &self.orientations {
            Orientations::Named(name) => match name.as_str() {
                "cube" => Ok(frames::cube_rotations()),
                "nasa_table_3" => Ok(nasa(7)),
                "nasa_figure_9" => Ok(nasa(4)),
                _ => {
                    let expected =
                        "\"cube\", \"nasa_table_3\", \"nasa_figure_9\", or a list of 3x3 rotations";
                    Err(Error::document(path, format!("\"{name}\""), expected))
                }
            },
            Orientations::List(list) => frames::rotations(list, &path),
        }
    }

    /// The field along each coil for each drive, nT.
    fn drives(&self, path: &str) -> Result<Vec<Vector3<f64>>, Error> {
        let drive = |(index, drive): (usize, &Drive)| match drive {
            Drive::Vector(vector) => Ok(Vector3::from(*vector)),
            Drive::Named(name) if name == "zero" => Ok(Vector3::zeros()),
            Drive::Named(name) => {
                let (sign, letter) =
                    name.strip_prefix('-').map_or((1.0, name.as_str()), |letter| (-1.0, letter));
                let axis = Axis::ALL.into_iter().find(|axis| axis.letter() == letter).ok_or_else(|| {
                    let expected =
                        "\"x\", \"-x\", \"y\", \"-y\", \"z\", \"-z\", \"zero\", or [x, y, z] in nT";
                    Error::document(format!("{path}.drives[{index}]"), format!("\"{name}\""), expected)
                })?;
                Ok(Vector3::ith(axis.index(), sign * self.drive_nt))
            }
        };
        self.drives.iter().enumerate().map(drive).collect()
    }
}

/// What two theodolites read of the faces F: φx, θx, φy, θy, each reading with its error (NASA eq. 7 and 8).
fn theodolite(faces: &Matrix3<f64>, nominal: Matrix3<f64>, errors: &[[f64; 4]]) -> Theodolite {
    let angles = [
        faces[(0, 1)].atan2(faces[(0, 0)]),
        faces[(0, 2)].acos(),
        (-faces[(1, 0)]).atan2(faces[(1, 1)]),
        faces[(1, 2)].acos(),
    ];
    let read = |which: usize| match errors {
        [once] => TheodoliteAngle::Once(angles[which] + once[which]),
        all => TheodoliteAngle::Repeated(all.iter().map(|errors| angles[which] + errors[which]).collect()),
    };
    Theodolite {
        phi_x_rad: read(0),
        theta_x_rad: read(1),
        phi_y_rad: read(2),
        theta_y_rad: read(3),
        nominal_rotation: Some(frames::rows(&nominal)),
        extra: Default::default(),
    }
}

/// The seven orientations of NASA's Table 3; the four of figure 9 are its first ones (two quarter turns about
/// the azimuth axis, then one about the elevation axis).
const NASA_TABLE_3: [Matrix3x3; 7] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
    [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
    [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
];
