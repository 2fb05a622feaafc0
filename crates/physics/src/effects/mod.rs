//! The effects, one file each.

mod coil_heating;
mod offset_temperature_lag;

pub use coil_heating::CoilHeating;
pub use offset_temperature_lag::OffsetTemperatureLag;
