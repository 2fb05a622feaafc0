//! Laws that hold whatever the data: the names of axes, the unit of the field and the choice of GEO do not
//! matter.

use axescal::{AxesProblem, AxesState, Freedom, NoiseFactors, Observations, Options};
use common::{Axis, Document};
use nalgebra::Matrix3;
use physics::frames::{cube_rotations, small_rotation};
use proptest::prelude::*;

fn observations() -> Observations {
    let document =
        Document::parse(&testkit::read_fixture("nasa-1977/table-4.json")).expect("a good document");
    axescal::observe(&document, &Options::default()).expect("readings")
}

fn solved(observations: &Observations, mu: &Matrix3<f64>, eta: &Matrix3<f64>) -> AxesState {
    let start = AxesState::new(*mu, *eta, observations.orientations.len());
    let freedom = Freedom::default();
    let problem = AxesProblem::new(observations, &freedom, NoiseFactors::ONE);
    estimate::solve(&problem, start, None, &estimate::Options::default()).expect("a minimum").state
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn turning_geo_turns_the_coils(turn in prop::array::uniform3(-3.0..3.0f64)) {
        let plain = observations();
        let expected = solved(&plain, &Matrix3::identity(), &Matrix3::identity());
        let q = small_rotation(&turn.into());
        let mut turned = plain.clone();
        for group in &mut turned.orientations {
            group.orientation.rotation *= q.transpose();
        }
        let found = solved(&turned, &Matrix3::identity(), &q);
        prop_assert!((found.mu - expected.mu).amax() < 1e-9);
        prop_assert!((found.eta - q * expected.eta).amax() < 1e-9);
    }

    #[test]
    fn turning_sen_turns_the_sensors(which in 0usize..24) {
        let plain = observations();
        let expected = solved(&plain, &Matrix3::identity(), &Matrix3::identity());
        let q = cube_rotations()[which];
        let mut turned = plain.clone();
        for group in &mut turned.orientations {
            group.orientation.rotation = q * group.orientation.rotation;
        }
        let found = solved(&turned, &q, &Matrix3::identity());
        prop_assert!((found.mu - q * expected.mu).amax() < 1e-9);
        prop_assert!((found.eta - expected.eta).amax() < 1e-9);
    }

    #[test]
    fn the_unit_of_the_field_does_not_matter(factor in 1e-3..1e3f64) {
        let plain = observations();
        let expected = solved(&plain, &Matrix3::identity(), &Matrix3::identity());
        let mut scaled = plain.clone();
        for reading in &mut scaled.readings {
            reading.value_nt *= factor;
            reading.drive_nt *= factor;
            reading.std_nt *= factor;
        }
        let found = solved(&scaled, &Matrix3::identity(), &Matrix3::identity());
        prop_assert!((found.mu - expected.mu).amax() < 1e-9);
        prop_assert!((found.eta - expected.eta).amax() < 1e-9);
    }

    #[test]
    fn the_order_of_readings_and_the_names_of_sensors_do_not_matter(shift in 1usize..62) {
        let plain = observations();
        let expected = solved(&plain, &Matrix3::identity(), &Matrix3::identity());
        let mut renamed = plain.clone();
        renamed.readings.rotate_left(shift);
        for reading in &mut renamed.readings {
            reading.sensor = Axis::ALL[(reading.sensor.index() + 1) % 3];
        }
        let cycle = |matrix: &Matrix3<f64>| Matrix3::from_columns(&[matrix.column(2), matrix.column(0), matrix.column(1)]);
        let found = solved(&renamed, &cycle(&Matrix3::identity()), &Matrix3::identity());
        prop_assert!((found.mu - cycle(&expected.mu)).amax() < 1e-9);
        prop_assert!((found.eta - expected.eta).amax() < 1e-9);
    }
}
