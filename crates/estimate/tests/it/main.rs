//! The integration tests of `estimate`: one program, a module for each subject.

mod allan;
mod cosine;
mod cross_spectrum;
mod events;
mod haar;
mod hac;
mod made;
mod nist_linear;
mod normality;
mod periodogram;
mod resample;
mod sources;
mod welch;
mod whittle;
mod whittle_coverage;
