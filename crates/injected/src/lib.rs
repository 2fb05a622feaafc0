//! Effects concealed in real recordings that show nothing.
//!
//! Noise that a generator draws is as kind as its author. Here noise, rounding and disturbances are those of
//! instruments: a host is a recording that somebody else made, of which `diagnose` says that it agrees with
//! the basic model, and an effect of `concealed` is added to its readings. Which recordings are tried stands
//! in [`hosts::CANDIDATES`], which effects a host can carry in [`suits`]; both were written down before
//! anything was injected.
//!
//! `hosts` says which recordings are tried and how they are cut. `host` makes a campaign of one (fields and
//! temperatures as interpolants, `between`) and measures sizes by what a fresh calibration leaves. `suits` is
//! the rule by which a host can carry an effect; `cases` are document and truth.

pub mod between;
pub mod cases;
pub mod host;
pub mod hosts;
pub mod length;
#[cfg(test)]
mod made_up;
pub mod matrix;
pub mod stats;
pub mod suits;

pub use cases::{SET, injected, untouched};
pub use host::Host;
pub use hosts::{CANDIDATES, Candidate};
