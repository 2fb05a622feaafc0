//! Events of a recording, and the recording without them.

use common::{EventInstrument, EventKind};

use crate::look::{Moved, Shift, aligned, late_s};
use joined::Pair;

/// An event whose size under the final fit is below so many of its uncertainties is none.
pub const CONFIRMED: f64 = 4.0;

/// An event of the recording, on the test instrument's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundEvent {
    /// What it is.
    pub kind: EventKind,
    /// Where it is.
    pub instrument: EventInstrument,
    /// Axis of that instrument.
    pub axis: usize,
    /// First row.
    pub from: usize,
    /// Last row; of a step the first.
    pub to: usize,
    /// nT.
    pub size: f64,
    /// nT.
    pub std: f64,
}

impl FoundEvent {
    /// Those of so many test axes whose difference has it.
    pub fn axes(&self, count: usize) -> std::ops::Range<usize> {
        match self.instrument {
            EventInstrument::Reference => 0..count,
            _ => self.axis..self.axis + 1,
        }
    }

    /// Size over uncertainty.
    pub fn z(&self) -> f64 {
        self.size / self.std
    }

    /// The instrument, as a number, and its axis.
    pub(super) fn source(&self) -> (usize, usize) {
        (self.instrument as usize, self.axis)
    }

    /// Its size in each of the differences for a size of one.
    pub(super) fn parts(&self, eta: &[[f64; 3]]) -> Vec<f64> {
        parts(self.instrument, self.axis, eta)
    }

    /// The difference that shows it most, and its size there.
    pub(super) fn shown(&self, eta: &[[f64; 3]]) -> (usize, f64) {
        let parts = self.parts(eta);
        let axis = (0..parts.len()).fold(0, |a, b| if parts[b].abs() > parts[a].abs() { b } else { a });
        (axis, parts[axis] * self.size)
    }
}

/// What an event of an instrument's axis is in each of the differences: of the reference −η.
pub(super) fn parts(instrument: EventInstrument, own: usize, eta: &[[f64; 3]]) -> Vec<f64> {
    let part = |(axis, eta): (usize, &[f64; 3])| match instrument {
        EventInstrument::Reference => -eta[own],
        _ if axis == own => 1.0,
        _ => 0.0,
    };
    eta.iter().enumerate().map(part).collect()
}

/// All events of a recording.
#[derive(Clone, Debug, Default)]
pub struct Events {
    /// In the order of time.
    pub found: Vec<FoundEvent>,
    /// Whether there were more than are looked for.
    pub more: bool,
    /// How many steps, and how many others, the final fit did not confirm.
    pub unconfirmed: [usize; 2],
}

impl Events {
    /// Whether the same rows are taken out and the steps are in the same places.
    pub fn same(&self, other: &Self) -> bool {
        let key = |found: &FoundEvent| (found.kind, found.axis, found.from, found.to);
        self.found.iter().map(key).eq(other.found.iter().map(key))
    }

    /// These without those that are not `kept`.
    pub fn confirmed(&self, kept: &[bool]) -> Self {
        let mut confirmed = Self { found: Vec::new(), ..self.clone() };
        for (event, kept) in self.found.iter().zip(kept) {
            if *kept {
                confirmed.found.push(*event);
            } else {
                confirmed.unconfirmed[usize::from(event.kind != EventKind::Step)] += 1;
            }
        }
        confirmed
    }

    /// The steps alone.
    pub fn steps(&self) -> Self {
        self.only(|kind| kind == EventKind::Step)
    }

    /// All but the steps.
    pub fn disturbances(&self) -> Self {
        self.only(|kind| kind != EventKind::Step)
    }

    fn only(&self, kinds: impl Fn(EventKind) -> bool) -> Self {
        let kept: Vec<bool> = self.found.iter().map(|event| kinds(event.kind)).collect();
        self.confirmed(&kept)
    }

    /// Of each step its places among the steps that are fitted to so many axes, in the order of [`Pair::steps`].
    pub fn places(&self, axes: usize) -> Vec<Vec<Option<usize>>> {
        let mut rows = vec![Vec::new(); axes];
        let place = |event: &FoundEvent| {
            let mut places = vec![None; axes];
            if event.kind == EventKind::Step {
                for axis in event.axes(axes) {
                    let known = rows[axis].iter().position(|row| *row == event.from);
                    places[axis] = known.or_else(|| {
                        rows[axis].push(event.from);
                        Some(rows[axis].len() - 1)
                    });
                }
            }
            places
        };
        self.found.iter().map(place).collect()
    }

    /// The pair without its events, the reference moved to the test instrument's moments.
    pub fn aligned(&self, pair: &Pair, shift: Shift) -> Pair {
        aligned(self.taken_out(pair, shift), shift, Moved::Reference)
    }

    /// The pair without its events: steps taken off, the rows of the others missing. The reference's own rows
    /// are earlier by `shift`.
    pub fn taken_out(&self, pair: &Pair, shift: Shift) -> Pair {
        let mut pair = pair.clone();
        let rows = pair.whole.len();
        for event in &self.found {
            let late = late_s(&pair, shift, event.from) / pair.step_s;
            let own = |row: f64| row.clamp(0.0, rows as f64 - 1.0) as usize;
            let (from, to) = match event.instrument {
                EventInstrument::Reference => {
                    (own((event.from as f64 - late).floor()), own((event.to as f64 - late).ceil()))
                }
                _ => (event.from, event.to),
            };
            if event.kind != EventKind::Step {
                pair.whole[from..=to].fill(false);
                continue;
            }
            let column = match event.instrument {
                EventInstrument::Reference => &mut pair.reference[event.axis],
                _ => &mut pair.test[event.axis],
            };
            column[from..].iter_mut().for_each(|value| *value -= event.size);
            for axis in event.axes(pair.test.len()) {
                if !pair.steps[axis].iter().any(|(row, _)| *row == event.from) {
                    pair.steps[axis].push((event.from, event.std));
                }
            }
        }
        pair.bridge();
        pair
    }
}
