//! The integration tests of `starcal`: one program, a module for each subject.

mod coverage;
mod golden;
mod laws;
