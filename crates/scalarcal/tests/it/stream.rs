//! One pass against rows at hand, and pieces in any order and grouping against one pass.

use common::{Document, ScalarCalibration};
use partial::{Take, merge, parse, to_line};
use physics::Unit;
use scalarcal::stream::{self, Partial, Statistics};
use scalarcal::{FitOptions, Options, Source};

use std::cell::RefCell;
use std::ops::Range;

use crate::build::{Campaign, change, declared, findings, found, near, piece, run, scalar, take};

fn answer(partial: &Partial, document: &Document) -> Document {
    stream::document(partial, document.clone(), &FitOptions::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The largest difference of two calibrations, in standard uncertainties; that of these is relative.
fn apart(one: &Document, other: &Document) -> f64 {
    let pairs = found(one).into_iter().zip(found(other));
    let parameters = pairs.map(|((a, std), (b, other))| ((a - b) / std).abs().max((std / other - 1.0).abs()));
    let (one, other) = (scalar(one), scalar(other));
    let relative = |a: f64, b: f64| (a / b - 1.0).abs();
    let offset = |of: &ScalarCalibration| of.reference_offset.as_ref().expect("asked").offset_nt.clone();
    let (a, b) = (offset(one), offset(other));
    let rest = [
        relative(one.rms_nt, other.rms_nt),
        relative(one.rms_before_nt.expect("stated"), other.rms_before_nt.expect("stated")),
        (a.value() - b.value()).abs() / b.std().expect("a std"),
        relative(a.std().expect("a std"), b.std().expect("a std")),
    ];
    parameters.chain(rest).fold(0.0, f64::max)
}

/// A recording of which sensor z ends at ±7 V.
fn clipped(seed: u64, rows: usize) -> Document {
    let campaign = Campaign { rows, ..Campaign::default() };
    let mut document = declared(campaign.document(seed), campaign.white_nt);
    change(&mut document, "sensor_z_v", |_, value| value.clamp(-7.0, 7.0));
    document
}

#[test]
fn one_pass_is_what_the_rows_at_hand_say() {
    for noise in [0.5, 48.0] {
        for clip in [false, true] {
            let campaign = Campaign { rows: 3000, white_nt: noise, ..Campaign::default() };
            let document = if clip { clipped(3, 3000) } else { declared(campaign.document(3), noise) };
            let rows = run(document.clone(), &Options::default());
            let pass = answer(&piece(&document, 0..3000), &document);
            let distance = apart(&rows, &pass);
            println!("{noise} nT, clipped: {clip}: {distance:.1e}");
            assert!(distance < 1e-6, "{distance}");
            assert_eq!(scalar(&rows).left_out, scalar(&pass).left_out);
            let at_the_end = scalar(&pass).left_out.contains_key("sensor z at the end of its range");
            assert_eq!((scalar(&rows).rows, clip), (scalar(&pass).rows, at_the_end));
            near(&found(&rows), &campaign.truth());
            assert_eq!(findings(&rows), findings(&pass));
        }
    }
}

#[test]
fn batches_do_not_matter() {
    let document = clipped(4, 2000);
    let whole = to_line(&piece(&document, 0..2000));
    for batch in [1, 7, 1000] {
        let mut statistics = Statistics::new(Unit::Volt, Source::Scalar);
        for from in (0..2000).step_by(batch) {
            take(&mut statistics, &document, from..(from + batch).min(2000));
        }
        assert_eq!(to_line(&statistics.finish().expect("a piece")), whole, "{batch}");
    }
    let read: Partial = parse(&whole).expect("a piece");
    assert_eq!(to_line(&read), whole);
    println!("{} bytes", whole.len());
    assert!(whole.len() < 400_000 && !whole.contains('\n'));
}

#[test]
fn pieces_in_any_order_and_grouping() {
    let document = RefCell::new((0, clipped(0, 3000)));
    let piece = |seed: u64, rows: Range<usize>| {
        let mut document = document.borrow_mut();
        if document.0 != seed {
            *document = (seed, clipped(seed, 3000));
        }
        piece(&document.1, rows)
    };
    testkit::partials_merge(12, 3000, piece, |one: &Partial, other: &Partial| {
        let document = clipped(0, 3000);
        let [one_answer, other_answer] = [one, other].map(|partial| answer(partial, &document));
        let distance = apart(&one_answer, &other_answer);
        let windows = |answer: &Document| -> Vec<(f64, f64, u64)> {
            let stability = scalar(answer).stability.clone().expect("windows");
            stability.windows.iter().map(|window| (window.from_s, window.to_s, window.rows)).collect()
        };
        let counts = |partial: &Partial| (partial.rows, partial.missing, partial.span_s());
        match (counts(one) == counts(other), windows(&one_answer) == windows(&other_answer)) {
            (true, true) if distance < 1e-6 => Ok(()),
            (rows, windows) => Err(format!("{distance:e}; rows the same: {rows}, windows: {windows}")),
        }
    });
}

#[test]
fn widths_of_any_ratio_are_joined() {
    // A minute in milliseconds, and a year later two days in minutes.
    let campaign = Campaign { rows: 3000, ..Campaign::default() };
    let document = declared(campaign.document(5), campaign.white_nt);
    let timed = |from_s: f64, step_s: f64, seed: u64| {
        let mut document = declared(campaign.document(seed), campaign.white_nt);
        let times: Vec<f64> = (0..3000).map(|row| from_s + step_s * f64::from(row)).collect();
        document.recordings[0].columns.insert("time_s".into(), times.into());
        piece(&document, 0..3000)
    };
    let (minute, days) = (timed(0.0, 0.02, 5), timed(3e7, 60.0, 6));
    let one = merge(vec![minute.clone(), days.clone()]).expect("apart");
    let other = merge(vec![days, minute]).expect("apart");
    let distance = apart(&answer(&one, &document), &answer(&other, &document));
    assert!(distance < 1e-6, "{distance}");
    assert_eq!(one.rows, 6000);
    let answer = answer(&one, &document);
    let windows = &scalar(&answer).stability.as_ref().expect("windows").windows;
    assert!((2..=8).contains(&windows.len()) && windows[0].to_s < 61.0 && windows[0].rows == 3000);
    assert_eq!(windows.iter().map(|window| window.rows).sum::<u64>(), 6000);
}
