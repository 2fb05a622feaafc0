//! The integration tests of `absolute`: one program, a module for each subject.

mod coverage;
mod golden;
mod published;
