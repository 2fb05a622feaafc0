//! The clocks of the two instruments: offset and rate, jumps, pauses, and what one offset leaves out.

pub mod adopt;
pub mod delays;
mod look;
pub mod pauses;
pub mod segments;

pub use look::{GAIN, Look, Moved, Parts, Shift, aligned, late_s, look, moves};
