//! Clocks that jump, offsets that scatter, and what noise of the reference does to them.

use common::{ClockDifference, JumpVerdict};

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

/// Noise of the reference makes −dB/dt an uncertain column: without regard to it every offset would seem small and sure.
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
