//! The integration tests of `fuzz`: one program, a module for each subject.

mod budget;
mod help;
