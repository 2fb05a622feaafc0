//! The difference that no turn explains: its noise, its drift, what it follows, and how much of it is the
//! reference's.

pub mod contributions;
pub mod difference;
pub mod drift;
pub mod reference_noise;
