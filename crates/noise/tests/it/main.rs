//! The integration tests of `noise`: one program, a module for each subject.

mod spectra;
mod whitening;
