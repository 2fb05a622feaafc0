//! From a plan to the recordings that a campaign would give.
//!
//! The readings come from the same forward model that the calibrations fit ([`physics::predict`]), with
//! noise and quantisation on top. What is true goes to a file of its own, never into the document.

mod axes;
mod campaign;
mod check;
mod error;
mod noise;
mod plan;

pub use campaign::{Campaign, TrueOrientation, Truth, campaign};
pub use error::Error;
pub use plan::{AcDrive, AxesProcedure, Drive, FreeRun, Orientations, Plan, Procedure, TruthPlan};
