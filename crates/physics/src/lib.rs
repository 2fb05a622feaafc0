//! The forward model of a magnetometer reading, and the effects that a first model leaves out.
//!
//! Pure functions, no input or output. The chain of one reading, before any effect:
//!
//! ```text
//! B_geo = η · (k_c ∘ I + B0_c) + ambient        B_sen = R · B_geo
//! B_par,i = m_i · B_sen                         V_i = (B_par,i − O_i) / k_i
//! ```
//!
//! Frames: GEO is north, east, down; SEN is the Cartesian frame of the sensor block. Columns of η are
//! the coils' unit vectors in GEO, columns of μ the sensors' in SEN, rows of R the SEN axes in GEO.
//! Fields in nT, currents in A, outputs in V, times in s, angles in rad.

mod catalogue;
mod chain;
mod context;
mod directions;
mod effect;
mod effects;
mod error;
pub mod frames;
mod instance;
mod inverse;
mod lanes;
pub mod memory;
mod model;
mod parameter;
mod reading;
mod real;
mod setting;

pub use catalogue::Kind;
pub use chain::{LeftOut, Prediction, predict, predict_acting, predict_with_jacobian};
pub use context::{Context, KELVIN, References, Thermometer, Unit, orientation};
pub use directions::directions;
pub use effect::{About, Acts, Effect, ParameterInfo, Place, Role, Stage, Surroundings};
pub use error::Error;
pub use instance::{EffectInstance, Within, adopt, state_references};
pub use inverse::{Inverter, Row, Solved, field_in_sen};
pub use model::{Basic, CoilConstants, SensorConstants, sensitivity};
pub use parameter::Parameter;
pub use reading::{Reading, field_geo, parallel, reading};
pub use real::Real;
pub use setting::Setting;
