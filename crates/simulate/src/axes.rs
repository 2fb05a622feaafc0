//! The axes procedure: what the report's MAGSIM (one sensor, one coil) and NEWSIM (three of each) did,
//! with errors.

use common::{Axis, Column, Columns, Conditions, Error, Matrix3x3, Recording, Theodolite, procedure};
use nalgebra::{Matrix3, Vector3};
use physics::frames::{self, ARCSEC};

use crate::noise::Stream;
use crate::plan::{AxesProcedure, Drive, Orientations};

/// A recording without its readings, and the orientation in which it is truly made.
pub struct Planned {
    pub recording: Recording,
    pub rotation: Matrix3<f64>,
    /// JSON path in the plan.
    pub path: String,
    /// The sensors that are read.
    pub sensors: Vec<Axis>,
}

/// The settings of every recording. `currents` turns a field along each coil, nT, into the current that
/// the operator sets.
pub fn plan(
    axes: &AxesProcedure,
    path: &str,
    seed: u64,
    theodolite_arcsec: f64,
    sensors: &[Axis],
    currents: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> Result<Vec<Planned>, Error> {
    let mut planned = Vec::new();
    let drives = drives(axes, path)?;
    for (index, nominal) in orientations(&axes.orientations, path)?.into_iter().enumerate() {
        let id = format!("{}-{}", axes.id, index + 1);
        let mut stream = Stream::new(seed, &format!("{id}/theodolite"));
        let mut vector = |std: f64| Vector3::from_fn(|_, _| stream.normal() * std);
        let fixture = frames::small_rotation(&vector(axes.fixture_std_arcmin * 60.0 * ARCSEC));
        let sigma = theodolite_arcsec * ARCSEC;
        let (rotation, mut conditions) = if axes.theodolite_angles {
            let errors = [vector(sigma), vector(sigma)];
            let angles = theodolite(&fixture, nominal, errors);
            (nominal * fixture, Conditions { theodolite: Some(angles), ..Conditions::default() })
        } else {
            let rotation = nominal * fixture;
            let seen = frames::small_rotation(&vector(sigma)) * rotation;
            (rotation, Conditions { orientation: Some(frames::rows(&seen)), ..Conditions::default() })
        };
        let orientation_path = format!("{path}.orientations[{index}]");
        let recording = |id: String, conditions: Conditions, columns: Columns| Planned {
            recording: Recording {
                id,
                procedure: procedure::AXES_ORIENTATION.into(),
                conditions,
                columns,
                ..Recording::default()
            },
            rotation,
            path: orientation_path.clone(),
            sensors: sensors.to_vec(),
        };
        match &axes.ac {
            None => {
                let rows = drives.iter().flat_map(|drive| std::iter::repeat_n(*drive, axes.repeats));
                let columns = coil_columns(rows.map(&currents));
                planned.push(recording(id, conditions, columns));
            }
            Some(ac) => {
                conditions.drive_hz = Some(ac.hz);
                let rows = (ac.cycles / ac.hz * ac.rate_hz).round() as usize;
                let times: Vec<f64> = (0..rows).map(|row| row as f64 / ac.rate_hz).collect();
                for (number, drive) in drives.iter().enumerate() {
                    let amplitude = drive.map(|field| if field == 0.0 { ac.dither_nt } else { field });
                    let sines = times.iter().map(|t| (std::f64::consts::TAU * ac.hz * t).sin());
                    let mut columns = Columns::from_iter([("time_s".to_string(), Column(times.clone()))]);
                    columns.extend(coil_columns(sines.map(|sine| currents(amplitude * sine))));
                    planned.push(recording(format!("{id}-{}", number + 1), conditions.clone(), columns));
                }
            }
        }
    }
    Ok(planned)
}

fn coil_columns(currents: impl Iterator<Item = Vector3<f64>>) -> Columns {
    let currents: Vec<Vector3<f64>> = currents.collect();
    Axis::ALL
        .into_iter()
        .map(|axis| (format!("coil_{axis}_a"), Column(currents.iter().map(|c| c[axis.index()]).collect())))
        .collect()
}

/// What two theodolites read of the faces F, each angle with its error (NASA eq. 7 and 8).
fn theodolite(faces: &Matrix3<f64>, nominal: Matrix3<f64>, errors: [Vector3<f64>; 2]) -> Theodolite {
    Theodolite {
        phi_x_rad: faces[(0, 1)].atan2(faces[(0, 0)]) + errors[0].x,
        theta_x_rad: faces[(0, 2)].acos() + errors[0].y,
        phi_y_rad: (-faces[(1, 0)]).atan2(faces[(1, 1)]) + errors[1].x,
        theta_y_rad: faces[(1, 2)].acos() + errors[1].y,
        nominal_rotation: Some(frames::rows(&nominal)),
        extra: Default::default(),
    }
}

/// The seven orientations of NASA's Table 3.
const NASA_TABLE_3: [Matrix3x3; 7] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
    [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
    [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]],
];

fn orientations(given: &Orientations, path: &str) -> Result<Vec<Matrix3<f64>>, Error> {
    match given {
        Orientations::Named(name) if name == "cube" => Ok(frames::cube_rotations()),
        Orientations::Named(name) if name == "nasa_table_3" => {
            Ok(NASA_TABLE_3.iter().map(frames::matrix).collect())
        }
        Orientations::Named(name) => Err(Error::document(
            format!("{path}.orientations"),
            format!("\"{name}\""),
            "\"cube\", \"nasa_table_3\", or a list of 3x3 rotations",
        )),
        Orientations::List(list) => frames::rotations(list, &format!("{path}.orientations")),
    }
}

/// The field along each coil for each drive, nT.
fn drives(axes: &AxesProcedure, path: &str) -> Result<Vec<Vector3<f64>>, Error> {
    axes.drives
        .iter()
        .enumerate()
        .map(|(index, drive)| match drive {
            Drive::Vector(vector) => Ok(Vector3::from(*vector)),
            Drive::Named(name) if name == "zero" => Ok(Vector3::zeros()),
            Drive::Named(name) => {
                let (sign, letter) =
                    name.strip_prefix('-').map_or((1.0, name.as_str()), |letter| (-1.0, letter));
                let axis = Axis::ALL.into_iter().find(|axis| axis.letter() == letter).ok_or_else(|| {
                    Error::document(
                        format!("{path}.drives[{index}]"),
                        format!("\"{name}\""),
                        "\"x\", \"-x\", \"y\", \"-y\", \"z\", \"-z\", \"zero\", or [x, y, z] in nT",
                    )
                })?;
                Ok(Vector3::ith(axis.index(), sign * axes.drive_nt))
            }
        })
        .collect()
}
