//! The integration tests of `blind`: one program, a module for each subject.

mod help;
mod real;
mod sealed;
