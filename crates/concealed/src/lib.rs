//! Recordings with physics concealed in them, and the score of who finds it.
//!
//! A tool that finds the effects which its own simulator puts in has shown nothing: simulator and finder share their mistakes. This crate
//! shares no line of physics, noise or estimation with the stages, and its physics is finer than the catalogue's. It writes documents of
//! the public format, seals the truth, runs the programs as they are shipped, opens the truth and counts.

pub mod ambiguous;
pub mod base;
pub mod case;
pub mod document;
pub mod draw;
pub mod effect;
mod error;
pub mod finer;
pub mod form;
pub mod groups;
pub mod kinds;
pub mod noise;
pub mod outside;
pub mod page;
pub mod pillar;
pub mod programs;
pub mod prove;
pub mod real;
pub mod scene;
pub mod scenes;
pub mod score;
pub mod seal;
pub mod sets;
pub mod signal;
pub mod swarm;
pub mod tally;
pub mod verdict;
pub mod wilson;

pub use error::Error;
