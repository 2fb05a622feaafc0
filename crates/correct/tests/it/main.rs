//! The integration tests of `correct`: one program, a module for each subject.

mod bad_input;
mod campaign;
mod catalogue;
mod files;
mod formats;
mod golden;
mod joint;
mod laws;
mod truth;
mod variometer;
