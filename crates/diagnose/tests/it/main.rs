//! The integration tests of `diagnose`: one program, a module for each subject.

mod ambiguous;
mod bad_input;
mod behind_scalarcal;
mod bench;
mod beside;
mod clean;
mod coverage;
mod dependence;
mod golden;
mod help;
mod joined;
mod joint;
mod laws;
mod long;
mod moved;
mod nasa;
mod noise;
mod outside;
mod pair;
mod pipe;
mod scalar;
mod several;
mod single;
