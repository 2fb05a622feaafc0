//! The integration tests of `coilcal`: one program, a module for each subject.

mod bad_input;
mod coverage;
mod departures;
mod golden;
mod gradient;
mod help;
mod nulling;
mod plans;
