//! The integration tests of `coilcal`: one program, a module for each subject.

mod bad_input;
mod build;
mod coverage;
mod departures;
mod golden;
mod gradient;
mod help;
mod laws;
mod nulling;
mod plans;
