//! What is written aboard beside the readings: a field model and the attitude of a star sensor, each with its
//! errors.

use common::{Axis, Column, Noise, Recording};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use noise::{NoiseError, Stream};
use physics::frames::{ARCSEC, small_rotation};
use serde::{Deserialize, Serialize};

/// Errors of a field model and of a star sensor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct KnownField {
    /// What each component of the model errs by, GEO.
    pub noise: Noise,
    /// What the attitude errs by about each axis of SEN, white, arcsec.
    pub attitude_std_arcsec: f64,
}

/// Puts the field model and the attitude, as they are known, in the place of the true ones; neither is
/// written where none is known.
pub fn write(
    set: &mut Recording,
    known: Option<&KnownField>,
    attitude: &[Matrix3<f64>],
    seed: u64,
) -> Result<(), NoiseError> {
    let Some(known) = known else {
        let beside = |name: &String| name.starts_with("ambient_") || name.starts_with("attitude_");
        set.columns.retain(|name, _| !beside(name));
        return Ok(());
    };
    for axis in Axis::ALL {
        let name = format!("ambient_{axis}_nt");
        let time = set.column("time_s");
        let errors = noise::series(&known.noise, seed, &format!("{}/{name}", set.id), set.rows(), time)?;
        if let Some(column) = set.columns.get_mut(&name) {
            column.iter_mut().zip(errors).for_each(|(value, error)| *value += error);
        }
    }
    let mut stream = Stream::new(seed, &format!("{}/attitude", set.id));
    let std = known.attitude_std_arcsec * ARCSEC;
    let read = |rotation: &Matrix3<f64>| {
        let error = Vector3::from_fn(|_, _| std * stream.normal());
        quaternion(&(small_rotation(&error) * rotation))
    };
    let attitude: Vec<_> = attitude.iter().map(read).collect();
    set.columns.extend(attitude_columns(&attitude));
    Ok(())
}

pub fn attitude_columns(attitude: &[UnitQuaternion<f64>]) -> Vec<(String, Column)> {
    let part = |name: &str, of: &dyn Fn(&UnitQuaternion<f64>) -> f64| {
        (format!("attitude_{name}"), attitude.iter().map(of).collect())
    };
    vec![part("w", &|q| q.w), part("x", &|q| q.i), part("y", &|q| q.j), part("z", &|q| q.k)]
}

pub fn quaternion(rotation: &Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation))
}
