use serde::{Deserialize, Serialize};
use std::fmt;

use crate::Extra;

/// One of the three axes of a sensor block or of a coil system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// First axis: north in GEO, the sensor along it in SEN.
    X,
    /// Second axis: east in GEO.
    Y,
    /// Third axis: down in GEO.
    Z,
}

impl Axis {
    /// The three axes in order.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// Position in vectors and matrices: 0, 1 or 2.
    pub fn index(self) -> usize {
        self as usize
    }

    /// The letter used in keys and column names.
    pub fn letter(self) -> &'static str {
        ["x", "y", "z"][self.index()]
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.letter())
    }
}

/// Something given for each axis, where it is given: `{"x": …, "y": …, "z": …}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(bound(deserialize = "T: Deserialize<'de>"))]
pub struct PerAxis<T> {
    /// For the x axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<T>,
    /// For the y axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<T>,
    /// For the z axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<T>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl<T> Default for PerAxis<T> {
    fn default() -> Self {
        Self { x: None, y: None, z: None, extra: Extra::new() }
    }
}

impl<T> PerAxis<T> {
    /// What is given for `axis`.
    pub fn get(&self, axis: Axis) -> Option<&T> {
        match axis {
            Axis::X => self.x.as_ref(),
            Axis::Y => self.y.as_ref(),
            Axis::Z => self.z.as_ref(),
        }
    }

    /// The place for `axis`, to fill or to change.
    pub fn entry(&mut self, axis: Axis) -> &mut Option<T> {
        match axis {
            Axis::X => &mut self.x,
            Axis::Y => &mut self.y,
            Axis::Z => &mut self.z,
        }
    }

    /// Those that are given, in the order x, y, z.
    pub fn iter(&self) -> impl Iterator<Item = (Axis, &T)> {
        Axis::ALL.into_iter().filter_map(|axis| self.get(axis).map(|item| (axis, item)))
    }
}

impl<T> FromIterator<(Axis, T)> for PerAxis<T> {
    fn from_iter<I: IntoIterator<Item = (Axis, T)>>(items: I) -> Self {
        let mut all = Self::default();
        for (axis, item) in items {
            *all.entry(axis) = Some(item);
        }
        all
    }
}
