//! The integration tests of `sensorcal`: one program, a module for each subject.

mod across_coverage;
mod bad_input;
mod build;
mod conditions;
mod conditions_coverage;
mod coverage;
mod golden;
mod help;
mod laws;
mod long;
mod magsat;
mod sensitivity;
mod shield;
mod trend;
