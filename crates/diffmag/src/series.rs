//! The series that are compared: steps and spikes, what columns leave, points
//! for plots.

pub mod axes;
pub mod events;
pub mod prepare;
pub mod residual;
pub mod shown;
