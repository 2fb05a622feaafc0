//! The integration tests of `correct`: one program, a module for each subject.

mod bad_input;
mod campaign;
mod catalogue;
mod files;
mod golden;
mod help;
mod laws;
mod truth;
