//! Steps that were found, and which of them stand: those that last.

use common::EventKind;

use super::attribution::Source;
use super::found::{CONFIRMED, FoundEvent};
use super::levels::{Levels, Net};

/// A step across disturbed rows needs so many uncertainties, by what the same series does elsewhere; one
/// between two readings has shown in the filter's answer as well.
const SURE: f64 = 6.0;

/// A step of one instrument's axis; `after` is the first row after the disturbed rows across which it was
/// found, else `row`.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub row: usize,
    pub after: usize,
    pub source: Source,
    pub z: f64,
}

impl Step {
    /// An event that is a step, across the rows before `after`.
    pub fn of(found: &FoundEvent, after: usize) -> Self {
        let FoundEvent { instrument, axis, size, std, z, from, .. } = *found;
        Self { row: from, after, source: Source { instrument, axis, size, std }, z }
    }

    /// It as an event.
    pub fn found(&self, kind: EventKind) -> FoundEvent {
        let Source { instrument, axis, size, std } = self.source;
        FoundEvent { kind, instrument, axis, from: self.row, to: self.row, size, std, z: self.z }
    }

    /// Whether it is between two readings.
    pub fn sharp(&self) -> bool {
        self.after == self.row
    }

    /// The difference that shows it most, and its size there.
    pub fn shown(&self, eta: &[[f64; 3]]) -> (usize, f64) {
        let parts = self.source.parts(eta);
        let axis = (0..parts.len()).fold(0, |a, b| if parts[b].abs() > parts[a].abs() { b } else { a });
        (axis, parts[axis] * self.source.size)
    }
}

/// Which of the steps that were taken off the `series` are steps: the levels on either side are apart as the
/// same series is nowhere else, by one size for few and for many readings, and for longer than a pass and
/// until the next step.
pub fn standing(series: &[Vec<f64>], eta: &[[f64; 3]], out: &[bool], steps: &[Step]) -> Vec<bool> {
    let levels: Vec<Levels> = series.iter().map(|series| Levels::of(series, out)).collect();
    let shown: Vec<(usize, f64)> = steps.iter().map(|step| step.shown(eta)).collect();
    let stands = |(step, (axis, removed)): (&Step, &(usize, f64))| {
        let others =
            || steps.iter().zip(&shown).filter(|(_, (other, _))| other == axis).map(|(step, _)| step);
        let start = others().map(|other| other.row).filter(|row| *row < step.row).max();
        let end = others().map(|other| other.row).filter(|row| *row > step.row).min();
        let between = start.unwrap_or(0)..end.unwrap_or(out.len());
        let whole = 0..out.len();
        // The next steps are taken off: two that are none may bear each other out where only the rows beyond
        // them count.
        let lasts = |net: Net| {
            [whole.clone(), between.clone()]
                .into_iter()
                .all(|rows| net.agrees(levels[*axis].lasting(step.row, step.after, *removed, rows)))
        };
        let sure = if step.sharp() { CONFIRMED } else { SURE };
        levels[*axis]
            .net(step.row, step.after, *removed)
            .is_some_and(|net| net.is_level() && lasts(net) && (net.size / net.std).abs() >= sure)
    };
    steps.iter().zip(&shown).map(stands).collect()
}

/// Which of the events that were taken off differences as steps are steps by what they leave.
pub fn lasting(left: &[Vec<f64>], eta: &[[f64; 3]], out: &[bool], steps: &[&FoundEvent]) -> Vec<bool> {
    let step = |found: &&FoundEvent| {
        let after = (found.from..out.len()).find(|row| !out[*row]).unwrap_or(found.from);
        Step::of(found, after)
    };
    standing(left, eta, out, &steps.iter().map(step).collect::<Vec<_>>())
}
