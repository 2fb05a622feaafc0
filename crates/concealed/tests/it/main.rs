//! The integration tests of `concealed`: a module for each subject.

mod documents;
mod independence;
