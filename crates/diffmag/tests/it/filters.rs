//! Filters of one instrument: each is told by its form, and none where there is none.

use common::{DelayBands, DelayForm};
use rayon::prelude::*;

use crate::answers::{fit, holds};
use crate::pair_in_time::{Made, columns, document, recording};

/// The ages that a mean over so long has, and those of a low-pass filter.
fn ages(of: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..24).map(|part| of((f64::from(part) + 0.5) / 24.0)).collect()
}

/// The bands of a pair whose test instrument reads the mean of the field at these ages, s.
fn bands(seed: u64, ages_s: &[f64]) -> DelayBands {
    let made = Made { rows: 2400, ages_s: ages_s.to_vec(), ..Made::new(seed) };
    let time = made.reference_time();
    let of = |name: &str| recording(name, &time, columns(name, &made.read(name), &(0..made.rows)));
    let clock = fit(&document(vec![of("reference"), of("test")])).clock.expect("a clock");
    clock.bands.expect("bands")
}

/// The interval of the length, over pairs. FLUXCAL_CAMPAIGNS sets how many.
#[test]
fn the_length_of_a_running_mean_has_an_interval_that_holds() {
    let count = testkit::campaigns(4);
    let inside = (0..count).into_par_iter().filter(|seed| {
        let length_s = 90.0 + 15.0 * (seed % 6) as f64;
        let found = bands(100 + seed, &ages(|share| length_s * share));
        let told = found.average_s.unwrap_or_default();
        println!("{told} for {length_s} s");
        told.std().is_some() && holds(&told, length_s)
    });
    let inside = inside.count();
    println!("{inside} of {count} lengths in their 95 % intervals");
    assert!(testkit::agrees(inside, count as usize, [0.93, 1.0], 1), "{inside} of {count}");
}

#[test]
fn a_low_pass_filter_and_none_are_no_running_means() {
    for seed in [53, 54] {
        let found = bands(seed, &ages(|share| -60.0 * (1.0 - share).ln()));
        assert!(found.average_s.is_none() && found.form == DelayForm::LowPass, "{found:?}");
        let found = bands(seed, &[0.0]);
        assert!(found.average_s.is_none() && found.form == DelayForm::Constant, "{found:?}");
    }
}
