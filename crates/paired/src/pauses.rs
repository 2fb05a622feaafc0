//! Pauses of an instrument's times: rows that are missing, or a clock that was set?
//!
//! Times that leave out whole steps do not say. The field does: where the offset between the clocks is
//! another one after the pause, the clock was set.

use std::ops::Range;

use common::ClockDifference;

use crate::look::Shift;
use crate::segments::{change, common_rate, own};
use crate::{Error, TOLD_BELOW, p_of};
use joined::{Boundary, Pair};

/// Rows on either side, at least, up to the next pause or jump that is looked at.
const BESIDE: usize = 512;
/// Pauses that are looked at, the longest first.
const MOST: usize = 16;

/// Cuts the series at the pauses over which the offset changes, at one false alarm in a hundred recordings
/// however many pauses there are (Bonferroni).
pub fn cut(raw: &mut Pair) -> Result<(), Error> {
    let looked_at = looked_at(raw);
    if looked_at.is_empty() {
        return Ok(());
    }
    let mut bounds: Vec<usize> = raw.segments.iter().map(|segment| segment.rows.start).collect();
    bounds.extend(looked_at.iter().map(|pause| pause.row).chain([raw.whole.len()]));
    bounds.sort_unstable();
    let stretches: Vec<Range<usize>> = bounds.windows(2).map(|pair| pair[0]..pair[1]).collect();
    let clocks = stretches.iter().map(|rows| own(&raw.part(rows.clone()), Shift::default()));
    let clocks: Vec<Option<ClockDifference>> = clocks.collect::<Result<_, _>>()?;
    let rate = common_rate(clocks.iter().flatten());
    let level = TOLD_BELOW / looked_at.len() as f64;
    let is_set = |pause: &&Boundary| {
        let Some(after) = stretches.iter().position(|rows| rows.start == pause.row) else { return false };
        let of = |number: usize| Some((&stretches[number], clocks[number].as_ref()?));
        let sides = of(after - 1).zip(of(after));
        sides.is_some_and(|(from, to)| p_of(&change(raw, from, to, rate.as_ref())) < level)
    };
    let set = looked_at.iter().filter(is_set).cloned().collect();
    raw.cut(set);
    Ok(())
}

/// The longest pauses of one instrument with enough rows on either side.
fn looked_at(raw: &Pair) -> Vec<Boundary> {
    let mut bounds: Vec<usize> = raw.segments.iter().map(|segment| segment.rows.start).collect();
    bounds.push(raw.whole.len());
    let mut longest: Vec<&Boundary> = raw.pauses.iter().filter(|pause| pause.instrument.is_some()).collect();
    longest.sort_by(|a, b| b.jump.all_s.total_cmp(&a.jump.all_s));
    let enough = |rows: Range<usize>| raw.whole[rows].iter().filter(|whole| **whole).count() >= BESIDE;
    let mut found: Vec<Boundary> = Vec::new();
    for pause in longest {
        if found.len() == MOST {
            break;
        }
        // The first bound is row 0, the last one beyond all rows.
        let after = bounds.partition_point(|bound| *bound <= pause.row);
        if enough(bounds[after - 1]..pause.row) && enough(pause.row..bounds[after]) {
            bounds.insert(after, pause.row);
            found.push(pause.clone());
        }
    }
    found
}
