//! Known gradients of the coils at the known places of the sensors: taken off, and uncertain.

use common::{Axis, Document, Quantity};
use physics::frames::ARCSEC;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::json;

use crate::build::{axes, columns, says, simulated, solved};

/// Gradients, nT/(m A), and their standard uncertainty.
const GRADIENTS: [f64; 3] = [300.0, -200.0, 250.0];
const STD: f64 = 1.0;

/// Sensors 5 cm from the centre in coils with gradients. What is uncertain about them turns directions as far
/// as the noise does, and does not show in the scatter of the readings, which would be counted beside it.
fn plan(seed: u64) -> simulate::Plan {
    let mut plan: serde_json::Value =
        serde_json::from_str(&testkit::read_fixture("plans/magsat-axes.json")).expect("JSON");
    plan["seed"] = json!(seed);
    plan["facility"]["theodolite_arcsec"] = json!(0.05);
    plan["instrument"]["noise"] = json!({"white_rms_nt": 0.15});
    plan["instrument"]["positions_m"] =
        json!({"x": [0.05, 0.0, 0.01], "y": [0.0, 0.05, -0.02], "z": [0.02, 0.0, 0.05]});
    for (axis, gradient) in ["x", "y", "z"].iter().zip(GRADIENTS) {
        plan["facility"]["coils"][axis]["gradient_nt_per_m_a"] = json!(gradient);
    }
    simulate::Plan::parse(&plan.to_string()).expect("a plan")
}

/// Errors of the cosines of sensors and coils off the diagonal, with their standard uncertainties, arcsec.
fn errors(document: &Document, truth: &simulate::Truth) -> Vec<(f64, f64)> {
    let (found, meant) = (axes(document), truth.calibration.axes.as_ref().expect("true axes"));
    let mut errors = Vec::new();
    for (found, meant) in [(&found.sensors, &meant.sensors), (&found.coils, &meant.coils)] {
        let off = columns(found) - columns(meant);
        let covariance = found.as_ref().and_then(|part| part.covariance.as_ref()).expect("a covariance");
        for k in (0..9).filter(|k| k % 4 != 0) {
            errors.push((off[(k % 3, k / 3)] / ARCSEC, covariance[k][k].sqrt() / ARCSEC));
        }
    }
    errors
}

#[test]
fn directions_are_found_within_what_the_gradients_leave_uncertain() {
    let campaigns = testkit::campaigns(20);
    let (mut squares, mut exact, mut tried, mut biased, mut largest) = (0.0, 0.0, 0.0, 0.0_f64, 0.0_f64);
    for seed in 0..campaigns {
        let simulate::Campaign { mut document, truth } = simulated(&plan(seed));
        // The document states the gradients as far as they are known.
        let mut generator = ChaCha8Rng::seed_from_u64(seed ^ 0x6AD);
        let coils = document.facility.as_mut().and_then(|facility| facility.coils.as_mut()).expect("coils");
        for (axis, gradient) in Axis::ALL.into_iter().zip(GRADIENTS) {
            let off: f64 = StandardNormal.sample(&mut generator);
            coils.entry(axis).as_mut().expect("a coil").gradient_nt_per_m_a =
                Some(Quantity::new(gradient + STD * off, STD));
        }
        let mut without = document.clone();
        without.instrument.as_mut().expect("an instrument").positions_m = None;
        let mut exactly = document.clone();
        let coils = exactly.facility.as_mut().and_then(|facility| facility.coils.as_mut()).expect("coils");
        for axis in Axis::ALL {
            let gradient = &mut coils.entry(axis).as_mut().expect("a coil").gradient_nt_per_m_a;
            *gradient = gradient.as_ref().map(|stated| Quantity::Bare(stated.value()));
        }
        exact += errors(&solved(exactly), &truth)
            .into_iter()
            .map(|(error, std)| (error / std).powi(2))
            .sum::<f64>();
        let document = solved(document);
        for (error, std) in errors(&document, &truth) {
            squares += (error / std).powi(2);
            tried += 1.0;
            largest = largest.max(std);
        }
        let said = "the coils' known gradients at the sensors' places";
        assert!(says(&document, said), "{:?}", axes(&document).findings);
        biased =
            errors(&solved(without), &truth).into_iter().map(|(error, _)| error.abs()).fold(biased, f64::max);
    }
    let ratio: f64 = squares / tried;
    let as_exact = exact / tried;
    println!(
        "{campaigns} campaigns: errors over stated, squared mean {ratio:.3}, {as_exact:.3} as if the gradients were exact; stated up to \
         {largest:.2}\"; without the gradients {biased:.1}\""
    );
    // Some six independent errors a campaign, four standard deviations.
    let spread = 4.0 * (2.0 / (6.0 * campaigns as f64)).sqrt();
    assert!((ratio - 1.0).abs() < spread, "{ratio}");
    assert!(largest < 3.0 && biased > 20.0, "{largest} {biased}");
    // The same errors, held against what would be stated without the part of the gradients.
    assert!(as_exact > 1.05 * ratio, "{as_exact} as if the gradients were exact");
}
