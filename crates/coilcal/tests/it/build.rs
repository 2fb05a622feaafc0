//! What is recorded by a plan, and what coilcal makes of it.

use common::{Calibration, Document};
use serde_json::Value;

/// The recordings of a plan.
pub fn simulated(plan: &Value) -> Document {
    let plan = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    simulate::campaign(&plan).expect("simulated").document
}

pub fn calibrated(document: Document) -> Calibration {
    let found = coilcal::run(document, &coilcal::Options::default());
    found.unwrap_or_else(|error| panic!("{error}")).calibration.expect("a calibration")
}
