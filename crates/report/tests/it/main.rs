//! The integration tests of `report`: one program, a module for each subject.

mod browser;
mod campaigns;
mod certificate;
mod conformity;
mod findings;
mod golden;
mod laws;
mod program;
mod well_formed;
