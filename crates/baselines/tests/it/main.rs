//! The integration tests of `baselines`: one program, a module for each subject.

mod help;
