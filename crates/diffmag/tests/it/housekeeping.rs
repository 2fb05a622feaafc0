//! Housekeeping columns that the difference follows. FLUXCAL_CAMPAIGNS sets how many campaigns.

use common::{Axis, Column, ContributionCause, DifferentialFit, Document, Followed};
use noise::Stream;
use rayon::prelude::*;

use crate::answers::{fit, holds, off};
use crate::pair_in_time::{Made, document};

/// nT/K.
const COEFFICIENT: f64 = 0.4;
/// s.
const LAG_S: f64 = 7200.0;

/// A wandering column: a day's course and a walk.
fn wandering(stream: &mut Stream, made: &Made) -> Vec<f64> {
    let (phase, mut walk) = (std::f64::consts::TAU * stream.normal(), 0.0);
    let day = |t: f64| (std::f64::consts::TAU * t / 86_400.0 + phase).sin();
    made.time(&(0..made.rows))
        .iter()
        .map(|t| {
            walk += 0.03 * stream.normal();
            20.0 + 1.5 * day(*t) + walk
        })
        .collect()
}

/// A pair whose test x follows its temperature, 2 h behind; a voltage goes its own way.
fn campaign(seed: u64, coefficient: f64) -> Document {
    let made = Made { flicker: true, ..Made::new(seed) };
    let mut recording = made.both("pair", 0..made.rows);
    let mut stream = Stream::new(seed, "housekeeping");
    let temperature = wandering(&mut stream, &made);
    let share = 1.0 - (-made.step_s / LAG_S).exp();
    let mut behind = temperature[0];
    for (value, now) in recording.columns["test_x_nt"].iter_mut().zip(&temperature) {
        *value += coefficient * (behind - 20.0);
        behind += share * (now - behind);
    }
    recording.columns.insert("test_temperature_c".into(), Column::from(temperature));
    recording.columns.insert("battery_v".into(), Column::from(wandering(&mut stream, &made)));
    document(vec![recording])
}

fn followed(fit: &DifferentialFit) -> Vec<(Axis, &Followed)> {
    fit.axes.iter().flat_map(|(axis, of)| of.follows.iter().map(move |one| (axis, one))).collect()
}

#[test]
fn a_temperature_is_named_with_its_coefficient_and_lag() {
    let campaigns = testkit::campaigns(4);
    let all: Vec<DifferentialFit> =
        (0..campaigns).into_par_iter().map(|seed| fit(&campaign(seed, COEFFICIENT))).collect();
    let (mut inside, mut lags, mut others) = (0, 0, 0);
    for found in all.iter().map(followed) {
        let (_, one) = found
            .iter()
            .find(|(axis, one)| *axis == Axis::X && one.column == "test_temperature_c")
            .expect("the temperature is named");
        inside += usize::from(holds(&one.nt_per_unit, COEFFICIENT));
        lags += usize::from(holds(one.lag_s.as_ref().expect("a lag"), LAG_S));
        // Other axes take the temperature too where it does better than a drift: with a coefficient of zero.
        others += found.iter().filter(|(_, one)| off(&one.nt_per_unit, 0.0).abs() > 2.58).count() - 1;
    }
    println!(
        "of {campaigns} coefficients {inside}, of lags {lags} within the 95 % interval; {others} others named"
    );
    for within in [inside, lags] {
        assert!(testkit::agrees(within, campaigns as usize, [0.93, 0.97], 2), "{within} of {campaigns}");
    }
    told_with_what_it_leaves(&all[1]);
    // Three axes at one in a hundred.
    assert!(others as f64 <= 0.03 * campaigns as f64 + 3.0 * (0.03 * campaigns as f64).sqrt(), "{others}");
}

#[test]
fn what_does_not_follow_is_not_named() {
    let campaigns = testkit::campaigns(4);
    let named: usize =
        (100..100 + campaigns).into_par_iter().map(|seed| followed(&fit(&campaign(seed, 0.0))).len()).sum();
    println!("{named} named in {campaigns} campaigns of three axes");
    assert!(named as f64 <= 0.03 * campaigns as f64 + 3.0 * (0.03 * campaigns as f64).sqrt(), "{named}");
}

fn told_with_what_it_leaves(fit: &DifferentialFit) {
    let one = fit.contributions.iter().find(|one| one.cause == ContributionCause::Column).expect("told");
    assert_eq!(one.column.as_deref(), Some("test_temperature_c"));
    assert!(
        one.what.contains("x by +0.") && one.what.contains("nT/K") && one.what.contains("behind"),
        "{}",
        one.what
    );
    let (with, without) = (one.rms_with_nt.x.expect("x"), one.rms_without_nt.x.expect("x"));
    assert!(with > 2.0 * without, "{with} {without}");
    let (with, without) = (one.rms_with_nt.y.expect("y"), one.rms_without_nt.y.expect("y"));
    assert!((with - without).abs() < 0.02 * without, "{with} {without}");
    let plot =
        fit.series.iter().find(|series| series.column == "test_x_nt" && series.along == "test_temperature_c");
    let plot = plot.expect("a plot");
    assert_eq!(plot.fitted_nt.len(), plot.x.len());
}
