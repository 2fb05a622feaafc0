//! Every program on fixtures that were changed, and what no program may do, whatever it reads.
//!
//! A case is a number: with the seed it says which command line, which fixture and which changes, on any
//! machine and any number of threads. A program that is given a case may do what is asked or refuse it in
//! words; it may not panic, end by a signal, hang, end with another code than 0, 1 or 2, leave anything
//! behind when it fails, or write a number that is none; and a later program of the pipeline may not refuse
//! what an earlier one wrote.
//!
//! `corpus` is every fixture by its kind, `commands` the command lines that read each kind, `mutate` the
//! changes, one file a sort. `run` limits a program to 20 s of processor time and 4 GB, `check` applies the
//! rules, and `follow` feeds the output to the next program, which may not refuse it unless the fault was in
//! the first one's input already. A finding is repeated by seed and case; when it is fixed it becomes a
//! fixture of `fixtures/bad` or a test. The first three hundred cases are a test, without a clock; `just
//! fuzz` takes ten minutes.

mod case;
mod check;
mod commands;
mod corpus;
mod draw;
mod finding;
mod follow;
mod kind;
mod mutate;
mod programs;
mod run;
mod session;

pub use common::Error;
pub use finding::Finding;
pub use programs::{NAMES, Programs};
pub use session::{Session, Settings, Summary};
