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

/// Asserts that the readings of Table 4, changed, give the directions that are expected of those they had. The
/// start is changed with them.
fn holds(
    change: impl Fn(&mut Observations),
    start: [Matrix3<f64>; 2],
    expected: impl Fn(AxesState) -> [Matrix3<f64>; 2],
) -> Result<(), TestCaseError> {
    let mut observations = observations();
    let [mu, eta] = expected(solved(&observations, &Matrix3::identity(), &Matrix3::identity()));
    change(&mut observations);
    let found = solved(&observations, &start[0], &start[1]);
    prop_assert!((found.mu - mu).amax() < 1e-9);
    prop_assert!((found.eta - eta).amax() < 1e-9);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn turning_geo_turns_the_coils(turn in prop::array::uniform3(-3.0..3.0f64)) {
        let q = small_rotation(&turn.into());
        let turned = |all: &mut Observations| {
            all.orientations.iter_mut().for_each(|group| group.orientation.rotation *= q.transpose());
        };
        holds(turned, [Matrix3::identity(), q], |state| [state.mu, q * state.eta])?;
    }

    #[test]
    fn turning_sen_turns_the_sensors(which in 0usize..24) {
        let q = cube_rotations()[which];
        let turned = |all: &mut Observations| {
            for group in &mut all.orientations {
                group.orientation.rotation = q * group.orientation.rotation;
            }
        };
        holds(turned, [q, Matrix3::identity()], |state| [q * state.mu, state.eta])?;
    }

    #[test]
    fn the_unit_of_the_field_does_not_matter(factor in 1e-3..1e3f64) {
        let scaled = |all: &mut Observations| {
            for reading in &mut all.readings {
                reading.value_nt *= factor;
                reading.drive_nt *= factor;
                reading.std_nt *= factor;
            }
        };
        holds(scaled, [Matrix3::identity(); 2], |state| [state.mu, state.eta])?;
    }

    #[test]
    fn the_order_of_readings_and_the_names_of_sensors_do_not_matter(shift in 1usize..62) {
        let renamed = |all: &mut Observations| {
            all.readings.rotate_left(shift);
            for reading in &mut all.readings {
                reading.sensor = Axis::ALL[(reading.sensor.index() + 1) % 3];
            }
        };
        let cycle = |matrix: Matrix3<f64>| Matrix3::from_columns(&[matrix.column(2), matrix.column(0), matrix.column(1)]);
        let start = [cycle(Matrix3::identity()), Matrix3::identity()];
        holds(renamed, start, |state| [cycle(state.mu), state.eta])?;
    }
}
