//! From a plan to the recordings that a campaign would give.
//!
//! The readings come from the same forward model that the calibrations fit ([`physics::predict`]), with
//! noise and quantisation on top. What is true goes to a file of its own, never into the document.

mod aboard;
mod bench;
mod campaign;
mod differential;
mod effects;
mod make;
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
pub use outside::{OutsidePlan, Site, SiteNoise, SitePlan, Storm};
pub use plan::{CalibrationPart, DriveRecord, Plan, Profile, Temperatures, TruthPlan};
pub use procedures::*;
pub use replay::{Replayed, replay};
pub use run_sheet::{RunSheet, run_sheet};
pub use sweep::{Case, Variation, cases, plan_of};
pub use timing::Timing;
pub use truth::{Electrical, TrueOrientation, Truth, Wander};
