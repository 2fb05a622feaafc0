//! Recordings whose times jump: each segment between jumps has a clock of its own.

use std::ops::Range;

use common::{ClockDifference, ClockJump, ClockSegment, JumpVerdict, Quantity};

use crate::delays;
use crate::look::Shift;
use crate::prepare::prepare;
use crate::{Error, TOLD_BELOW, apart, p_of, std};
use joined::{Boundary, Pair, Segment};

/// Fewer rows than these have no clock of their own.
const LEAST: usize = 64;
/// Fewer rows than these have no rate of their own.
const LEAST_FOR_RATE: usize = 512;
/// What is so many of its uncertainties off is ruled out.
const RULED_OUT: f64 = 3.0;
/// What the field cannot tell to this share of the jump it cannot tell.
const TOLD: f64 = 1.0 / 3.0;

/// Finds the clock of each segment by itself, from a known shift on, and sets how much later its times are than in the
/// longest one.
///
/// A segment whose offset does not differ from that of the longest one (below 1 % by chance) has the same.
pub fn find(raw: &mut Pair, start: Shift) -> Result<(Vec<ClockSegment>, Vec<ClockJump>), Error> {
    if raw.boundaries.is_empty() {
        return Ok(Default::default());
    }
    let many = raw.segments.len() > 1;
    let of = |rows: &Range<usize>| if many { own(&raw.part(rows.clone()), start) } else { Ok(None) };
    let clocks = raw.segments.iter().map(|segment| of(&segment.rows));
    let clocks: Vec<Option<ClockDifference>> = clocks.collect::<Result<_, _>>()?;
    let longest = (0..clocks.len()).rev().max_by_key(|number| raw.segments[*number].rows.len()).unwrap_or(0);
    let offset = |number: usize| clocks[number].as_ref().map(|clock| clock.offset_s.clone());
    let is_long = |segment: &Segment| segment.rows.len() >= LEAST_FOR_RATE;
    let long = raw.segments.iter().zip(&clocks).filter(|(segment, _)| is_long(segment));
    let rate = common_rate(long.filter_map(|(_, clock)| clock.as_ref()));
    for number in 0..clocks.len() {
        let Some(change) = offset(longest).zip(offset(number)).map(|(from, to)| less(&to, &from)) else {
            continue;
        };
        if number != longest && p_of(&change) < TOLD_BELOW {
            raw.segments[number].late_s = change.value();
        }
    }
    let jump = |boundary: &Boundary| {
        let after = raw.segments.iter().position(|segment| segment.rows.start == boundary.row);
        let of = |number: usize| Some((&raw.segments[number].rows, clocks[number].as_ref()?));
        let sides = after.and_then(|after| Some((of(after.checked_sub(1)?)?, of(after)?)));
        jump(boundary, sides.map(|(from, to)| change(raw, from, to, rate.as_ref())))
    };
    let jumps = raw.boundaries.iter().map(jump).collect();
    let segments = raw.segments.iter().zip(&clocks).filter(|_| many);
    let segments = segments.map(|(segment, clock)| ClockSegment {
        from_s: raw.time_s(segment.rows.start),
        to_s: raw.time_s(segment.rows.end - 1),
        offset_s: clock.as_ref().map(|clock| clock.offset_s.clone()),
        rate_ppm: clock.as_ref().filter(|_| is_long(segment)).map(|clock| clock.rate_ppm.clone()),
    });
    Ok((segments.collect(), jumps))
}

/// The rate that clocks have in common, by their uncertainties; None where none has one.
pub fn common_rate<'a>(clocks: impl Iterator<Item = &'a ClockDifference>) -> Option<Quantity> {
    let known = clocks.filter_map(|clock| Some((clock.rate_ppm.value(), clock.rate_ppm.std()?.powi(-2))));
    let (sum, weight) =
        known.fold((0.0, 0.0), |(sum, all), (rate, weight)| (sum + rate * weight, all + weight));
    (weight > 0.0 && weight.is_finite()).then(|| Quantity::new(sum / weight, weight.sqrt().recip()))
}

/// What the offset changes by from one stretch of rows to another, beside what a rate makes of the time
/// between their middles.
pub fn change(
    pair: &Pair,
    from: (&Range<usize>, &ClockDifference),
    to: (&Range<usize>, &ClockDifference),
    rate_ppm: Option<&Quantity>,
) -> Quantity {
    let middle = |rows: &Range<usize>| 0.5 * (rows.start + rows.end) as f64 * pair.step_s;
    let apart = 1e-6 * (middle(to.0) - middle(from.0));
    let all = less(&to.1.offset_s, &from.1.offset_s);
    let Some(rate) = rate_ppm else { return all };
    Quantity::new(all.value() - rate.value() * apart, std(&all).hypot(std(rate) * apart))
}

/// The clock of a segment, from a known shift on; None where it is too short, or where nothing says it.
pub fn own(part: &Pair, start: Shift) -> Result<Option<ClockDifference>, Error> {
    if part.samples() < LEAST {
        return Ok(None);
    }
    let clock = || {
        let mut prepared = prepare(part, start, false)?;
        delays::judge(part, &mut prepared)?;
        Ok(prepared.clock)
    };
    match clock() {
        Ok(clock) => Ok(clock),
        Err(Error::Fit(_) | Error::Unanswerable(_)) => Ok(None),
        Err(other) => Err(other),
    }
}

fn less(to: &Quantity, from: &Quantity) -> Quantity {
    Quantity::new(to.value() - from.value(), std(to).hypot(std(from)))
}

/// What the change of the test instrument's offset says of a jump.
fn jump(boundary: &Boundary, change: Option<Quantity>) -> ClockJump {
    let of = &boundary.jump;
    // Of the reference's times the other way round.
    let sign = if boundary.instrument == Some("reference") { -1.0 } else { 1.0 };
    let change = change.filter(|change| change.std().is_some_and(f64::is_finite));
    let change = change.map(|change| Quantity::new(sign * change.value(), change.std().unwrap_or(0.0)));
    let verdict = change.as_ref().map_or(JumpVerdict::Unclear, |change| verdict(change, of.by_s, of.all_s));
    ClockJump {
        recording: of.recording.clone(),
        instrument: boundary.instrument.map(str::to_string),
        row: of.row,
        time_s: of.at_s,
        by_s: Quantity::new(of.by_s, of.std_s),
        offset_change_s: change,
        verdict,
    }
}

/// The sampling went on: the times are later by all that is more than a step, or by that without the rows
/// that were lost meanwhile.
fn verdict(change: &Quantity, by_s: f64, all_s: f64) -> JumpVerdict {
    let off = |value: f64| apart(value, change);
    let went_on = off(all_s).min(off(by_s)) < RULED_OUT;
    match (off(0.0) < RULED_OUT, went_on) {
        (true, true) => JumpVerdict::Unclear,
        (true, false) if std(change) > TOLD * by_s.abs() => JumpVerdict::Unclear,
        (true, false) => JumpVerdict::Confirmed,
        (false, true) => JumpVerdict::Contradicted,
        (false, false) => JumpVerdict::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_confirmed_contradicted_or_neither() {
        let of = |value: f64, std: f64| verdict(&Quantity::new(value, std), 0.3, 0.3);
        assert_eq!(of(0.302, 0.01), JumpVerdict::Contradicted);
        assert_eq!(of(0.004, 0.01), JumpVerdict::Confirmed);
        assert_eq!(of(0.15, 0.01), JumpVerdict::Other);
        assert_eq!(of(0.15, 0.2), JumpVerdict::Unclear);
        // A whole step and a part of one, of which the step may have been lost.
        let long = |value: f64| verdict(&Quantity::new(value, 0.01), 0.3, 1.3);
        assert_eq!([long(1.3), long(0.3)], [JumpVerdict::Contradicted; 2]);
    }
}
