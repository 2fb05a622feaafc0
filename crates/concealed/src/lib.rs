//! Recordings with physics concealed in them.
//!
//! A tool that finds the effects which its own simulator puts in has shown nothing: simulator and finder
//! share their mistakes. This crate shares no line of physics, noise or estimation with the stages, and its
//! physics is finer than the catalogue's. It makes documents of the public format, each with its truth apart;
//! `blind` has them answered and scores the answers.
//!
//! `signal` is a function of time, known at every instant; `scenes` are campaigns of such signals. `finer`
//! has the pieces of physics; `kinds`, `outside` and `ambiguous` say what is concealed of them, with the
//! names that would be right; `case` is document and truth. `swarm` and `pillar` are two campaigns by
//! themselves. The sets of `Set::LONG` are thousands of rows long and not on the proof's page: each effect
//! there has a `form` error, a size that wanders.

pub mod ambiguous;
pub mod as_recorded;
pub mod base;
pub mod case;
pub mod document;
pub mod draw;
pub mod effect;
pub mod finer;
pub mod form;
pub mod groups;
pub mod housekeeping;
pub mod kinds;
pub mod manner;
pub mod noise;
pub mod outside;
pub mod pillar;
pub mod scene;
pub mod scenes;
pub mod sets;
pub mod signal;
pub mod storm;
pub mod swarm;
