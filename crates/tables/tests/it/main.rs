//! The integration tests of `tables`: one program, a module for each subject.

mod errors;
mod formats;
mod pandas;
