//! Two instruments side by side: three components are held against three, or a magnitude against them.
//!
//! What was recorded beside comes first: the engine `explain` says which columns the test instrument follows, and
//! clocks and events are looked for in what these leave; then the columns are weighed again without the disturbed
//! rows and beside the steps, until neither changes. Readings that a recorded column explains are never left out.
//!
//! - `problem` makes a problem of a pair for the engine. `followed` has what it says of a column.
//! - `courses` has what acts without having been recorded: sensors that answer late, lines, steps, codes. `striking` looks
//!   for them in what is `left`, `steps` for steps.
//! - `look` fits all axes under their noise, with the clock's difference. `prepare` alternates between clocks and
//!   events, each with the other removed; events are sought in the test instrument's own rows, with the reference
//!   moved to its moments.
//! - `pauses` and `segments` find an offset of the clock for each stretch between jumps of the times.
//! - `delays` estimates the clock's offset in parts and bands, with the reference moved aside: its noise makes every
//!   offset look small and certain.
//! - `events` finds steps, spikes and disturbed intervals, and the instrument they belong to.
//! - `held_out` says what plain regressions predict of readings that were left out.
//! - `adopt` writes the clocks' difference to the model of a document.
//! - `magnitude` makes a pair of a vector whose field hardly turns and a scalar magnetometer.

pub mod adopt;
mod axes;
mod courses;
mod delays;
pub mod events;
pub mod followed;
mod found;
mod held_out;
mod left;
pub mod look;
pub mod magnitude;
pub mod noise;
mod octaves;
mod pauses;
pub mod prepare;
mod problem;
pub mod residual;
mod segments;
mod steps;
mod striking;
mod words;

pub use common::Error;
pub use courses::{Acting, Given, Uneven};
pub use found::{Asked, Clock, Explanation, Found, LEAST, find};
pub use held_out::{lateness, named, regressions};
pub use words::findings;

use common::Quantity;
use estimate::stats::two_sided_p;

/// What has a smaller probability by chance is told.
pub const TOLD_BELOW: f64 = 0.01;

/// How far a quantity is from a value, in its uncertainties.
pub fn apart(value: f64, quantity: &Quantity) -> f64 {
    ((quantity.value() - value) / std(quantity)).abs()
}

/// Probability of a quantity so far from zero by chance.
pub fn p_of(quantity: &Quantity) -> f64 {
    two_sided_p(quantity.value() / std(quantity), f64::INFINITY)
}

/// Standard uncertainty; infinite where none is stated: nothing is known of it then.
fn std(quantity: &Quantity) -> f64 {
    quantity.std().unwrap_or(f64::INFINITY)
}
