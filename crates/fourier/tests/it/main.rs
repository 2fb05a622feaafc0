//! The integration tests of `fourier`: one program, a module for each subject.

mod transforms;
