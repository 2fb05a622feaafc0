//! Coverage of the 95 % intervals over simulated months. FLUXCAL_CAMPAIGNS sets how many; a few with fewer rows otherwise.

use common::{AttitudeFrame, Document};
use nalgebra::{Matrix3, Rotation3};
use physics::frames::ARCSEC;
use simulate::{CameraPlan, FlightPlan, SunPlan, flight};
use starcal::{Columns, run};

/// What is allowed of the share of intervals that hold.
const BAND: [f64; 2] = [0.93, 0.97];

struct Found {
    /// Of k, O and the turn of each head, over their standard uncertainties and the coverage factor.
    errors: Vec<f64>,
    /// The largest of a turn, arcsec, and of an offset, nT.
    largest: [f64; 2],
    terms: Vec<String>,
}

fn errors(plan: &FlightPlan) -> Found {
    let made = flight(plan).expect("a plan");
    let columns = Columns { frame: AttitudeFrame::Icrf, ..Columns::default() };
    let document: Document =
        run(made.document, &columns).unwrap_or_else(|error| panic!("{}: {error}", plan.seed));
    let calibration = document.calibration.expect("a calibration");
    let found = calibration.flight.expect("a flight");
    let truth = made.truth;
    // SEN is the frame in which the sensors are nearest to their nominal axes.
    let mu = Matrix3::from_fn(|i, j| truth.mu[j][i]);
    let svd = mu.svd(true, true);
    let own = svd.u.expect("U") * svd.v_t.expect("V");
    let sensors = calibration.sensors.expect("sensors");
    let offset = sensors.get(common::Axis::X).and_then(|one| one.offset_nt.as_ref()).expect("an offset");
    let factor = offset.coverage_factor_95().expect("a factor");
    let (mut all, mut largest) = (Vec::new(), [0.0f64; 2]);
    for (head, rows) in found.cameras.iter().zip(&truth.cameras) {
        let due = Matrix3::from_fn(|i, j| rows[i][j]) * own;
        let turn = Matrix3::from_fn(|i, j| head.rotation[i][j]) * due.transpose();
        let by = Rotation3::from_matrix_unchecked(turn).scaled_axis() / ARCSEC;
        all.extend(by.iter().zip(head.turn_std_arcsec).map(|(error, std)| error / std / factor));
        largest[0] = by.iter().fold(largest[0], |most, one| most.max(one.abs()));
    }
    for (k, (_, sensor)) in sensors.iter().enumerate() {
        let quantities =
            [(&sensor.sensitivity_nt_per_nt, truth.k[k]), (&sensor.offset_nt, truth.offset_nt[k])];
        for (quantity, due) in quantities {
            let quantity = quantity.as_ref().expect("a value");
            all.push((quantity.value() - due) / quantity.std().expect("an uncertainty") / factor);
        }
        let offset = sensor.offset_nt.as_ref().expect("an offset").value() - truth.offset_nt[k];
        largest[1] = largest[1].max(offset.abs());
    }
    let terms = found.terms.into_iter().map(|term| term.term).collect();
    Found { errors: all, largest, terms }
}

/// Months as in docs/starcal.md; without FLUXCAL_CAMPAIGNS a few with fewer rows.
fn covered(name: &str, first: u64, plan: &FlightPlan) {
    let months = testkit::campaigns(0);
    let (count, step_s) = if months > 0 { (months, 60.0) } else { (6, 600.0) };
    let (mut inside, mut all) = (0, 0);
    let mut squares = [0.0; 2];
    let mut terms: Vec<String> = Vec::new();
    for seed in first..first + count {
        let node_deg = (40.0 + 17.0 * seed as f64) % 360.0;
        let found = errors(&FlightPlan { seed, days: 30.0, step_s, node_deg, ..plan.clone() });
        inside += found.errors.iter().filter(|error| error.abs() < 1.0).count();
        all += found.errors.len();
        (0..2).for_each(|k| squares[k] += found.largest[k] * found.largest[k] / count as f64);
        terms.extend(found.terms);
    }
    let [turn, offset] = squares.map(f64::sqrt);
    println!(
        "{name}, {count} months: {inside} of {all} intervals hold; largest error of a turn {turn:.2}\", of an offset {offset:.3} nT, rms; found {terms:?}"
    );
    assert!(testkit::agrees(inside, all, BAND, 2), "{name}: {inside} of {all}");
}

#[test]
fn intervals_hold() {
    let second = CameraPlan { turn_deg: [-140.0, 0.0, 30.0], gap_share: 0.1, ..CameraPlan::default() };
    let plan = FlightPlan { cameras: vec![CameraPlan::default(), second], ..FlightPlan::default() };
    covered("as it is", 201, &plan);
    covered("a field of the Sun", 101, &FlightPlan { sun: SunPlan { lit_nt: 3.0 }, ..plan });
}
