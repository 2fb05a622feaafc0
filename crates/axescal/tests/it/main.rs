//! The integration tests of `axescal`: one program, a module for each subject.

mod ac;
mod bad_input;
mod build;
mod coverage;
mod departures;
mod design;
mod golden;
mod gradients;
mod help;
mod laws;
mod laws_of_campaigns;
mod links;
mod nasa;
mod pages;
mod pipe;
mod starts;
