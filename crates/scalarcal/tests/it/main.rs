//! The integration tests of `scalarcal`: one program, a module for each subject.

mod answers;
mod bad_input;
mod build;
mod coverage;
mod golden;
mod help;
mod scipy;
