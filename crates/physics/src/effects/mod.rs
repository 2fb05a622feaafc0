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

pub use empirical::chebyshev;
pub use gradient::add_known_gradient;
pub use prelude::FULL_NT;
pub use sun::{HARMONICS, harmonics_at};
pub use surroundings::machines_run;
