//! What is in a residual: groups of columns that explain it, steps and spikes.

pub mod events;
pub mod screen;
