//! The integration tests of `common`: one program, a module for each subject.

mod schema;
