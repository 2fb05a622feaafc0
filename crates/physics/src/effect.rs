//! What one effect is.

use common::Axis;
use nalgebra::Vector3;

use crate::words::words;
use crate::{Basic, Context, Family, Real, Result};

words! {
    /// What an effect belongs to.
    pub enum Place {
        /// The sensors.
        Sensor = "sensor",
        /// Their electronics.
        Electronics = "electronics",
        /// The data logger.
        Logger = "logger",
        /// The coil facility.
        Facility = "facility",
        /// What surrounds it.
        Environment = "environment",
        /// The spacecraft that carries the sensors.
        Spacecraft = "spacecraft",
        /// The two places of a differential recording.
        Sites = "sites",
    }
}

/// Where in the chain an effect adds its contribution, in the order of the signal. The signal there is
/// a vector for each row, in nT.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Field along each coil's axis, made by its current.
    Coil,
    /// Field in GEO.
    Geo,
    /// Field in SEN: what is fixed to the sensor block.
    Block,
    /// Field along each sensor's axis.
    Sensor,
    /// Output of the electronics, as field.
    Electronics,
    /// The same at the times at which it is truly taken; the noise of a reading comes in here.
    Sampling,
    /// What the converter makes of it.
    Converter,
    /// What the logger stores, as field.
    Logger,
}

/// What one instance of an effect acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// One sensor.
    OneSensor,
    /// One coil.
    OneCoil,
    /// Everything at its stage.
    Everything,
    /// Everything, in step with one housekeeping column, whose name ends so.
    WithColumn(&'static str),
}

/// How a parameter enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A size: the contribution is proportional to it (or, for a level, monotonic in it), and may have either
    /// sign.
    Amplitude,
    /// A time constant, a level, a period: positive, and not linear.
    Shape,
    /// What the contribution counts from: a moment or a span of `time_s`, at which it jumps, or a value of reference.
    /// Its derivative says nothing.
    Epoch,
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
    /// How it enters.
    pub role: Role,
    /// Its value where a document does not give it; None where it has to.
    pub absent: Option<f64>,
}

impl ParameterInfo {
    /// A size of either sign.
    pub const fn amplitude(name: &'static str, low: f64, high: f64) -> Self {
        Self { name, low, high, role: Role::Amplitude, absent: None }
    }

    /// A positive number that enters nonlinearly.
    pub const fn shape(name: &'static str, low: f64, high: f64) -> Self {
        Self { name, low, high, role: Role::Shape, absent: None }
    }

    /// The same, zero where a document does not give it.
    pub const fn or_zero(self) -> Self {
        Self { absent: Some(0.0), ..self }
    }

    /// A moment of the recording.
    pub const fn epoch(name: &'static str) -> Self {
        Self::of_recording(name, 1.0, 1e7)
    }

    /// What one recording says of itself, such as a moment: it is not fitted and has to be given.
    pub const fn of_recording(name: &'static str, low: f64, high: f64) -> Self {
        Self { name, low, high, role: Role::Epoch, absent: None }
    }

    /// The same in every recording, and possibly nothing: a span of time at whose end the contribution jumps, or a
    /// reference.
    pub const fn span(name: &'static str, low: f64, high: f64) -> Self {
        Self { name, low, high, role: Role::Epoch, absent: Some(0.0) }
    }

    /// The middle of what is plausible: the geometric mean.
    pub fn middle(&self) -> f64 {
        (self.low * self.high).sqrt()
    }

    /// Whether it is a shape that can be fitted from a value; not where the effect has none of it, as no lag.
    pub fn is_shape_at(&self, value: f64) -> bool {
        self.role == Role::Shape && self.absent != Some(value)
    }

    /// Whether it is of one recording, such as a moment: what has to be given.
    pub const fn is_moment(&self) -> bool {
        matches!(self.role, Role::Epoch) && self.absent.is_none()
    }
}

/// What an effect says of itself.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// The catalogue's name.
    pub name: &'static str,
    /// In the field's words.
    pub title: &'static str,
    /// One sentence of physics.
    pub physics: &'static str,
    /// The equation of its contribution.
    pub equation: &'static str,
    /// Where that is written.
    pub source: &'static str,
    /// What kind of physics it is.
    pub family: Family,
    /// What it belongs to.
    pub place: Place,
    /// Where in the chain it acts.
    pub stage: Stage,
    /// What one instance acts on.
    pub acts: Acts,
    /// Its parameters, in the order that `apply` takes them.
    pub parameters: &'static [ParameterInfo],
    /// What a recording must hold besides its drive or field: columns, or conditions in words.
    pub needs: &'static [&'static str],
}

impl About {
    /// What kind of effect it is, without words and parameters.
    pub const fn of(family: Family, place: Place, stage: Stage, acts: Acts) -> Self {
        let [name, title, physics, equation, source] = [""; 5];
        let (parameters, needs) = (&[], &[]);
        Self { name, title, physics, equation, source, family, place, stage, acts, parameters, needs }
    }
}

/// What an effect sees besides the signal that it changes.
pub struct Surroundings<'a, T: Real> {
    /// The recording.
    pub context: &'a Context<'a>,
    /// The coil or sensor that is meant; x for an effect on everything.
    pub axis: Axis,
    /// The housekeeping column that is meant; empty where there is none.
    pub column: &'a str,
    /// The basic chain.
    pub basic: &'a Basic<T>,
    /// The field along each coil for each row, nT; empty before the chain has left the coils.
    pub coil_nt: &'a [Vector3<T>],
    /// The field in SEN for each row, nT; empty before the chain has reached the sensor block.
    pub field_sen: &'a [Vector3<T>],
}

impl<T: Real> Surroundings<'_, T> {
    /// The signal along the axis that is meant.
    pub(crate) fn own<'s>(&self, signal: &'s mut [Vector3<T>]) -> impl Iterator<Item = &'s mut T> {
        let axis = self.axis.index();
        signal.iter_mut().map(move |value| &mut value[axis])
    }
}

/// One piece of physics: it says what it is and adds its contribution to a signal. Simulation, fit,
/// correction and diagnosis all use this one definition.
pub trait Effect {
    /// What it is.
    const ABOUT: About;
    /// Whether the chain can be run backwards through it: whether the reading determines the field.
    const INVERTIBLE: bool = true;

    /// Adds the contribution to `signal` (one vector a row, nT).
    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result;
}
