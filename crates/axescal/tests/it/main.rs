//! The integration tests of `axescal`: one program, a module for each subject.

mod ac;
mod build;
mod coverage;
mod departures;
mod design;
mod golden;
mod gradients;
mod laws;
mod links;
mod nasa;
mod pages;
mod pipe;
mod starts;
