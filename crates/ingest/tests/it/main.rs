//! The integration tests of `ingest`: one program, a module for each subject.

mod absolute;
mod bad_input;
mod golden;
mod help;
mod laws;
mod pipe;
mod real;
mod schema;
