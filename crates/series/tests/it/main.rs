//! The integration tests of `series`: one program, a module for each subject.

mod bad_input;
mod laws;
mod times;
