//! What is concealed one at a time: for each the finer physics and the catalogue's name for it.

mod age;
mod block;
mod channel;
mod cores;
mod craft;
mod electronics;
mod environment;
mod facility;
mod further;
mod grids;
mod ground;
mod lagging;
mod logger;
mod loops;
mod metal;
mod pair;
mod sensor;
mod single;
mod vehicles;
mod warmth;

pub use electronics::second_order_loop;
pub use further::FURTHER;
pub use single::{FIRST, Single};

use crate::scene::SceneKind;
use single::{single, stepped};

/// The first form of thirty kinds. Further kinds and forms are in [`FURTHER`].
pub const ALL: [Single; 30] = [
    single("hysteresis", SceneKind::Coils, sensor::hysteresis),
    single("offset_temperature", SceneKind::Coils, sensor::offset_temperature),
    single("offset_temperature_lag", SceneKind::Coils, sensor::offset_temperature_lag),
    single("sensitivity_temperature", SceneKind::Coils, sensor::sensitivity_temperature),
    single("sensitivity_temperature_lag", SceneKind::Coils, sensor::sensitivity_temperature_lag),
    single("axis_temperature", SceneKind::Coils, sensor::axis_temperature),
    single("quadratic_nonlinearity", SceneKind::Coils, sensor::quadratic),
    single("cubic_nonlinearity", SceneKind::Coils, sensor::cubic),
    single("cross_field", SceneKind::Coils, sensor::cross_field),
    single("cross_field_sensitivity", SceneKind::Coils, sensor::cross_field_sensitivity),
    single("warm_up", SceneKind::Coils, electronics::warm_up),
    single("offset_electronics_temperature", SceneKind::Coils, electronics::offset_temperature),
    single("loop_bandwidth", SceneKind::Fast, electronics::second_order_loop),
    single("differential_nonlinearity", SceneKind::Coils, electronics::wrong_bits),
    single("quantisation", SceneKind::Coils, electronics::coarse_codes),
    single("saturation", SceneKind::Coils, electronics::saturation),
    single("clock_offset", SceneKind::Coils, electronics::clock_offset),
    single("clock_rate", SceneKind::Coils, electronics::clock_rate),
    single("reading_step", SceneKind::Coils, electronics::step),
    single("spike", SceneKind::Coils, electronics::spike),
    single("eddy_currents", SceneKind::Coils, facility::eddy_currents),
    single("coil_heating", SceneKind::Coils, facility::coil_heating),
    single("coil_temperature", SceneKind::Coils, facility::coil_temperature),
    single("nulling_leakage", SceneKind::Site, facility::nulling),
    single("mains", SceneKind::Held, environment::mains),
    stepped(single("vehicle_pass", SceneKind::Site, environment::vehicle), 2.0),
    stepped(single("working_hours", SceneKind::Site, environment::working_hours), 200.0),
    single("stray_current", SceneKind::Craft, craft::stray_current),
    single("sun_thermoelectric", SceneKind::Craft, craft::sun),
    single("induction_difference", SceneKind::Pair, pair::induction),
];

/// Those that act in runs in coils, whose names can stand beside each other.
pub fn in_coils() -> Vec<Single> {
    ALL.into_iter().filter(|single| single.scene == SceneKind::Coils).collect()
}
