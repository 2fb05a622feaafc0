//! Before the fit: what is wrong with the clocks and with single samples is found, and kept out.

use common::{ClockDifference, EventKind, Quantity};

use crate::clock::{self, Look, Moved, Shift, aligned, moves};
use crate::difference::Noise;
use crate::events::{self, CONFIRMED, Events, FoundEvent};
use crate::regression::{AxisFit, step_sizes};
use crate::residual::{of_levels, scatter};
use crate::significance::p_of;
use crate::{Error, TOLD_BELOW};
use joined::Pair;

/// Rounds of aligning the clocks and finding events.
const ROUNDS: usize = 12;
/// The clocks are aligned when the next correction is less than this share of its uncertainty.
const SETTLED: f64 = 0.1;
/// A step that is not confirmed is none if the final fit is so many of its uncertainties off the size that
/// was found; a fit that rests on long periods may not be able to tell.
const REFUTED: f64 = 3.0;

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

/// Finds the clocks' difference and the events, each with the other taken out, until neither changes.
///
/// Steps and spikes are looked for in the test instrument's own rows, with the reference moved to its
/// moments: so a sudden change of the field is in both, and no filter spreads a spike of the test instrument.
pub fn prepare(raw: &Pair, correct_clock: bool) -> Result<Prepared, Error> {
    let (mut shift, mut events) = (Shift::default(), Events::default());
    let (mut clock, mut last) = (None, None::<Look>);
    let mut searched = None::<Shift>;
    // What was found before by these clocks: an event may come and go by turns.
    let mut before: Vec<Events> = Vec::new();
    for _ in 0..ROUNDS {
        let mut together = aligned(events.taken_out(raw, shift), shift, Moved::Reference);
        if let Some(look) = &last {
            look.complete(&mut together)?;
        }
        let look = clock::look(&together)?;
        if let Some(offset_s) = look.coarse_offset_s(&together)? {
            let moved = Shift { offset_s: shift.offset_s + offset_s, ..shift };
            let there = aligned(events.taken_out(raw, moved), moved, Moved::Reference);
            if look.gain(&together, &clock::look(&there)?, &there)? > clock::GAIN {
                shift = moved;
                last = None;
                continue;
            }
        }
        // With the clocks as they were, what was found is where the search begins.
        let known = if searched == Some(shift) { &events } else { &Events::default() };
        let (left, frame) = {
            let raw = aligned(raw.clone(), shift, Moved::Reference);
            (look.left(&raw, &together), raw.frame())
        };
        drop(together);
        let found = events::search(left, &frame, &look, known)?;
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

impl Prepared {
    /// Both instruments at the same moments, without events and with the most likely readings where rows are
    /// not whole, and what is seen there.
    pub fn together(&self, raw: &Pair) -> Result<(Pair, Look), Error> {
        let mut together = aligned(self.events.taken_out(raw, self.shift), self.shift, Moved::Reference);
        let look = clock::look(&together)?;
        look.complete(&mut together)?;
        Ok((together, look))
    }

    /// The same with the reference a little later.
    pub fn moved(&self, raw: &Pair, by_s: f64) -> Pair {
        let shift = Shift { offset_s: self.shift.offset_s + by_s, ..self.shift };
        aligned(self.events.taken_out(raw, self.shift), shift, Moved::Reference)
    }

    /// Corrects the times by the offset that the clock has now, if they are corrected at all.
    pub fn settle(&mut self, raw: &Pair) -> Result<(), Error> {
        let Some(clock) = self.clock.as_ref().filter(|clock| clock.corrected) else { return Ok(()) };
        self.shift.offset_s = clock.offset_s.value();
        *self = settled(raw, self.events.clone(), self.clock.clone(), self.shift, true)?;
        Ok(())
    }

    /// What the readings are moved by there, s and ppm.
    pub fn moved_by(&self) -> (f64, f64) {
        (self.shift.offset_s, 1e6 * self.shift.rate)
    }

    /// The same without the events that the fit does not confirm; None where it confirms all.
    ///
    /// While events are looked for η is not the final one: noise of the reference, or filters, may pull it at
    /// short periods, and a sudden change of the field then leaves a step.
    pub fn confirmed(&self, raw: &Pair, fits: &[AxisFit; 3]) -> Result<Option<Self>, Error> {
        let sizes = step_sizes(&self.events, fits);
        let stands = |(found, size): (&FoundEvent, Option<Quantity>)| {
            size.is_none_or(|size| over(&size) >= CONFIRMED || apart(found.size, &size) < REFUTED)
        };
        let mut kept: Vec<bool> = self.events.found.iter().zip(sizes).map(stands).collect();
        // With steps taken off no axis leaves more than it would without any fit.
        for (axis, fit) in fits.iter().enumerate() {
            if scatter(&fit.difference, &self.pair.whole) > of_levels(raw, axis) {
                let steps = kept.iter_mut().zip(&self.events.found);
                let own =
                    steps.filter(|(_, found)| found.kind == EventKind::Step && found.axes().contains(&axis));
                own.for_each(|(kept, _)| *kept = false);
            }
        }
        let of_rows = |found: &&FoundEvent| found.kind != EventKind::Step;
        let disturbed: Vec<&FoundEvent> = self.events.found.iter().filter(of_rows).collect();
        if self.events.found.is_empty() {
            return Ok(None);
        }
        let pair = aligned(self.events.steps().taken_out(raw, self.shift), self.shift, Moved::Reference);
        let mut out: Vec<bool> = pair.whole.iter().map(|whole| !whole).collect();
        disturbed.iter().for_each(|event| out[event.from..=event.to].fill(true));
        let left: [Vec<f64>; 3] = std::array::from_fn(|axis| fits[axis].left(&pair, axis));
        let eta = std::array::from_fn(|axis| std::array::from_fn(|i| fits[axis].fit.weighted[i]));
        let steps: Vec<&FoundEvent> =
            self.events.found.iter().filter(|event| event.kind == EventKind::Step).collect();
        let of_steps = kept.iter_mut().zip(&self.events.found).filter(|(_, event)| !of_rows(event));
        let lasting = events::lasting(&left, &eta, &out, &steps);
        of_steps.zip(lasting).for_each(|((kept, _), lasts)| *kept &= lasts);
        if !disturbed.is_empty() {
            let noise: [&Noise; 3] = std::array::from_fn(|axis| &fits[axis].noise);
            let off = events::off(&left, &out, pair.step_s, &noise, &disturbed)?;
            let of_events = kept.iter_mut().zip(&self.events.found).filter(|(_, event)| of_rows(event));
            of_events.zip(off).for_each(|((kept, _), off)| *kept = off);
        }
        if !kept.contains(&false) {
            return Ok(None);
        }
        let correct_clock = self.clock.as_ref().is_some_and(|clock| clock.corrected);
        let events = self.events.confirmed(&kept);
        settled(raw, events, self.clock.clone(), self.shift, correct_clock).map(Some)
    }
}

/// The readings without these events, the clocks as they were found.
fn settled(
    raw: &Pair,
    events: Events,
    mut clock: Option<ClockDifference>,
    shift: Shift,
    correct_clock: bool,
) -> Result<Prepared, Error> {
    let mut pair = events.taken_out(raw, shift);
    if let Some(clock) = clock.as_mut().filter(|_| correct_clock && moves(&pair, shift)) {
        pair = aligned(pair, shift, Moved::Test);
        let look = clock::look(&pair)?;
        look.complete(&mut pair)?;
        clock.corrected = true;
        let left = clock::look(&pair)?.clock;
        clock.left_offset_s = left.as_ref().map(|left| left.offset_s.clone());
        clock.left_rate_ppm = left.map(|left| left.rate_ppm);
    } else if pair.whole.contains(&false) {
        let look = clock::look(&pair)?;
        look.complete(&mut pair)?;
    }
    Ok(Prepared { pair, events, clock, shift })
}

/// Whether the clocks differ.
fn differ(clock: &ClockDifference) -> bool {
    p_of(&clock.offset_s).min(p_of(&clock.rate_ppm)) < TOLD_BELOW
}

fn over(quantity: &Quantity) -> f64 {
    apart(0.0, quantity)
}

/// How far a quantity is from a value, in its uncertainties.
fn apart(value: f64, quantity: &Quantity) -> f64 {
    ((quantity.value() - value) / quantity.std().unwrap_or(f64::INFINITY)).abs()
}

/// The larger of offset and rate over their uncertainties.
fn off(look: &Look) -> f64 {
    look.clock.as_ref().map_or(0.0, |clock| over(&clock.offset_s).max(over(&clock.rate_ppm)))
}

fn total(shift: Shift, left: &ClockDifference) -> ClockDifference {
    let sum = |have: f64, left: &Quantity| Quantity::new(have + left.value(), left.std().unwrap_or(0.0));
    ClockDifference {
        offset_s: sum(shift.offset_s, &left.offset_s),
        rate_ppm: sum(shift.rate * 1e6, &left.rate_ppm),
        ..ClockDifference::default()
    }
}

#[cfg(test)]
mod tests {
    use common::EventInstrument;
    use noise::Stream;

    use super::*;

    const ROWS: usize = 4000;

    /// Two instruments with white noise; the test instrument's x rises by 2 nT at row 1000.
    fn pair() -> Pair {
        let mut stream = Stream::new(11, "prepare");
        let wave = |row: usize, axis: usize| 30.0 * (row as f64 / (90.0 + 40.0 * axis as f64)).sin();
        let field: [Vec<f64>; 3] = std::array::from_fn(|axis| (0..ROWS).map(|row| wave(row, axis)).collect());
        let mut test = field.clone().map(|column| {
            column.into_iter().map(|value| value + 0.1 * stream.normal()).collect::<Vec<f64>>()
        });
        test[0][1000..].iter_mut().for_each(|value| *value += 2.0);
        Pair {
            recordings: vec!["pair".into()],
            first_s: 0.0,
            step_s: 1.0,
            reference: field.map(Into::into),
            test: test.map(Into::into),
            third: None,
            reference_noise: None,
            whole: vec![true; ROWS],
            highest_hz: None,
            steps: Default::default(),
            segments: vec![joined::Segment { rows: 0..ROWS, late_s: 0.0 }],
            boundaries: Vec::new(),
            pauses: Vec::new(),
            step_stds: Default::default(),
            told: Vec::new(),
        }
    }

    fn step(from: usize, size: f64) -> FoundEvent {
        FoundEvent {
            kind: EventKind::Step,
            instrument: EventInstrument::Test,
            axis: 0,
            from,
            to: from,
            size,
            std: 0.05,
            z: size / 0.05,
        }
    }

    #[test]
    fn a_step_that_the_fit_refutes_is_none() {
        let raw = pair();
        let events = Events { found: vec![step(1000, 2.0), step(2500, 1.5)], ..Events::default() };
        let prepared = settled(&raw, events, None, Shift::default(), false).expect("a pair without steps");
        let fits = crate::regression::fit(&prepared.pair, &[]).expect("a fit");
        let confirmed = prepared.confirmed(&raw, &fits).expect("a fit").expect("one step fewer");
        let rows: Vec<usize> = confirmed.events.found.iter().map(|event| event.from).collect();
        assert_eq!((rows, confirmed.events.unconfirmed), (vec![1000], [1, 0]));
        let fits = crate::regression::fit(&confirmed.pair, &[]).expect("a fit");
        assert!(confirmed.confirmed(&raw, &fits).expect("a fit").is_none());
    }
}
