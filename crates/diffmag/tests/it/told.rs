//! What is told first, and the figures behind it.

use common::{Axis, Contribution, ContributionCause, DifferentialFit};
use estimate::stats::rms;

use crate::answers::{found, off};
use crate::pair_in_time::{Made, document};

/// A pair of a day and a half.
fn made(seed: u64, offset_s: f64) -> Made {
    Made { rows: 2160, offset_s, ..Made::new(seed) }
}

fn fit(made: &Made, correct_clock: bool) -> DifferentialFit {
    *found(&document(vec![made.both("pair", 0..made.rows)]), correct_clock).fit.expect("a fit")
}

fn of(fit: &DifferentialFit, cause: ContributionCause) -> &Contribution {
    fit.contributions.iter().find(|one| one.cause == cause).expect("a contribution")
}

/// A clock that is half a minute off is the first thing said, late or early, and its figures are those of the
/// pair with a clock that is right.
#[test]
fn a_clock_is_told_with_what_it_does() {
    let right = fit(&made(5, 0.0), false);
    let causes: Vec<_> = right.contributions.iter().map(|one| one.cause).collect();
    assert!(!causes.contains(&ContributionCause::Clock), "{causes:?}");
    for (offset_s, word) in [(30.0, "late"), (-30.0, "early")] {
        let [left, corrected] = [false, true].map(|correct| fit(&made(5, offset_s), correct));
        // Without the correction the clocks' difference is still told in full.
        let clock = left.clock.as_ref().expect("a clock");
        assert!(!clock.corrected && clock.left_offset_s.is_none() && left.answer.contains("--correct-clock"));
        assert!(off(&clock.offset_s, offset_s).abs() < 4.0, "{clock:?}");
        for one in [&left, &corrected] {
            assert!(one.answer.contains(&format!(" s {word}")), "{}", one.answer);
            assert!(!one.answer.contains('−'), "{}", one.answer);
            assert!(one.answer.contains("with this corrected, x falls from "), "{}", one.answer);
            assert_eq!(one.findings[0], one.answer);
        }
        let [with, without] = [&left, &corrected].map(|fit| of(fit, ContributionCause::Clock));
        assert_eq!([with.taken_off, without.taken_off], [false, true]);
        for axis in Axis::ALL {
            let both = |of: &Contribution| {
                [&of.rms_with_nt, &of.rms_without_nt].map(|rms| *rms.get(axis).expect("an axis"))
            };
            let ([with, without], [again, left]) = (both(with), both(without));
            let noise = right.axes.get(axis).expect("an axis").rms_nt;
            // The same pair, told before the correction and after it.
            assert!((again / with - 1.0).abs() < 0.01 && (left / without - 1.0).abs() < 0.01, "{axis}");
            assert!(with > 2.0 * noise, "{axis}: {with} of {noise}");
            assert!((without / noise - 1.0).abs() < 0.05, "{axis}: {without} of {noise}");
        }
    }
}

/// The largest contribution comes first, and where nothing adds to the difference the matrix is the answer.
#[test]
fn contributions_fall_and_a_good_pair_is_told_by_its_matrix() {
    let good = fit(&made(7, 0.0), false);
    assert!(good.answer.starts_with("the matrix leaves "), "{}", good.answer);
    let mut recording = made(7, 30.0).both("pair", 0..2160);
    recording.columns["test_z_nt"][1000..].iter_mut().for_each(|value| *value += 40.0);
    let stepped = *found(&document(vec![recording]), true).fit.expect("a fit");
    let causes: Vec<_> = stepped.contributions.iter().map(|one| one.cause).collect();
    assert_eq!(causes[..2], [ContributionCause::Steps, ContributionCause::Clock], "{:?}", stepped.findings);
    let reductions: Vec<f64> = stepped.contributions.iter().map(Contribution::reduction_nt2).collect();
    assert!(reductions.is_sorted_by(|a, b| a >= b), "{reductions:?}");
    let steps = of(&stepped, ContributionCause::Steps);
    // Nearly half of the rows are 40 nT higher: 20 nT rms, of which a straight drift takes three quarters of
    // the variance and leaves 10 nT, and the field a little more.
    let [with, without] = [&steps.rms_with_nt, &steps.rms_without_nt].map(|rms| rms.z.expect("z"));
    assert!((6.0..10.0).contains(&with) && without < 0.1, "{with} {without}");
}

/// Series for plots hold what the fit leaves, means of neighbours in order.
#[test]
fn series_are_means_of_what_is_left() {
    let fit = fit(&made(9, 30.0), true);
    let along: Vec<&str> = fit.series.iter().map(|series| series.along.as_str()).collect();
    assert_eq!(along, ["time_s", "field_rate_nt_per_s"].repeat(3));
    for series in &fit.series {
        assert!(series.x.len() <= 120 && series.x.is_sorted());
        let [after, before] = [&series.after_nt, &series.before_nt].map(|values| rms(values));
        assert!(after < 0.3 * before, "{} {}", series.column, series.along);
        assert_eq!(series.fitted_nt.is_empty(), series.along == "time_s");
    }
}
