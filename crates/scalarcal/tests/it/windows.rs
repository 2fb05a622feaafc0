//! The calibration in windows of time.

use common::{Document, ScalarStability};
use rayon::prelude::*;
use scalarcal::{Options, stream};

use crate::build::{Campaign, Turns, change, declared, piece, run, scalar, told};

fn windows(length_s: f64) -> Options {
    Options { windows_s: Some(length_s), ..Options::default() }
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
fn a_step_is_told_where_it_is() {
    let campaign = Campaign { rows: 2048, ..Campaign::default() };
    let document = declared(stepped(&campaign, 1), campaign.white_nt);
    for document in [
        run(document.clone(), &windows(256.0)),
        stream::document(&piece(&document, 0..2048), document, &windows(256.0)).expect("a calibration"),
    ] {
        let stability = stability(&document);
        assert!(stability.p_value < 1e-6, "{}", stability.p_value);
        assert_eq!(stability.windows.len(), 8);
        for (number, window) in stability.windows.iter().enumerate() {
            let truth = campaign.offset_nt[0] + if number >= 4 { 2.0 } else { 0.0 };
            let (value, std) = (window.values[3], window.std[3]);
            assert!((value - truth).abs() < 4.0 * std && std < 0.2, "{number}: {value} {std} {truth}");
            assert_eq!(window.rows, 256);
        }
    }
}

#[test]
fn windows_are_as_uncertain_as_they_say() {
    let campaign = Campaign { rows: 2048, ..Campaign::default() };
    let campaigns = testkit::campaigns(8);
    for (name, in_a_stream, white) in
        [("rows", false, false), ("rows, declared white", false, true), ("stream", true, false)]
    {
        let inside: usize = (0..campaigns)
            .into_par_iter()
            .map(|seed| {
                let document = stepped(&campaign, seed);
                let document = if white { declared(document, campaign.white_nt) } else { document };
                let document = if in_a_stream {
                    stream::document(&piece(&document, 0..2048), document, &windows(256.0))
                } else {
                    scalarcal::run(document, &windows(256.0))
                }
                .expect("a calibration");
                let windows = stability(&document).windows.iter().enumerate();
                let truth = campaign.truth();
                windows
                    .map(|(number, window)| {
                        let within = |place: &usize| {
                            let step = if *place == 3 && number >= 4 { 2.0 } else { 0.0 };
                            (window.values[*place] - truth[*place] - step).abs() <= 1.96 * window.std[*place]
                        };
                        (0..9).filter(within).count()
                    })
                    .sum::<usize>()
            })
            .sum();
        let all = campaigns as usize * 8 * 9;
        println!("{name}: {:.1} % of {all} intervals of windows", 100.0 * inside as f64 / all as f64);
        assert!(testkit::agrees(inside, all, [0.93, 0.97], 3), "{name}: {inside} of {all}");
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
