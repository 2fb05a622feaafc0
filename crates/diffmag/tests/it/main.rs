//! The integration tests of `diffmag`: one program, a module for each subject.

mod across;
mod bad_input;
mod clocks;
mod coverage;
mod drift;
mod drift_reference;
mod filters;
mod fourteen;
mod fourteen_covariance;
mod fourteen_reference;
mod golden;
mod help;
mod housekeeping;
mod laws;
mod near_source;
mod pair_in_time;
mod pairs;
mod real;
mod reference_noise;
mod stability;
mod statsmodels;
mod steps;
mod stream;
mod stream_coverage;
mod time;
mod told;
