//! What one effect is.

use common::Axis;
use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign, Scalar, Vector3};
use num_dual::DualNum;
use std::fmt;

use crate::{Context, Error, Kind};

/// A number that may carry a derivative: `f64` for simulation, a dual number for fits. An effect is
/// written once for any of them, so a prediction and its Jacobian cannot disagree.
pub trait Real:
    DualNum<Primitive = f64> + Copy + Scalar + ClosedAddAssign + ClosedSubAssign + ClosedMulAssign
{
}

impl<T> Real for T where
    T: DualNum<Primitive = f64> + Copy + Scalar + ClosedAddAssign + ClosedSubAssign + ClosedMulAssign
{
}

/// Where in the chain an effect acts, in the order of the signal. The signal there is a vector for
/// each row, in nT.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Field along each coil's axis, made by its current.
    Coil,
    /// Field in GEO: facility and environment.
    Facility,
    /// Field in SEN: what is fixed to the sensor block.
    SensorBlock,
    /// Field along each sensor's axis.
    Sensor,
    /// Output of the electronics, as field.
    Electronics,
    /// What the logger stores, as field.
    Logger,
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterInfo {
    /// Key in documents; it ends in the unit.
    pub name: &'static str,
    /// Smallest plausible size.
    pub low: f64,
    /// Largest plausible size.
    pub high: f64,
    /// Whether only positive values make sense.
    pub positive: bool,
}

/// What an effect sees besides the signal that it changes.
pub struct Surroundings<'a, T> {
    /// The recording.
    pub context: &'a Context<'a>,
    /// The field in SEN for each row, nT; empty before the chain has reached the sensor block.
    pub field_sen: &'a [Vector3<T>],
}

/// One piece of physics: it says what it is and adds its contribution to a signal. Simulation, fit,
/// correction and diagnosis all use this one definition.
pub trait Effect {
    /// The catalogue's name.
    const NAME: &'static str;
    /// In the field's words.
    const TITLE: &'static str;
    /// One sentence of physics.
    const PHYSICS: &'static str;
    /// The equation of its contribution.
    const EQUATION: &'static str;
    /// Where that is written.
    const SOURCE: &'static str;
    /// Where in the chain it acts.
    const PLACE: Place;
    /// Its parameters, in the order that `apply` takes them.
    const PARAMETERS: &'static [ParameterInfo];

    /// Adds the contribution to `signal` (one vector a row, nT) on `axis`: the coil or the sensor that is meant.
    fn apply<T: Real>(
        parameters: &[T],
        axis: Axis,
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error>;
}

/// An effect with the values of its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectInstance {
    /// Which effect.
    pub kind: Kind,
    /// The coil or sensor that it acts on.
    pub axis: Axis,
    /// Values, in the order of the effect's parameters.
    pub parameters: Vec<f64>,
}

impl fmt::Display for EffectInstance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = if self.kind.place() == Place::Coil { "coil" } else { "sensor" };
        write!(f, "{} ({part} {}:", self.kind.title(), self.axis)?;
        for (info, value) in self.kind.parameters().iter().zip(&self.parameters) {
            write!(f, " {} = {value}", info.name)?;
        }
        f.write_str(")")
    }
}
