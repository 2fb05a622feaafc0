//! The integration tests of `scalarcal`: one program, a module for each subject.

mod answers;
mod body;
mod build;
mod coverage;
mod golden;
mod orbit;
mod references;
mod stream;
mod vector;
mod windows;
