//! Before the fit: what is wrong with the clocks and with single samples is found, and kept out.

use common::{ClockDifference, Quantity};

use crate::events::{self, Events};
use crate::look::{self, Look, Moved, Shift, aligned, moves};
use crate::{Error, TOLD_BELOW, apart, p_of};
use joined::Pair;

/// Rounds of aligning the clocks and finding events.
const ROUNDS: usize = 12;
/// The clocks are aligned when the next correction is less than this share of its uncertainty.
const SETTLED: f64 = 0.1;

/// The readings as they are to be fitted.
pub struct Prepared {
    /// Without events; on the reference's clock where that was asked for.
    pub pair: Pair,
    /// Which events.
    pub events: Events,
    /// The clocks.
    pub clock: Option<ClockDifference>,
    /// What the events were found with.
    pub shift: Shift,
}

/// Finds the clocks' difference, from a known one on, and the events, each with the other taken out, until neither
/// changes.
///
/// Steps and spikes are looked for in the test instrument's own rows, with the reference moved to its
/// moments: so a sudden change of the field is in both, and no filter spreads a spike of the test instrument.
pub(crate) fn prepare(raw: &Pair, start: Shift, correct_clock: bool) -> Result<Prepared, Error> {
    let (mut shift, mut events) = (start, Events::default());
    let (mut clock, mut last) = (None, None::<Look>);
    let mut searched = None::<Shift>;
    // What was found before by these clocks: an event may come and go by turns.
    let mut before: Vec<Events> = Vec::new();
    for _ in 0..ROUNDS {
        let mut together = events.aligned(raw, shift);
        if let Some(look) = &last {
            look.complete(&mut together)?;
        }
        let look = look::look(&together)?;
        if let Some(moved) = coarse(raw, &events, shift, (&look, &together))? {
            shift = moved;
            last = None;
            continue;
        }
        // With the clocks as they were, what was found is where the search begins.
        let known = if searched == Some(shift) { &events } else { &Events::default() };
        let (left, frame) = {
            let raw = aligned(raw.clone(), shift, Moved::Reference);
            (look.left(&raw, &together), raw.frame())
        };
        drop(together);
        let found = standing(raw, shift, events::search(left, &frame, &look, known)?)?;
        if searched != Some(shift) {
            before = vec![std::mem::take(&mut events)];
        }
        searched = Some(shift);
        let same = before.iter().any(|known| found.same(known));
        before.push(found.clone());
        events = found;
        clock = look.clock.as_ref().map(|left| total(shift, left));
        let near = off(&look) <= SETTLED;
        last = Some(look);
        let due = clock.as_ref().filter(|clock| differ(clock)).map_or(Shift::default(), |clock| Shift {
            offset_s: clock.offset_s.value(),
            rate: clock.rate_ppm.value() * 1e-6,
        });
        if same && (due == shift || (near && !due.is_none())) {
            break;
        }
        shift = due;
    }
    settled(raw, events, clock, shift, correct_clock)
}

/// The events of which the steps last beside a matrix and drifts that are fitted with them taken off.
fn standing(raw: &Pair, shift: Shift, found: Events) -> Result<Events, Error> {
    if found.steps().found.is_empty() {
        return Ok(found);
    }
    let beside = found.aligned(raw, shift);
    let look = look::look(&beside)?;
    let raw = aligned(raw.clone(), shift, Moved::Reference);
    let left = look.left(&raw, &beside);
    Ok(events::standing(left, &raw.frame(), &look, &found))
}

/// A shift by many samples with which the instruments match far better than with the one they have.
fn coarse(
    raw: &Pair,
    events: &Events,
    shift: Shift,
    (look, together): (&Look, &Pair),
) -> Result<Option<Shift>, Error> {
    for by in look.coarse(together)? {
        let moved = Shift { offset_s: shift.offset_s + by.offset_s, rate: shift.rate + by.rate };
        let there = events.aligned(raw, moved);
        if look.is_beaten(together, &look::look(&there)?, &there)? {
            return Ok(Some(moved));
        }
    }
    Ok(None)
}

/// How late the test instrument is where that is many samples, before anything else is known.
pub(crate) fn coarse_shift(raw: &Pair) -> Result<Shift, Error> {
    let mut shift = Shift::default();
    for _ in 0..ROUNDS {
        let together = aligned(raw.clone(), shift, Moved::Reference);
        let look = look::look(&together)?;
        let Some(moved) = coarse(raw, &Events::default(), shift, (&look, &together))? else { break };
        shift = moved;
    }
    Ok(shift)
}

impl Prepared {
    pub(crate) fn none(pair: &Pair) -> Self {
        Self { pair: pair.clone(), events: Events::default(), clock: None, shift: Shift::default() }
    }

    /// Both instruments at the same moments, without events and with the most likely readings where rows are
    /// not whole, and what is seen there.
    pub(crate) fn together(&self, raw: &Pair) -> Result<(Pair, Look), Error> {
        let mut together = self.events.aligned(raw, self.shift);
        let look = look::look(&together)?;
        look.complete(&mut together)?;
        Ok((together, look))
    }

    /// The same with the reference a little later.
    pub(crate) fn moved(&self, raw: &Pair, by_s: f64) -> Pair {
        let shift = Shift { offset_s: self.shift.offset_s + by_s, ..self.shift };
        aligned(self.events.taken_out(raw, self.shift), shift, Moved::Reference)
    }

    /// Whether the clocks are those of a shift, by their uncertainties.
    pub(crate) fn is_near(&self, shift: Shift) -> bool {
        let near = |found: f64, known: f64, std: Option<f64>| {
            found == known || (found - known).abs() <= SETTLED * std.unwrap_or(0.0)
        };
        let (offset_s, rate) =
            self.clock.as_ref().map_or((None, None), |clock| (clock.offset_s.std(), clock.rate_ppm.std()));
        near(self.shift.offset_s, shift.offset_s, offset_s)
            && near(self.shift.rate, shift.rate, rate.map(|ppm| 1e-6 * ppm))
    }

    /// Corrects the times by the offset that the clock has now, if they are corrected at all.
    pub(crate) fn settle(&mut self, raw: &Pair) -> Result<(), Error> {
        let Some(clock) = self.clock.as_ref().filter(|clock| clock.corrected) else { return Ok(()) };
        self.shift.offset_s = clock.offset_s.value();
        *self = settled(raw, self.events.clone(), self.clock.clone(), self.shift, true)?;
        Ok(())
    }
}

/// The readings without these events, the clocks as they were found.
pub fn settled(
    raw: &Pair,
    events: Events,
    mut clock: Option<ClockDifference>,
    shift: Shift,
    correct_clock: bool,
) -> Result<Prepared, Error> {
    let mut pair = events.taken_out(raw, shift);
    if let Some(clock) = clock.as_mut().filter(|_| correct_clock && moves(&pair, shift)) {
        pair = aligned(pair, shift, Moved::Test);
        let look = look::look(&pair)?;
        look.complete(&mut pair)?;
        clock.corrected = true;
        let left = look::look(&pair)?.clock;
        clock.left_offset_s = left.as_ref().map(|left| left.offset_s.clone());
        clock.left_rate_ppm = left.map(|left| left.rate_ppm);
    } else if pair.whole.contains(&false) {
        let look = look::look(&pair)?;
        look.complete(&mut pair)?;
    }
    Ok(Prepared { pair, events, clock, shift })
}

fn differ(clock: &ClockDifference) -> bool {
    p_of(&clock.offset_s).min(p_of(&clock.rate_ppm)) < TOLD_BELOW
}

/// The larger of offset and rate over their uncertainties.
fn off(look: &Look) -> f64 {
    look.clock.as_ref().map_or(0.0, |clock| apart(0.0, &clock.offset_s).max(apart(0.0, &clock.rate_ppm)))
}

fn total(shift: Shift, left: &ClockDifference) -> ClockDifference {
    let sum = |have: f64, left: &Quantity| Quantity::new(have + left.value(), left.std().unwrap_or(0.0));
    ClockDifference {
        offset_s: sum(shift.offset_s, &left.offset_s),
        rate_ppm: sum(shift.rate * 1e6, &left.rate_ppm),
        ..ClockDifference::default()
    }
}
