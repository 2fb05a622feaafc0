//! The integration tests of `simulate`: one program, a module for each subject.

mod build;
mod campaign;
mod effects;
mod flight;
mod golden;
mod laws;
mod procedures;
mod reference;
mod replay;
mod run_sheet;
mod schema;
mod sweep;
