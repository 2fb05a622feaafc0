//! The integration tests of `diagnose`: one program, a module for each subject.

mod ambiguous;
mod behind_scalarcal;
mod bench;
mod beside;
mod clean;
mod coverage;
mod joint;
mod laws;
mod moved;
mod outside;
mod pair;
mod pipe;
mod scalar;
mod several;
mod single;
