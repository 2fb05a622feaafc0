//! Recordings with physics concealed in them, and the score of who finds it.
//!
//! A tool that finds the effects which its own simulator puts in has shown nothing: simulator and finder share their mistakes. This crate
//! shares no line of physics, noise or estimation with the stages, and its physics is finer than the catalogue's. It writes documents of
//! the public format, seals the truth, runs the programs as they are shipped, opens the truth and counts.

mod error;
pub mod programs;
pub mod real;

pub use error::Error;
