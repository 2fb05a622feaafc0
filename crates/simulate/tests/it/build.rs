//! Plans of the fixtures without what is random.

use common::Axis;
use nalgebra::Matrix3;
use simulate::{Plan, Truth};

pub fn plan(name: &str) -> Plan {
    Plan::parse(&testkit::read_fixture(&format!("plans/{name}.json"))).expect("a plan")
}

/// A plan of which nothing is random, read with all digits.
pub fn quiet(name: &str) -> Plan {
    let mut plan = plan(name);
    let instrument = plan.instrument.as_mut().expect("an instrument");
    (instrument.noise, instrument.quantisation_v, instrument.quantisation_nt) = (None, None, None);
    if let Some(facility) = &mut plan.facility {
        (facility.voltmeter, facility.theodolite_arcsec, facility.reference_std_nt) = (None, None, None);
        for coil in Axis::ALL {
            let coil = facility.coils.as_mut().and_then(|coils| coils.entry(coil).as_mut());
            coil.into_iter().for_each(|coil| coil.resistor_relative_uncertainty = None);
        }
    }
    (plan.truth.site, plan.truth.offset_wander) = (None, None);
    if let Some(differential) = &mut plan.truth.differential {
        differential.reference_noise = None;
    }
    plan
}

/// Unit vectors along the true sensors, and along the coils, as columns; nominal where the truth has none.
pub fn axes(truth: &Truth) -> [Matrix3<f64>; 2] {
    let axes = truth.calibration.axes.as_ref().expect("axes");
    [&axes.sensors, &axes.coils].map(|part| {
        let rows = part.as_ref().and_then(|part| part.matrix.as_ref());
        rows.map_or_else(Matrix3::identity, physics::frames::matrix)
    })
}
