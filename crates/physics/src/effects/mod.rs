//! The effects. A file holds one idea: effects that share their equation stand together.

mod axis;
mod bandwidth;
mod change_points;
mod clock;
mod coil;
mod converter;
mod cross_field;
mod dependence;
mod empirical;
mod gradient;
mod hysteresis;
mod inflection;
mod iron;
mod leakage;
mod lines;
mod nonlinearity;
mod prelude;
mod sites;
mod spacecraft;
mod sun;
mod surroundings;
mod temperature;
mod time;

pub use axis::{AxisCreep, AxisTemperature};
pub use bandwidth::{Delay, LoopBandwidth};
pub use change_points::{Dropout, ReadingStep, Spike};
pub use clock::{ClockOffset, ClockRate};
pub use coil::{CoilHeating, CoilTemperature, EddyCurrents};
pub use converter::{Clipping, DifferentialNonlinearity, Quantisation, Saturation};
pub use cross_field::{CrossField, CrossFieldSensitivity};
pub use dependence::Dependence;
pub use empirical::{Empirical, chebyshev};
pub use gradient::{CoilGradient, OffCentre, add_known_gradient};
pub use hysteresis::{Hysteresis, Perming};
pub use inflection::OffsetTemperatureInflection;
pub use iron::{HardIron, SoftIron};
pub use leakage::{NullingLeakage, NullingLeakageAcross};
pub use lines::{Mains, PeriodicField, TractionPower};
pub use nonlinearity::{CubicNonlinearity, QuadraticNonlinearity};
pub use sites::{InductionDifference, MeasuredTilt, PillarGradient, PillarSettling, PillarTilt};
pub use spacecraft::{ReactionWheel, ReactionWheelHarmonic, StrayCurrent};
pub use sun::{SunThermoelectric, SunThermoelectricHarmonics};
pub use surroundings::{VehiclePass, WorkingHours, machines_run};
pub use temperature::{
    OffsetElectronicsTemperature, OffsetElectronicsTemperatureLag, OffsetTemperature, OffsetTemperatureLag,
    SensitivityElectronicsTemperature, SensitivityElectronicsTemperatureLag, SensitivityTemperature,
    SensitivityTemperatureLag,
};
pub use time::{Ageing, SensitivityAgeing, WarmUp};
