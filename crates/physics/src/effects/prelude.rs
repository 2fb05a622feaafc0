//! What every effect is written with.

pub(crate) use crate::catalogue::*;
pub(crate) use crate::effect::{About, Acts, Effect, ParameterInfo, Place, Stage, Surroundings};
pub use crate::{Context, Family, Real, Result};
pub use nalgebra::Vector3;

/// Parameters: amplitudes of one range by their names, then what else there is.
macro_rules! amplitudes {
    ($low:literal to $high:literal: $($name:expr),+ $(; $($other:expr),+)?) => {
        &[$(ParameterInfo::amplitude($name, $low, $high),)+ $($($other),+)?]
    };
}
pub(super) use amplitudes;

/// Field to which coefficients of powers refer, nT.
pub const FULL_NT: f64 = 50_000.0;
pub const DAY_S: f64 = 86_400.0;

/// The two axes across an axis, in cyclic order: for x they are y and z.
pub fn across(axis: common::Axis) -> [usize; 2] {
    [(axis.index() + 1) % 3, (axis.index() + 2) % 3]
}
