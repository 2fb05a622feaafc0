//! The series that are compared: what is recorded beside them, steps and spikes, what columns leave, points
//! for plots.

pub mod axes;
pub mod events;
pub mod housekeeping;
pub mod prepare;
pub mod residual;
pub mod shown;
