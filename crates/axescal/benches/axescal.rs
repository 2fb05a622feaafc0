//! Speed of a solve, with a single decomposition of the same size as its peer in the same run.

use axescal::{AxesProblem, AxesState, Freedom, NoiseFactors, Observations, Options};
use common::Document;
use faer::Mat;
use nalgebra::Matrix3;
use rayon::prelude::*;

fn main() {
    divan::main();
}

fn document(fixture: &str) -> Document {
    Document::parse(&testkit::read_fixture(fixture)).expect("a good document")
}

fn observations() -> Observations {
    axescal::observe(&document("nasa-1977/table-4.json"), &Options::default()).expect("readings")
}

fn solve(observations: &Observations, freedom: &Freedom) -> f64 {
    let start = AxesState::new(Matrix3::identity(), Matrix3::identity(), observations.orientations.len());
    let problem = AxesProblem::new(observations, freedom, NoiseFactors::ONE);
    estimate::solve(&problem, start, None, &estimate::Options::default()).expect("a minimum").cost
}

/// The peer: one singular value decomposition of the 63×12 matrix that every step needs.
#[divan::bench]
fn peer_one_svd_63x12(bencher: divan::Bencher) {
    let matrix = Mat::from_fn(63, 12, |i, j| ((i * 37 + j * 11) % 23) as f64 - 11.0);
    bencher.bench(|| matrix.thin_svd().expect("finite"));
}

/// Seven orientations from the identity to the minimum.
#[divan::bench]
fn solve_seven_orientations(bencher: divan::Bencher) {
    let observations = observations();
    bencher.bench(|| solve(&observations, &Freedom::default()));
}

/// The whole stage on the parsed document: solve, doubtful readings, leave-one-out, bounds, result.
#[divan::bench]
fn whole_stage(bencher: divan::Bencher) {
    let document = document("nasa-1977/table-4.json");
    bencher.bench(|| axescal::run(document.clone(), &Options::default()).expect("a result"));
}

/// 10 000 campaigns of seven orientations with theodolite corrections, on all cores: each from the minimum of
/// one of them.
#[divan::bench(sample_count = 3)]
fn monte_carlo_10_000(bencher: divan::Bencher) {
    let mut observations = observations();
    let arcsec = physics::frames::ARCSEC;
    observations
        .orientations
        .iter_mut()
        .for_each(|g| g.orientation.uncertainty = Matrix3::identity() * arcsec);
    let freedom = Freedom { orientations: true, ..Freedom::default() };
    bencher.bench(|| {
        let start = AxesState::new(Matrix3::identity(), Matrix3::identity(), observations.orientations.len());
        let first = AxesProblem::new(&observations, &freedom, NoiseFactors::ONE);
        let options = estimate::Options::default();
        let first = estimate::solve(&first, start, None, &options).expect("a minimum").state;
        (0..10_000u64)
            .into_par_iter()
            .map(|campaign| {
                let mut noisy = observations.clone();
                for (k, reading) in noisy.readings.iter_mut().enumerate() {
                    let phase = (campaign as f64 * 0.618 + k as f64 * 0.414).fract();
                    reading.value_nt += 2.0 * phase - 1.0;
                }
                let problem = AxesProblem::new(&noisy, &freedom, NoiseFactors::ONE);
                estimate::solve(&problem, first.clone(), None, &options).expect("a minimum").cost
            })
            .sum::<f64>()
    });
}
