//! The integration tests of `sensorcal`: one program, a module for each subject.

mod across_coverage;
mod build;
mod conditions;
mod conditions_coverage;
mod coverage;
mod golden;
mod laws;
mod long;
mod magsat;
mod sensitivity;
mod shield;
mod trend;
