//! From a plan to the recordings that a campaign would give.
//!
//! The readings come from the same forward model that the calibrations fit ([`physics::predict`]), with
//! noise and quantisation on top. What is true goes to a file of its own, never into the document.
//!
//! A plan says what is stated and what is true. Each procedure (`procedures`) gives `Planned`
//! recordings: conditions, columns that the operator sets, and the operator's steps, from which both the
//! recording and the run sheet are made. `schedule` puts them on one clock. `make` takes each through the
//! true chain: [`physics::predict`] with the field left in the coils, a shield or the natural field around,
//! plus `noise`, rounded to codes. Recordings and channels are made in parallel; each draws from a random
//! stream named after it, so that neither threads nor further channels change it. `replay` is the same
//! prediction from a document.

mod aboard;
mod bench;
mod campaign;
mod differential;
mod effects;
mod flight;
mod make;
mod observatory;
mod orbit;
mod outside;
mod plan;
mod planned;
mod procedures;
mod replay;
mod run_sheet;
mod schedule;
mod sweep;
mod timing;
mod truth;

pub use aboard::KnownField;
pub use campaign::{Campaign, campaign};
pub use differential::{DifferentialTruth, ReferenceAxes, TestAxes, ThirdTruth};
pub use effects::{Layout, catalogue};
pub use flight::{
    BenchPlan, CameraPlan, CurrentPlan, FieldPlan, FlightPlan, FlightTruth, LatencyPlan, MadeFlight,
    SensorsPlan, SunPlan, flight,
};
pub use observatory::{BaselinePlan, Observatory, ObservatoryPlan, TheodolitePlan, observatory};
pub use outside::{OutsidePlan, Site, SiteNoise, SitePlan, Storm};
pub use plan::{CalibrationPart, DriveRecord, Plan, Profile, Temperatures, TruthPlan};
pub use procedures::*;
pub use replay::{Replayed, replay};
pub use run_sheet::{RunSheet, run_sheet};
pub use sweep::{Case, Variation, cases, plan_of};
pub use timing::Timing;
pub use truth::{Electrical, TrueOrientation, Truth, Wander};
