//! What one effect is.

use common::Axis;
use nalgebra::Vector3;
use std::borrow::Cow;

use crate::words::words;
use crate::{Basic, Context, Error, Family, Real, Result, Thermometer};

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

/// Where in the chain an effect acts, in the order of the signal: a vector in nT for each row.
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
    /// A size of either sign: the contribution is proportional to it, or, for a level, monotonic.
    Amplitude,
    /// A time constant, a level, a period: positive, and not linear.
    Shape,
    /// What the contribution counts from: a moment, a span, a reference. Its derivative says nothing.
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

    /// A span of time at whose end the contribution jumps, or a reference; possibly zero.
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
pub(crate) struct Surroundings<'a, T: Real> {
    /// The name of the effect, for what it lacks.
    pub who: &'static str,
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

impl<'a, T: Real> Surroundings<'a, T> {
    /// The signal along the axis that is meant.
    pub fn own<'s>(&self, signal: &'s mut [Vector3<T>]) -> impl Iterator<Item = &'s mut T> {
        let axis = self.axis.index();
        signal.iter_mut().map(move |value| &mut value[axis])
    }

    /// As [`Context::times`].
    pub fn times(&self) -> Result<&'a [f64]> {
        self.context.times(self.who)
    }

    /// As [`Context::clock`].
    pub fn clock(&self) -> Result<Vec<f64>> {
        self.context.clock(self.who)
    }

    /// As [`Context::column`].
    pub fn column(&self, name: &str) -> Result<Cow<'a, [f64]>> {
        self.context.column(name, self.who)
    }

    /// As [`Context::temperature`].
    pub fn temperature(&self, which: Thermometer) -> Result<(Cow<'a, [f64]>, f64)> {
        self.context.temperature(which, self.who)
    }

    /// The error that the effect lacks something.
    pub fn missing(&self, what: &str) -> Error {
        self.context.missing(self.who, what)
    }
}

/// One piece of physics, of which simulation, fit, correction and diagnosis use this definition.
pub(crate) trait Effect {
    /// What it is.
    const ABOUT: About;
    /// Whether the chain can be run backwards through it: whether the reading determines the field.
    const INVERTIBLE: bool = true;

    /// Adds the contribution to `signal` (one vector a row, nT).
    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result;
}
