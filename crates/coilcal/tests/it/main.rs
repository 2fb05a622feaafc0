//! The integration tests of `coilcal`: one program, a module for each subject.

mod build;
mod coverage;
mod departures;
mod golden;
mod gradient;
mod laws;
mod nulling;
