//! Clocks that jump, offsets that scatter, and what noise of the reference does to them.

use common::{ClockDifference, Document, JumpVerdict};

use crate::pair_in_time::{Made, columns, document, found, recording};

const ROWS: usize = 2400;
const JUMP: usize = 1000;
const BY_S: f64 = 20.0;

fn made(seed: u64) -> Made {
    Made { rows: ROWS, ..Made::new(seed) }
}

fn clock(
    reference: (&[f64], &[Vec<f64>; 3]),
    test: (&[f64], &[Vec<f64>; 3]),
    correct: bool,
) -> ClockDifference {
    let of = |name: &str, (time, read): (&[f64], &[Vec<f64>; 3])| {
        recording(name, time, columns(name, read, &(0..time.len())))
    };
    let found = found(&document(vec![of("reference", reference), of("test", test)]), correct);
    found.fit.expect("a fit").clock.expect("a clock")
}

fn jumped(time: &[f64]) -> Vec<f64> {
    time.iter().enumerate().map(|(row, t)| t + if row < JUMP { 0.0 } else { BY_S }).collect()
}

fn std(of: &common::Quantity) -> f64 {
    of.std().expect("an uncertainty")
}

#[test]
fn times_that_jump_while_the_sampling_goes_on() {
    let made = made(1);
    let (time, reference, test) = (made.reference_time(), made.read("reference"), made.read("test"));
    let found = clock((&time, &reference), (&jumped(&time), &test), false);
    assert_eq!(found.jumps.len(), 1);
    let jump = &found.jumps[0];
    assert_eq!(
        (jump.row, jump.instrument.as_deref(), jump.verdict),
        (JUMP, Some("test"), JumpVerdict::Contradicted)
    );
    let change = jump.offset_change_s.as_ref().expect("a change");
    assert!((change.value() - BY_S).abs() < 3.0 * std(change) && std(change) < 1.0, "{change:?}");
    assert_eq!(found.segments.len(), 2);
    // No rate is made of the jump.
    assert!(found.rate_ppm.value().abs() < 4.0 * std(&found.rate_ppm), "{:?}", found.rate_ppm);
    for segment in &found.segments {
        let rate = segment.rate_ppm.as_ref().expect("a rate");
        assert!(rate.value().abs() < 4.0 * std(rate), "{rate:?}");
    }
    let corrected = clock((&time, &reference), (&jumped(&time), &test), true);
    assert!(corrected.corrected);
    let left = corrected.left_offset_s.expect("what is left");
    assert!(left.value().abs() < 4.0 * std(&left), "{left:?}");
}

#[test]
fn sampling_that_jumps_with_the_times() {
    let later = Made { reference_phase_s: BY_S, ..made(2) };
    let (before, after) = (made(2).read("reference"), later.read("reference"));
    let reference: [Vec<f64>; 3] =
        std::array::from_fn(|axis| [&before[axis][..JUMP], &after[axis][JUMP..]].concat());
    let time = made(2).reference_time();
    let found = clock((&jumped(&time), &reference), (&time, &made(2).read("test")), false);
    assert_eq!(found.jumps.len(), 1);
    let jump = &found.jumps[0];
    assert_eq!(
        (jump.instrument.as_deref(), jump.verdict),
        (Some("reference"), JumpVerdict::Confirmed),
        "{jump:?}"
    );
}

/// Noise of the reference makes −dB/dt an uncertain column: without regard to it every offset would seem
/// small and sure.
#[test]
fn offsets_hold_where_the_reference_is_noisy() {
    let (mut covered, campaigns) = (0, 30);
    for seed in 0..campaigns {
        let made =
            Made { rows: 1440, white_nt: 0.3, reference_share: 1.0, offset_s: 4.0, ..Made::new(100 + seed) };
        let time = made.reference_time();
        let found = clock((&time, &made.read("reference")), (&time, &made.read("test")), false);
        covered += u32::from((found.offset_s.value() - 4.0).abs() < 1.96 * std(&found.offset_s));
    }
    // 95 % of 30 are 28.5; fewer than 25 come by chance once in 100 times.
    assert!(covered >= 25, "{covered} of {campaigns}");
}

#[test]
fn offsets_of_parts_that_differ_are_in_the_interval() {
    let late = |offset_s: f64| Made { offset_s, ..made(3) }.read("test");
    let (first, second) = (late(3.0), late(9.0));
    let test: [Vec<f64>; 3] =
        std::array::from_fn(|axis| [&first[axis][..ROWS / 2], &second[axis][ROWS / 2..]].concat());
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

/// With an offset for each segment in the model, what the document predicts at the test instrument's own
/// times is what it read there.
#[test]
fn each_segment_has_its_clock_in_the_model() {
    let made = Made { offset_s: 40.0, ..made(4) };
    let (time, test) = (jumped(&made.reference_time()), made.read("test"));
    let of = |name: &str, time: &[f64], read: &[Vec<f64>; 3]| {
        recording(name, time, columns(name, read, &(0..time.len())))
    };
    let apart = document(vec![
        of("reference", &made.reference_time(), &made.read("reference")),
        of("test", &time, &test),
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
    let before = made.read("reference");
    let reference = std::array::from_fn(|axis| [&before[axis][..JUMP], &later[axis][JUMP..]].concat());
    let mut both = of("test", &time, &test);
    both.columns.extend(of("reference", &time, &reference).columns);
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

/// Rows of the test instrument from one on carry times that are later by whole steps.
fn set(time: &[f64], steps: usize) -> Vec<f64> {
    let step_s = time[1] - time[0];
    time.iter().enumerate().map(|(row, t)| t + if row < JUMP { 0.0 } else { steps as f64 * step_s }).collect()
}

#[test]
fn a_clock_that_was_set_by_whole_steps_is_told_from_rows_that_are_missing() {
    let made = made(5);
    let (time, reference, test) = (made.reference_time(), made.read("reference"), made.read("test"));
    let found = clock((&time, &reference), (&set(&time, 5), &test), true);
    assert_eq!(found.jumps.len(), 1, "{:?}", found.jumps);
    let jump = &found.jumps[0];
    assert_eq!((jump.row, jump.instrument.as_deref()), (JUMP, Some("test")));
    assert_eq!(jump.verdict, JumpVerdict::Contradicted, "{jump:?}");
    let change = jump.offset_change_s.as_ref().expect("a change");
    assert!((change.value() - 300.0).abs() < 3.0 * std(change) && std(change) < 3.0, "{change:?}");
    assert!(found.segments.len() == 2 && found.corrected);
    let left = found.left_offset_s.expect("what is left");
    assert!(left.value().abs() < 4.0 * std(&left), "{left:?}");
}

/// Three gaps in each recording, at 1 % for all gaps of a recording together. FLUXCAL_CAMPAIGNS sets how many
/// recordings.
#[test]
fn rows_that_are_missing_raise_no_alarm() {
    let mut alarms = 0;
    let recordings = testkit::campaigns(5);
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
