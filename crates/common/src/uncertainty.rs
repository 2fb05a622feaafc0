//! The joint uncertainty of all that is calibrated, `calibration.uncertainty`: independent sources, and how
//! one standard deviation of each moves the parameters.
//!
//! With the moves s of a source as a column over the parameters, their covariance is Σ s sᵀ: a root of it,
//! which stays small and positive whatever is added. A program that estimates parameters hands in a
//! [`Block`]: their own covariance, and how they move with the parameters that they were estimated with. By
//! those derivatives every source that moves the latter moves the former. A program that uses parameters
//! takes the [`Uncertainty::covariance_by`] of what it makes of them. So what two parameters have in common
//! stays in common, through any number of stages.
//!
//! What a document states beside its values, by hand or by a program that knows no sources, comes in by the
//! same route. Tests in `correct` and `diagnose` move every source, run the later stages again, and compare
//! all parameters and the corrected field with what is stated.

mod drive;
pub(crate) mod joint;
mod of_document;
mod paths;
mod stated;

pub use drive::{drive, of_current};
pub use joint::{Block, By, Source, Uncertainty, by_themselves, root};
pub use paths::{
    VOLTMETER_ABSOLUTE, VOLTMETER_RELATIVE, added_offset, coil_constant, coil_offset, directions, effect,
    gradient, place, residual_field, resistor, sensitivity, sensor_offset,
};
