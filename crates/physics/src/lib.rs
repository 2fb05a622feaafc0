//! The forward model of a magnetometer reading, and the effects that a first model leaves out.
//!
//! Pure functions, no input or output. The chain of one reading, before any effect:
//!
//! ```text
//! B_geo = η · (k_c ∘ I + B0_c) + ambient        B_sen = R · B_geo
//! B_par,i = m_i · B_sen                         V_i = (B_par,i − O_i) / k_i
//! ```
//!
//! Frames: GEO is north, east, down; SEN is that of the sensor block. Columns of η are the coils' unit
//! vectors in GEO, of μ the sensors' in SEN, rows of R the SEN axes in GEO. nT, A, V, s, rad.
//!
//! Chain and effects are written once, generic in the number type. With `f64` they simulate; with dual
//! numbers (`num-dual`) the same lines give derivatives, eight in a pass (`lanes`). In a differential
//! recording the reference's reading stands for the field in SEN, and η for μ.
//!
//! [`Inverter`] runs the chain backwards for all rows at once: B ← B + S (y − F(B)). S is (μᵀ)⁻¹ at first.
//! Where a reading depends on other rows, or the iteration does not settle, S is the inverse of ∂F/∂B over
//! neighbouring rows, from the same effects in dual numbers; rows far enough apart share a pass. That system
//! is solved as least squares with a small damping: with a delay, the last rows are not observed and the
//! first are observed twice, so that no square system has a stable solution. What is not observed is reported
//! row by row. Derivatives of the corrected field take the same passes with a dual number.
//!
//! Effects with memory are state equations on `memory::Signal`: a cubic between samples, straight across a
//! gap. Lags are exact for that signal whatever the step; a signal straight throughout would be wrong by half
//! a step for every lag that is shorter than the sampling interval.
//!
//! `reading` gives one reading of the basic chain with analytic derivatives, for `axescal`, which needs
//! thousands of solves a second. A property test compares it with differences.

mod catalogue;
mod chain;
mod context;
mod directions;
mod effect;
mod effects;
mod error;
mod family;
pub mod frames;
mod instance;
mod inverse;
mod lanes;
pub mod memory;
mod model;
mod reading;
mod setting;
pub mod theodolite;
mod variometer;
mod words;

pub use catalogue::Kind;
pub use chain::{Direction, LeftOut, Prediction, predict, predict_acting, predict_with_jacobian};
pub use context::{Context, KELVIN, References, Thermometer, Unit, orientation};
pub use directions::directions;
pub use effect::{About, Acts, ParameterInfo, Place, Role, Stage};
pub use effects::{
    FULL_NT, HARMONICS as SUN_HARMONICS, chebyshev, harmonics_at as sun_harmonics, machines_run,
};
pub use error::{Error, Result};
pub use family::Family;
pub use instance::{EffectInstance, Within, adopt, state_references};
pub use inverse::{Inverter, Row, Solved, field_in_sen};
pub use lanes::Real;
pub use model::{Basic, CoilConstants, Parameter, SensorConstants, sensitivity};
pub use reading::{Reading, field_geo, parallel, reading};
pub use setting::Setting;
pub use variometer::Components;
