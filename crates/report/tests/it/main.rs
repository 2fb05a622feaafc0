//! The integration tests of `report`: one program, a module for each subject.

mod bad_input;
mod browser;
mod campaigns;
mod certificate;
mod conformity;
mod findings;
mod golden;
mod help;
mod laws;
mod well_formed;
