//! Clocks that jump, offsets that scatter, and what noise of the reference does to them.

use common::{ClockDifference, Document, JumpVerdict, Recording};

use crate::answers::{found, holds, off, std};
use crate::pair_in_time::{Made, columns, document, recording};
use rayon::prelude::*;

const ROWS: usize = 2400;
const JUMP: usize = 1000;
const BY_S: f64 = 20.0;

fn made(seed: u64) -> Made {
    Made { rows: ROWS, ..Made::new(seed) }
}

/// Times and readings of an instrument.
type Read<'a> = (&'a [f64], &'a [Vec<f64>; 3]);

fn recorded(name: &str, (time, read): Read<'_>) -> Recording {
    recording(name, time, columns(name, read, &(0..time.len())))
}

fn clock(reference: Read<'_>, test: Read<'_>, correct: bool) -> ClockDifference {
    let both = document(vec![recorded("reference", reference), recorded("test", test)]);
    found(&both, correct).fit.expect("a fit").clock.expect("a clock")
}

/// Times that are later from one row on.
fn jumped(time: &[f64], by_s: f64) -> Vec<f64> {
    time.iter().enumerate().map(|(row, t)| t + if row < JUMP { 0.0 } else { by_s }).collect()
}

/// The readings of one up to a row, then those of another.
fn then(before: &[Vec<f64>; 3], after: &[Vec<f64>; 3], row: usize) -> [Vec<f64>; 3] {
    std::array::from_fn(|axis| [&before[axis][..row], &after[axis][row..]].concat())
}

/// Sixteen samples from the first row to the last: at neither end does the field's slope show it.
#[test]
fn a_clock_that_drifts_by_many_samples() {
    let (offset_s, rate_ppm) = (-400.0, 800.0);
    let made = Made { rows: 20_000, offset_s, rate_ppm, ..Made::new(7) };
    let both = document(vec![made.both("pair", 0..made.rows)]);
    let found = found(&both, true).fit.expect("a fit").clock.expect("a clock");
    assert!(off(&found.offset_s, offset_s).abs() < 3.5 && std(&found.offset_s) < 0.1, "{found:?}");
    assert!(off(&found.rate_ppm, rate_ppm).abs() < 3.5 && std(&found.rate_ppm) < 0.5, "{found:?}");
    assert!(found.left_rate_ppm.is_none_or(|left| off(&left, 0.0).abs() < 3.5));
}

/// By a third of a step, and by whole steps, which rows that are missing would leave as well.
#[test]
fn times_that_jump_while_the_sampling_goes_on() {
    for (seed, by_s) in [(1, BY_S), (5, 300.0)] {
        let made = made(seed);
        let (time, reference, test) = (made.reference_time(), made.read("reference"), made.read("test"));
        let clock = |correct| clock((&time, &reference), (&jumped(&time, by_s), &test), correct);
        let found = clock(false);
        let [jump] = &found.jumps[..] else { panic!("{:?}", found.jumps) };
        assert_eq!((jump.row, jump.instrument.as_deref()), (JUMP, Some("test")));
        assert_eq!(jump.verdict, JumpVerdict::Contradicted, "{jump:?}");
        let change = jump.offset_change_s.as_ref().expect("a change");
        assert!(off(change, by_s).abs() < 3.0 && std(change) < 3.0, "{change:?}");
        assert_eq!(found.segments.len(), 2);
        // No rate is made of the jump.
        let rates = found.segments.iter().map(|segment| segment.rate_ppm.as_ref().expect("a rate"));
        for rate in rates.chain([&found.rate_ppm]) {
            assert!(off(rate, 0.0).abs() < 4.0, "{rate:?}");
        }
        let corrected = clock(true);
        assert!(corrected.corrected);
        let left = corrected.left_offset_s.expect("what is left");
        assert!(off(&left, 0.0).abs() < 4.0, "{left:?}");
    }
}

#[test]
fn sampling_that_jumps_with_the_times() {
    let later = Made { reference_phase_s: BY_S, ..made(2) };
    let reference = then(&made(2).read("reference"), &later.read("reference"), JUMP);
    let time = made(2).reference_time();
    let found = clock((&jumped(&time, BY_S), &reference), (&time, &made(2).read("test")), false);
    let [jump] = &found.jumps[..] else { panic!("{:?}", found.jumps) };
    let expected = (Some("reference"), JumpVerdict::Confirmed);
    assert_eq!((jump.instrument.as_deref(), jump.verdict), expected, "{jump:?}");
}

/// Noise of the reference makes −dB/dt an uncertain column: without regard to it every offset would seem
/// small and sure. FLUXCAL_CAMPAIGNS sets how many pairs.
#[test]
fn offsets_hold_where_the_reference_is_noisy() {
    let campaigns = testkit::campaigns(12);
    let covered = (0..campaigns).into_par_iter().filter(|seed| {
        let made =
            Made { rows: 1440, white_nt: 0.3, reference_share: 1.0, offset_s: 4.0, ..Made::new(100 + seed) };
        let time = made.reference_time();
        let found = clock((&time, &made.read("reference")), (&time, &made.read("test")), false);
        holds(&found.offset_s, 4.0)
    });
    let covered = covered.count();
    assert!(testkit::agrees(covered, campaigns as usize, [0.93, 1.0], 1), "{covered} of {campaigns}");
}

#[test]
fn offsets_of_parts_that_differ_are_in_the_interval() {
    let late = |offset_s: f64| Made { offset_s, ..made(3) }.read("test");
    let test = then(&late(3.0), &late(9.0), ROWS / 2);
    let time = made(3).reference_time();
    let found = clock((&time, &made(3).read("reference")), (&time, &test), false);
    let parts = found.parts.expect("parts");
    // A line through the step leaves half of its 3 s on either side.
    assert!(parts.p < 1e-6 && (parts.between_s - 1.5).abs() < 0.5, "{parts:?}");
    let quarter_s = 0.25 * (time[ROWS - 1] - time[0]);
    for (truth, from_middle_s) in [(3.0, -quarter_s), (9.0, quarter_s)] {
        let told = found.offset_s.value() + 1e-6 * found.rate_ppm.value() * from_middle_s;
        assert!((told - truth).abs() < 2.0 * std(&found.offset_s), "{told}: {:?}", found.offset_s);
    }
}

/// With a rate, and an offset for each segment, in the model, what the document predicts at the test instrument's
/// own times is what it read there.
#[test]
fn each_segment_has_its_clock_in_the_model() {
    let made = Made { offset_s: 40.0, rate_ppm: 20.0, ..made(4) };
    let (time, test) = (jumped(&made.reference_time(), BY_S), made.read("test"));
    let before = made.read("reference");
    let apart = document(vec![
        recorded("reference", (&made.reference_time(), &before)),
        recorded("test", (&time, &test)),
    ]);
    let found = diffmag::run(apart, &diffmag::Options { correct_clock: true }).expect("fitted");
    let effects = &found.model.as_ref().expect("a model").effects;
    let spans: Vec<_> =
        effects.iter().map(|of| (of.effect.as_str(), of.from_s.is_some(), of.to_s.is_some())).collect();
    let known = [("clock_offset", false, true), ("clock_offset", true, false), ("clock_rate", false, false)];
    assert_eq!(spans, known);
    assert_eq!((effects[0].to_s, effects[1].from_s), (Some(time[JUMP]), Some(time[JUMP])));
    // The reference at the times that the test instrument stamped.
    let later = Made { reference_phase_s: BY_S, ..self::made(4) }.read("reference");
    let mut both = recorded("test", (&time, &test));
    both.columns.extend(recorded("reference", (&time, &then(&before, &later, JUMP))).columns);
    let rms = |model: Option<common::Model>| {
        let of_both = Document { recordings: vec![both.clone()], model, ..found.clone() };
        let predicted = simulate::replay(&of_both, None).expect("predicted").document;
        let [read, told] =
            [&of_both, &predicted].map(|of| of.recordings[0].column("test_x_nt").expect("x").to_vec());
        let squares = read.iter().zip(told).skip(5).take(ROWS - 10).map(|(a, b)| (a - b).powi(2));
        (squares.sum::<f64>() / (ROWS - 10) as f64).sqrt()
    };
    let (with, without) = (rms(found.model.clone()), rms(None));
    println!("{with} nT, without the clock {without} nT");
    assert!(with < 0.2 * without && without > 10.0 * made.white_nt);
}

/// Three gaps in each recording, at 1 % for all gaps of a recording together. FLUXCAL_CAMPAIGNS sets how many
/// recordings.
#[test]
fn rows_that_are_missing_raise_no_alarm() {
    let mut alarms = 0;
    let recordings = testkit::campaigns(3);
    for seed in 0..recordings {
        let made = Made { offset_s: 7.0, rate_ppm: 5.0, ..made(300 + seed) };
        let (time, test) = (made.reference_time(), made.read("test"));
        let kept: Vec<usize> = (0..ROWS)
            .filter(|row| [(560, 565), (1200, 1290), (1810, 1811)].iter().all(|(a, b)| row < a || row >= b))
            .collect();
        let of = |values: &[f64]| -> Vec<f64> { kept.iter().map(|row| values[*row]).collect() };
        let with_gaps = test.each_ref().map(|column| of(column));
        let found = clock((&time, &made.read("reference")), (&of(&time), &with_gaps), false);
        alarms += usize::from(!found.jumps.is_empty());
    }
    assert!(testkit::agrees(alarms, recordings as usize, [0.0, 0.01], 1), "{alarms} of {recordings}");
}
