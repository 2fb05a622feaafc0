//! The calibration in windows of time.

use common::{Document, ScalarStability, ScalarWindow};
use rayon::prelude::*;
use scalarcal::{FitOptions, Options};

use crate::build::{Campaign, Turns, change, declared, result, run, scalar, told};

fn windows(length_s: f64) -> Options {
    Options { fit: FitOptions { windows_s: Some(length_s), ..FitOptions::default() }, ..Options::default() }
}

fn stability(document: &Document) -> &ScalarStability {
    scalar(document).stability.as_ref().expect("windows")
}

/// Offsets that step by 2 nT in the second half.
fn stepped(campaign: &Campaign, seed: u64) -> Document {
    let mut document = campaign.document(seed);
    let step = 2.0 / campaign.sensitivity[0];
    change(&mut document, "sensor_x_v", |row, value| if row >= 1024 { value - step } else { value });
    document
}

#[test]
fn a_step_is_told_where_it_is_and_windows_are_as_uncertain_as_they_say() {
    let campaign = Campaign { rows: 2048, ..Campaign::default() };
    let (truth, campaigns) = (campaign.truth(), testkit::campaigns(8));
    // Of how many of the nine parameters in eight windows the intervals hold.
    let inside = |seed: u64, in_one_pass: bool, white: bool| -> usize {
        let document = stepped(&campaign, seed);
        let document = if white { declared(document, campaign.white_nt) } else { document };
        let document = result(document, &windows(256.0), in_one_pass).expect("a calibration");
        let ScalarStability { windows, p_value, .. } = stability(&document);
        assert!(*p_value < 1e-6 || !white, "{seed}: {p_value}");
        assert!(windows.len() == 8 && windows.iter().all(|window| window.rows == 256));
        assert!(!white || windows.iter().all(|window| window.std[3] < 0.2));
        let within = |place: usize| {
            let (window, parameter) = (place / 9, place % 9);
            let step = if parameter == 3 && window >= 4 { 2.0 } else { 0.0 };
            let ScalarWindow { values, std, .. } = &windows[window];
            (values[parameter] - truth[parameter] - step).abs() <= 1.96 * std[parameter]
        };
        (0..8 * 9).filter(|place| within(*place)).count()
    };
    for (in_one_pass, white) in [(false, false), (false, true), (true, false), (true, true)] {
        let inside: usize = (0..campaigns).into_par_iter().map(|seed| inside(seed, in_one_pass, white)).sum();
        let all = campaigns as usize * 8 * 9;
        println!("one pass {in_one_pass}, white {white}: {inside} of {all} intervals of windows");
        assert!(testkit::agrees(inside, all, [0.93, 0.97], 4), "{in_one_pass} {white}: {inside} of {all}");
    }
}

#[test]
fn windows_that_do_not_determine_the_sensors_have_no_values() {
    let campaign = Campaign { rows: 2048, turns: Turns::Slow, ..Campaign::default() };
    let document = run(campaign.document(2), &windows(70.0));
    let parts = &stability(&document).windows;
    assert_eq!(parts.len(), 30);
    assert!(parts.iter().any(|window| window.values.is_empty() && window.std.is_empty()));
    let none = scalarcal::run(campaign.document(2), &windows(1e-4));
    assert!(told(none).contains("use longer ones"));
}
