//! Recordings put together by their times, what is kept out of a fit, and the clocks. FLUXCAL_CAMPAIGNS sets
//! how many campaigns.

use common::{Axis, DifferentialCalibration, EventInstrument, EventKind};
use rayon::prelude::*;
use serde_json::json;

use crate::answers::{Said, elements, fit, found, holds, off, over, share, std};
use crate::natural::{observatory_pair, simulated};
use crate::pair_in_time::{ETA, Made, columns, document, recording};

/// The largest distance of an element from the truth in its standard uncertainties.
fn worst(found: &DifferentialCalibration) -> f64 {
    let fit = found.fit.as_ref().expect("a fit");
    let off = |(name, i, j): (String, usize, usize)| {
        let element = &fit.elements[&name];
        (element.weighted - ETA[i][j]).abs() / element.weighted_std
    };
    elements().map(off).fold(0.0, f64::max)
}

#[test]
fn pieces_of_two_loggers_are_the_recording_of_one() {
    let made = Made::new(1);
    let together = found(&document(vec![made.both("all", 0..made.rows)]), false);
    let cut = |name: &str, id: &str, rows: std::ops::Range<usize>| {
        let mut piece = recording(id, &made.time(&rows), columns(name, &made.read(name), &rows));
        // Each counts its times from its own beginning.
        let begin = piece.columns["time_s"][0];
        piece.columns["time_s"].iter_mut().for_each(|t| *t -= begin);
        piece.start =
            common::time::Start::parse("2026-03-01T00:00:00Z").expect("a start").after(begin).text();
        piece
    };
    let apart = document(vec![
        cut("test", "late", 1500..made.rows),
        cut("reference", "reference", 0..made.rows),
        cut("test", "early", 0..1500),
        cut("third", "third", 0..made.rows),
    ]);
    let apart = found(&apart, false);
    let (a, b) = (together.fit.as_ref().expect("a fit"), apart.fit.as_ref().expect("a fit"));
    assert_eq!(b.recordings, ["late", "reference", "early", "third"]);
    assert_eq!((a.samples, a.missing), (b.samples, b.missing));
    for (name, element) in &a.elements {
        assert!((element.weighted - b.elements[name].weighted).abs() < 1e-12, "{name}");
    }
}

#[test]
fn another_rate_and_another_phase_go_through_the_filter() {
    // The reference faster, and beside the test instrument's times.
    let mut alarms = 0;
    for (case, (ratio, phase)) in (0..).zip([(1.0, 47.0), (5.0, 0.0), (5.0, 7.0), (3.7, 1.0)]) {
        let (mut farthest, mut shares) = (0.0_f64, Vec::new());
        for seed in 10 * case..10 * case + testkit::campaigns(1) {
            let made = Made { reference_step_s: 60.0 / ratio, reference_phase_s: phase, ..Made::new(seed) };
            let rows = 0..made.rows;
            let reference = made.reference_rows();
            let all = document(vec![
                recording(
                    "a",
                    &made.reference_time(),
                    columns("reference", &made.read("reference"), &(0..reference)),
                ),
                recording("b", &made.time(&rows), columns("test", &made.read("test"), &rows)),
            ]);
            let found = found(&all, false);
            let fit = found.fit.as_ref().expect("a fit");
            assert!(fit.findings.iter().any(|f| f.contains("filtered")), "{:?}", fit.findings);
            alarms += usize::from(!fit.kept_out.events.is_empty());
            farthest = farthest.max(worst(&found));
            let white = fit.axes.x.as_ref().expect("x").white_rms_nt.value();
            shares.push(white / made.white_nt);
            let clock = fit.clock.as_ref().expect("a clock");
            assert!(off(&clock.offset_s, 0.0).abs() < 4.5);
        }
        let share = shares.iter().sum::<f64>() / shares.len() as f64;
        println!(
            "ratio {ratio}, phase {phase}: worst element {farthest:.2}σ, white noise {share:.2} of one instrument's"
        );
        assert!(farthest < 4.5, "{farthest}");
    }
    // One in a hundred is meant to have one.
    assert!(alarms <= 1, "{alarms} of {} with an event", 4 * testkit::campaigns(1));
}

#[test]
fn a_missing_reading_is_missing_for_all() {
    let made = Made::new(2);
    let mut recording = made.both("pair", 0..made.rows);
    for (name, rows) in [("test_x_nt", 100..101), ("reference_z_nt", 700..730), ("test_y_nt", 715..760)] {
        recording.columns[name][rows].fill(f64::NAN);
    }
    let found = found(&document(vec![recording]), false);
    let fit = found.fit.as_ref().expect("a fit");
    let gaps: Vec<(f64, f64, usize)> =
        fit.kept_out.gaps.iter().map(|gap| (gap.from_s / 60.0, gap.to_s / 60.0, gap.samples)).collect();
    assert_eq!(gaps, [(100.0, 100.0, 1), (700.0, 759.0, 60)]);
    assert_eq!(fit.missing, 61);
    assert!(fit.kept_out.events.is_empty(), "a bridged gap is no event: {:?}", fit.kept_out.events);
    assert!(worst(&found) < 4.5);
}

#[test]
fn steps_spikes_and_passes_are_found_listed_and_harmless() {
    let made = Made::new(3);
    let mut recording = made.both("pair", 0..made.rows);
    let mut add = |name: &str, rows: std::ops::Range<usize>, size: f64| {
        recording.columns[name][rows].iter_mut().for_each(|value| *value += size);
    };
    add("test_x_nt", 1200..made.rows, 3.0);
    add("test_z_nt", 400..401, 800.0);
    add("reference_y_nt", 2000..2001, 500.0);
    add("reference_x_nt", 2400..made.rows, 60.0);
    // A vehicle: six samples on two axes.
    for (row, size) in (3000..).zip([4.0, 15.0, 40.0, -35.0, -12.0, -3.0]) {
        add("test_x_nt", row..row + 1, size);
        add("test_y_nt", row..row + 1, -0.6 * size);
    }
    let found = found(&document(vec![recording]), false);
    let fit = found.fit.as_ref().expect("a fit");
    let events = &fit.kept_out.events;
    use EventInstrument::{Reference, Test};
    use EventKind::{Interval, Spike, Step};
    let key: Vec<_> = events.iter().map(|e| (e.kind, e.instrument, e.axis)).collect();
    let expected = [
        (Spike, Test, Axis::Z),
        (Step, Test, Axis::X),
        (Spike, Reference, Axis::Y),
        (Step, Reference, Axis::X),
        (Interval, Test, Axis::X),
    ];
    assert_eq!(key, expected);
    let rows: Vec<[usize; 2]> = events.iter().map(|e| e.rows).collect();
    assert_eq!(rows[..4], [[400, 400], [1200, 1200], [2000, 2000], [2400, 2400]]);
    assert!(rows[4][0].abs_diff(3000) <= 1 && rows[4][1].abs_diff(3005) <= 1, "{:?}", rows[4]);
    for (event, size) in events.iter().zip([800.0, 3.0, 500.0, 60.0]) {
        assert!(off(&event.size_nt, size).abs() < 4.0, "{size}: {}", event.size_nt);
    }
    assert_eq!(events[1].time_s, 72_000.0);
    assert!(worst(&found) < 4.5, "{}", worst(&found));
}

#[test]
fn a_spike_between_parallel_axes_is_of_either_instrument() {
    let made = Made::new(4);
    let mut recording = made.both("pair", 0..made.rows);
    recording.columns["test_y_nt"][900] += 12.0 * made.white_nt;
    let events = fit(&document(vec![recording])).kept_out.events;
    let at: Vec<_> = events.iter().map(|event| (event.rows, event.instrument)).collect();
    assert!(at.contains(&([900, 900], EventInstrument::Either)), "{at:?}");
}

/// Shares over campaigns with one spike of 10 and one step of 5 white rms each.
#[test]
fn what_is_kept_out_costs_the_intervals_nothing() {
    let count = testkit::campaigns(3);
    let shares = over("kept out", count, |seed| {
        let made = Made { flicker: seed % 2 == 0, ..Made::new(100 + seed) };
        let mut recording = made.both("pair", 0..made.rows);
        for (name, rows, size) in [
            ("test_x_nt", 1700..made.rows, 20.0),
            ("test_y_nt", 900..901, 15.0),
            ("test_z_nt", 2500..made.rows, -20.0),
        ] {
            let size = size * made.white_nt;
            recording.columns[name][rows].iter_mut().for_each(|value| *value += size);
        }
        let fit = fit(&document(vec![recording]));
        let mut said = Said::default();
        for (name, i, j) in elements() {
            let element = &fit.elements[&name];
            said.holds("η", (element.weighted - ETA[i][j]).abs() <= 1.96 * element.weighted_std);
        }
        fit.axes.iter().for_each(|(_, of)| said.holds("drift", holds(&of.drift.straight_nt_per_day, 0.0)));
        for (row, size) in [(1700, 20.0), (2500, -20.0)] {
            let step = fit.kept_out.events.iter().find(|event| event.rows[0] == row);
            let held = step.is_some_and(|step| holds(&step.size_nt, size * made.white_nt));
            said.holds("size of a step", held);
        }
        said.holds("exactly three events", fit.kept_out.events.len() == 3);
        said
    });
    let slack = |n: f64| 4.0 * (0.95 * 0.05 / (n * count as f64)).sqrt();
    assert!(share(&shares, "exactly three events") >= 0.9);
    assert!((share(&shares, "η") - 0.95).abs() < 0.02 + slack(9.0), "{shares:?}");
    assert!(share(&shares, "size of a step") > 0.93 - slack(2.0), "{shares:?}");
    assert!(share(&shares, "drift") > 0.93 - slack(3.0), "{shares:?}");
}

/// Noise of the reference, and axes that turn in the day's course, pull η while events are looked for; a
/// sudden change of the field must not look like a step then. The matrix rests on long periods only: stretches
/// that are quiet or disturbed are long enough to have them.
#[test]
fn a_sudden_commencement_is_no_step() {
    [json!([28, -6, 9]), json!([112, -24, 36])].into_par_iter().enumerate().for_each(|(seed, sudden_nt)| {
        let mut plan = observatory_pair(10.0);
        plan["seed"] = seed.into();
        plan["truth"]["outside"]["storm"]["sudden_nt"] = sudden_nt;
        let fit = fit(&simulated(&plan).document);
        assert!(fit.kept_out.events.is_empty(), "{seed}: {:?}", fit.kept_out.events);
        let highest = fit.axes.iter().filter_map(|(_, axis)| axis.weighted_up_to_hz);
        let highest = highest.min_by(f64::total_cmp).expect("a band");
        let stability = fit.stability.expect("long enough");
        let silent = stability.findings.iter().any(|finding| finding.contains("cannot be determined"));
        assert!(!silent, "{:?}", stability.findings);
        let compared = stability.quiet_disturbed.expect("ranked");
        assert!(compared.one_matrix.is_some() && compared.stretch_s * highest >= 4.0, "{compared:?}");
        assert!(stability.windows.is_some() && stability.bands.is_some());
    });
}

/// A storm's beginning in a weak field, with a reference noisier than the test instrument, says where the
/// clocks stand; it is limited otherwise in one than in the other when a lag is looked for, and must not look
/// like one. What lags is found all the same.
#[test]
fn a_noisy_reference_and_a_sudden_commencement_make_no_offset() {
    let mut plan = observatory_pair(3.0);
    plan["truth"]["model"]["effects"] = json!([]);
    let outside = &mut plan["truth"]["outside"];
    outside["background"]["flicker_nt2_per_hz_at_1hz"] = 2e-7.into();
    outside["storm"]["time_s"] = 142_560.into();
    outside["storm"]["sudden_nt"] = json!([100, -20, 30]);
    outside["storm"]["unrest"]["flicker_nt2_per_hz_at_1hz"] = 0.into();
    plan["truth"]["differential"]["reference_noise"]["white_rms_nt"] = 0.2.into();
    for late in [0, 3] {
        let all: Vec<(f64, f64, usize)> = (0..testkit::campaigns(1))
            .into_par_iter()
            .map(|seed| {
                let mut plan = plan.clone();
                plan["seed"] = seed.into();
                let mut document = simulated(&plan).document;
                // The test instrument reads now what was there `late` rows ago; before the first row it had
                // read that one.
                for axis in Axis::ALL {
                    let column = &mut document.recordings[0].columns[&format!("test_{axis}_nt")];
                    let first = column[0];
                    column.rotate_right(late);
                    column[..late].fill(first);
                }
                let fit = fit(&document);
                let offset = fit.clock.expect("a clock").offset_s;
                (offset.value() - 60.0 * late as f64, std(&offset), fit.kept_out.events.len())
            })
            .collect();
        println!("{late} rows late: {all:?}");
        assert!(all.iter().all(|(off, std, _)| off.abs() < 4.0 * std && *std < 1.0), "{all:?}");
        assert!(all.iter().all(|(_, _, events)| *events == 0), "{all:?}");
    }
}

/// Offsets of a share of a sample to many samples, with a rate: estimated within their intervals, corrected,
/// and no sudden change of the field is taken for an event.
#[test]
fn the_clock_is_found_and_corrected() {
    let count = testkit::campaigns(2);
    let clocks = vec![(0.0, 0.0), (3.0, 0.0), (30.0, 20.0), (-150.0, 0.0), (2400.0, -50.0)];
    for (offset_s, rate_ppm) in testkit::some(clocks, 2) {
        let shares = over(&format!("{offset_s} s, {rate_ppm} ppm"), count, |seed| {
            let flicker = seed % 2 == 0;
            let made = Made { offset_s, rate_ppm, sudden: true, flicker, ..Made::new(500 + seed) };
            let found = found(&document(vec![made.both("pair", 0..made.rows)]), true);
            let fit = found.fit.as_ref().expect("a fit");
            let clock = fit.clock.as_ref().expect("a clock");
            let mut said = Said::default();
            said.holds("offset", holds(&clock.offset_s, offset_s));
            said.holds("rate", holds(&clock.rate_ppm, rate_ppm));
            said.holds("left", clock.left_offset_s.as_ref().is_none_or(|left| holds(left, 0.0)));
            said.holds("without event", fit.kept_out.events.is_empty());
            said.holds("η within 3.5σ", worst(&found) < 3.5);
            said
        });
        let slack = 3.0 * (0.95 * 0.05 / count as f64).sqrt();
        let least = [
            ("offset", 0.93),
            ("rate", 0.93),
            ("left", 0.95),
            ("without event", 0.97),
            ("η within 3.5σ", 0.97),
        ];
        for (key, least) in least {
            assert!(share(&shares, key) >= least - slack, "{key} of {offset_s} s, {rate_ppm} ppm");
        }
    }
}
