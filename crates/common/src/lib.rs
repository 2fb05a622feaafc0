//! The calibration document.
//!
//! Every fluxcal program reads one [`Document`], adds what it found and writes the document on.
//! Here are its types (one file for each part) and the quantity with its uncertainty. No physics, no
//! estimation; how a program reads and writes is `program`'s.
//!
//! A column of readings stays text until a stage asks for its numbers ([`Column`]): a scan of the digits
//! counts its rows and bounds its size, and unless it was changed it is written as it came. So a stage passes
//! on what it does not use at the speed of a copy. A number keeps its value, not its spelling: `1` may come
//! out as `1.0`.
//!
//! What every stage must respect is checked here: `check` (directions, sensitivities, covariances), `range`
//! (readings that no instrument gives) and `undetermined` (a number of a result that is not finite is written
//! as `null` and listed with its reason; it is located in the debug text of the types, which names all fields
//! without a second serializer). Errors carry a JSON path; `program` adds file and line. `number` alone decides how digits and
//! plurals are written in messages, tables of reports and errors.
//!
//! The document is read and written with serde in this crate alone ([`Document::parse`], `to_text`,
//! `to_line`; none is generic): no other crate should compile the code of so many types again.

mod absolute;
mod axes;
mod axis;
mod calibration;
mod certificate;
mod check;
mod coil;
mod column;
mod column_text;
pub mod covariance;
mod diagnosis;
mod differential;
mod document;
mod facility;
mod finding;
mod flight;
mod instrument;
mod json;
mod model;
mod nulling;
pub mod number;
mod parse;
mod plain;
mod quantity;
pub mod range;
mod recording;
mod residual;
mod scalar;
#[cfg(feature = "schema")]
pub mod schema;
mod sensor;
mod sensor_conditions;
mod sensor_noise;
mod sensor_offset;
pub mod series;
pub mod time;
pub mod uncertainty;
mod undetermined;
pub mod unit;

pub use absolute::*;
pub use axes::*;
pub use axis::{Axis, PerAxis};
pub use calibration::{Calibration, CoilCalibration, ReferenceConditions, calibration_of};
pub use certificate::*;
pub use coil::*;
pub use column::Column;
pub use diagnosis::*;
pub use differential::*;
pub use document::{Document, HistoryEntry};
pub use errors::{Error, ExitCode, Told};
pub use facility::{Coil, Facility, Voltmeter};
pub use finding::{Code, Finding, Findings};
pub use flight::*;
pub use instrument::{Instrument, Noise, NoiseOfSensors};
pub use json::{to_line, to_text};
pub use model::{AdoptedEffect, Model};
pub use nulling::*;
pub use parse::{FORMAT_VERSION, Versioned, at_path, line_of, parse};
pub use plain::{HeldOutPrediction, PlainRegression};
pub use quantity::{Matrix3x3, OneOrEach, Quantity};
pub use recording::{Columns, Conditions, Dropped, Recording, Theodolite, TheodoliteAngle, procedure};
pub use residual::*;
pub use scalar::*;
pub use sensor::*;
pub use sensor_conditions::*;
pub use sensor_noise::*;
pub use sensor_offset::*;
pub use uncertainty::Uncertainty;
pub use undetermined::{Undetermined, all_finite};

/// Keys that this version does not know. They are kept and written on as they were.
pub type Extra = serde_json::Map<String, serde_json::Value>;
