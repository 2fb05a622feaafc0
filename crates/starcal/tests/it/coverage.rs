//! Coverage of the 95 % intervals over simulated months. FLUXCAL_CAMPAIGNS sets how many; a few of few days otherwise.

use common::Document;
use mainfield::Model;
use nalgebra::{Matrix3, Rotation3};
use physics::frames::ARCSEC;
use simulate::{FlightPlan, flight};
use starcal::{Columns, run};

/// What is allowed of the share of intervals that hold.
const BAND: [f64; 2] = [0.93, 0.97];

/// Errors of k, O and the turn of each head over their standard uncertainties and the coverage factor, and turns in arcsec
/// and offsets in nT.
fn errors(plan: &FlightPlan) -> (Vec<f64>, [f64; 2]) {
    let made = flight(plan).expect("a plan");
    let columns = Columns { frame: "icrf".into(), model: Model::Igrf14, ut1_utc_s: 0.0 };
    let document: Document =
        run(made.document, &columns).unwrap_or_else(|error| panic!("{}: {error}", plan.seed));
    let calibration = document.calibration.expect("a calibration");
    let found = calibration.flight.expect("a flight");
    let truth = made.truth;
    // SEN is the frame in which the sensors are nearest to their nominal axes.
    let mu = Matrix3::from_fn(|i, j| truth.mu[j][i]);
    let svd = mu.svd(true, true);
    let own = svd.u.expect("U") * svd.v_t.expect("V");
    let factor = calibration
        .sensors
        .as_ref()
        .and_then(|all| all.get(common::Axis::X)?.offset_nt.as_ref()?.coverage_factor_95());
    let factor = factor.expect("a factor");
    let (mut all, mut largest) = (Vec::new(), [0.0f64; 2]);
    for (head, rows) in found.cameras.iter().zip(&truth.cameras) {
        let due = Matrix3::from_fn(|i, j| rows[i][j]) * own;
        let turn = Matrix3::from_fn(|i, j| head.rotation[i][j]) * due.transpose();
        let by = Rotation3::from_matrix_unchecked(turn).scaled_axis() / ARCSEC;
        all.extend(by.iter().zip(head.turn_std_arcsec).map(|(error, std)| error / std / factor));
        largest[0] = by.iter().fold(largest[0], |most, one| most.max(one.abs()));
    }
    for (k, (_, sensor)) in calibration.sensors.expect("sensors").iter().enumerate() {
        let quantities =
            [(&sensor.sensitivity_nt_per_nt, truth.k[k]), (&sensor.offset_nt, truth.offset_nt[k])];
        for (quantity, due) in quantities {
            let quantity = quantity.as_ref().expect("a value");
            all.push((quantity.value() - due) / quantity.std().expect("an uncertainty") / factor);
        }
        let offset = sensor.offset_nt.as_ref().expect("an offset").value() - truth.offset_nt[k];
        largest[1] = largest[1].max(offset.abs());
    }
    (all, largest)
}

#[test]
fn intervals_hold() {
    let months = testkit::campaigns(0);
    let (count, days, step_s) = if months > 0 { (months, 30.0, 60.0) } else { (6, 10.0, 240.0) };
    let (mut inside, mut all) = (0, 0);
    let mut squares = [0.0; 2];
    for seed in 1..=count {
        let plan =
            FlightPlan { seed, days, step_s, node_deg: 40.0 + 17.0 * seed as f64, ..FlightPlan::default() };
        let (errors, largest) = errors(&plan);
        inside += errors.iter().filter(|error| error.abs() < 1.0).count();
        all += errors.len();
        (0..2).for_each(|k| squares[k] += largest[k] * largest[k] / count as f64);
    }
    let [turn, offset] = squares.map(f64::sqrt);
    println!(
        "{count} flights of {days} days: {inside} of {all} intervals hold; largest error of a turn {turn:.2}\", of an offset {offset:.3} nT, rms"
    );
    assert!(testkit::agrees(inside, all, BAND, 1), "{inside} of {all}");
}
