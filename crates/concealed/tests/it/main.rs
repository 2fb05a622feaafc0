//! The integration tests of `concealed`: one program, a module for each subject.

mod documents;
mod help;
mod independence;
mod real;
mod sealed;
