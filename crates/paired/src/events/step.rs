//! Steps that were found, and which of them stand: those that last.

use super::found::{CONFIRMED, FoundEvent};
use super::levels::{Levels, Net};

/// A step across disturbed rows needs so many uncertainties, by what the same series does elsewhere; one
/// between two readings has shown in the filter's answer as well.
const SURE: f64 = 6.0;

/// A step of one instrument's axis; `after` is the first row after the disturbed rows across which it was
/// found, else its own.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub event: FoundEvent,
    pub after: usize,
}

impl Step {
    /// Between two readings.
    pub fn between(event: FoundEvent) -> Self {
        Self { after: event.from, event }
    }

    pub fn row(&self) -> usize {
        self.event.from
    }

    /// Whether it is between two readings.
    pub fn sharp(&self) -> bool {
        self.after == self.row()
    }
}

/// Which of the steps that were taken off the `series` are steps: the levels on either side are apart as the
/// same series is nowhere else, by one size for few and for many readings, and for longer than a pass and
/// until the next step.
pub fn standing(series: &[Vec<f64>], eta: &[[f64; 3]], out: &[bool], steps: &[Step]) -> Vec<bool> {
    let levels: Vec<Levels> = series.iter().map(|series| Levels::of(series, out)).collect();
    let shown: Vec<(usize, f64)> = steps.iter().map(|step| step.event.shown(eta)).collect();
    let stands = |(step, (axis, removed)): (&Step, &(usize, f64))| {
        let others =
            || steps.iter().zip(&shown).filter(|(_, (other, _))| other == axis).map(|(step, _)| step.row());
        let start = others().filter(|row| *row < step.row()).max();
        let end = others().filter(|row| *row > step.row()).min();
        let between = start.unwrap_or(0)..end.unwrap_or(out.len());
        let whole = 0..out.len();
        // The next steps are taken off: two that are none may bear each other out where only the rows beyond
        // them count.
        let lasts = |net: Net| {
            [whole.clone(), between.clone()]
                .into_iter()
                .all(|rows| net.agrees(levels[*axis].lasting(step.row(), step.after, *removed, rows)))
        };
        let sure = if step.sharp() { CONFIRMED } else { SURE };
        levels[*axis]
            .net(step.row(), step.after, *removed)
            .is_some_and(|net| net.is_level() && lasts(net) && (net.size / net.std).abs() >= sure)
    };
    steps.iter().zip(&shown).map(stands).collect()
}

/// Which of the events that were taken off differences as steps are steps by what they leave.
pub fn lasting(left: &[Vec<f64>], eta: &[[f64; 3]], out: &[bool], steps: &[&FoundEvent]) -> Vec<bool> {
    let step = |event: &&FoundEvent| {
        let after = (event.from..out.len()).find(|row| !out[*row]).unwrap_or(event.from);
        Step { event: **event, after }
    };
    standing(left, eta, out, &steps.iter().map(step).collect::<Vec<_>>())
}
