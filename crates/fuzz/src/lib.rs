//! Every program on fixtures that were changed, and what no program may do, whatever it reads.
//!
//! A case is a number: with the seed it says which command line, which fixture and which changes, on any machine and any number of
//! threads. A program that is given a case may do what is asked or refuse it in words; it may not panic, end by a signal, hang, end
//! with another code than 0, 1 or 2, leave anything behind when it fails, or write a number that is none; and a later program of the
//! pipeline may not refuse what an earlier one wrote.

pub mod case;
pub mod check;
pub mod commands;
pub mod corpus;
pub mod draw;
mod error;
pub mod finding;
pub mod follow;
pub mod kind;
pub mod made;
pub mod mutate;
pub mod programs;
pub mod run;
pub mod session;

pub use error::Error;
