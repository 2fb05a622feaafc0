//! Steps and disturbed rows of the differences, by rounds: what is found is taken out before the next look.

use std::collections::BTreeSet;

use common::EventKind;
use estimate::events::{Shape, threshold};

use super::attribution::sources;
use super::found::{Events, FoundEvent};
use super::levels::{LONGEST, Levels, Net, PASS, levelled};
use super::step::{self, Step};
use super::view::{Peak, View};
use crate::look::Look;
use crate::noise::Noise;
use crate::{Error, axes};
use joined::Pair;

/// Probability that a recording without events shows one.
pub const FALSE_ALARM: f64 = 1e-3;
/// Most events that are looked for.
const MOST: usize = 200;
/// Most looks, and after which of them the noise is fitted again.
const LOOKS: usize = 40;
const FIRST_LOOKS: usize = 3;
/// What lies so many rows apart is one disturbance.
const NEAR: usize = 10;
/// In one look no two events are taken from so few rows: each shows in the scores of the other.
const REACH: usize = 256;
/// Steps have settled when no size changes by more than this share of its uncertainty.
const SETTLED: f64 = 0.5;
/// Levels on either side of disturbed rows are taken as unlike for the search above so many uncertainties.
const PROVISIONAL: f64 = 4.0;
/// Steps are a pass where their sum is none within so many of its uncertainties and it is over soon, and so
/// many at most.
const ALIKE: f64 = 4.0;
const MOST_OF_PASS: usize = 4;
/// A spike of more than this share of a step beside it says that the step is one row off.
const MUCH: f64 = 0.25;

/// First and last rows of the disturbed intervals, and rows and axes of the steps.
type Key = (Vec<(usize, usize)>, Vec<(usize, usize)>);

/// What is known so far.
struct Search {
    left: Vec<Vec<f64>>,
    eta: Vec<[f64; 3]>,
    steps: Vec<Step>,
    disturbed: Vec<FoundEvent>,
    out: Vec<bool>,
    /// States that the search has been in, …
    seen: BTreeSet<Key>,
    /// … and rows of peaks that led to no new one.
    spent: BTreeSet<usize>,
    /// Rows whose steps were reassigned to another instrument since peaks were last adopted; each is
    /// reassigned once, so that it cannot go to and fro.
    reassigned: BTreeSet<usize>,
}

/// The events of what a look leaves of a pair whose instruments are at the same moments; of that pair no
/// readings are needed any more. The search begins with those that are `known`.
pub fn search(left: Vec<Vec<f64>>, pair: &Pair, look: &Look, known: &Events) -> Result<Events, Error> {
    let mut noise: Vec<Noise> = look.axes.iter().map(|axis| axis.noise.clone()).collect();
    let mut search = Search::of(left, look, pair, known);
    let least = threshold(pair.whole.len(), FALSE_ALARM / search.left.len() as f64);
    let (mut more, mut last) = (true, None::<View>);
    for round in 0..LOOKS {
        let series = search.cleaned();
        if (1..=FIRST_LOOKS).contains(&round) {
            noise = axes::try_each(series.len(), |axis| Noise::seen(&series[axis], pair))?;
            last = None;
        }
        let view = match &last {
            Some(last) => last.again(&series, &search.out)?,
            None => View::of(&series, pair.step_s, &noise, &search.out)?,
        };
        let view = last.insert(view);
        if !search.refined(view) || !search.attributed(view, least) {
            continue;
        }
        more = search.adopts(view, least);
        if !more || search.steps.len() + search.disturbed.len() > MOST {
            break;
        }
    }
    search.returns();
    Ok(search.events(more))
}

/// Those of these events that are disturbances, or steps that last in what a look beside them leaves and that other
/// parts of the series do not show: a look without them had taken some of each for field or drift.
pub fn standing(left: Vec<Vec<f64>>, pair: &Pair, look: &Look, found: &Events) -> Events {
    let mut search = Search::of(left, look, pair, found);
    search.confirm();
    search.events(found.more)
}

impl Search {
    /// With events that are known.
    fn of(left: Vec<Vec<f64>>, look: &Look, pair: &Pair, known: &Events) -> Self {
        let mut search = Self {
            left,
            eta: look.axes.iter().map(|axis| axis.eta).collect(),
            steps: Vec::new(),
            disturbed: Vec::new(),
            out: pair.whole.iter().map(|whole| !whole).collect(),
            seen: BTreeSet::new(),
            spent: BTreeSet::new(),
            reassigned: BTreeSet::new(),
        };
        for event in &known.found {
            if event.kind == EventKind::Step {
                let (_, after) = search.run(event.from);
                search.steps.push(Step { event: *event, after: after.max(event.from) });
            } else {
                search.out[event.from..=event.to].fill(true);
                search.disturbed.push(*event);
            }
        }
        search
    }

    /// The state: which rows are disturbed, and where the steps are.
    fn key(&self) -> Key {
        let disturbed = self.disturbed.iter().map(|event| (event.from, event.to)).collect();
        let mut steps: Vec<(usize, usize)> =
            self.steps.iter().map(|step| (step.row(), step.event.axis)).collect();
        steps.sort_unstable();
        (disturbed, steps)
    }

    /// The differences without the steps, and with the level around them where rows are out.
    fn cleaned(&self) -> Vec<Vec<f64>> {
        let mut series = self.left.clone();
        for step in &self.steps {
            let parts = step.event.parts(&self.eta);
            for (series, part) in series.iter_mut().zip(parts).filter(|(_, part)| *part != 0.0) {
                series[step.row()..].iter_mut().for_each(|value| *value -= part * step.event.size);
            }
        }
        series.into_iter().map(|series| levelled(series, &self.out)).collect()
    }

    /// Gives steps between readings the sizes of all together; whether they had them.
    fn refined(&mut self, view: &View) -> bool {
        let (eta, out) = (&self.eta, &self.out);
        let steps = self.steps.iter_mut().filter(|step| step.sharp() && !out[step.row()]);
        let mut steps: Vec<&mut FoundEvent> = steps.map(|step| &mut step.event).collect();
        if steps.is_empty() {
            return true;
        }
        let places: Vec<(usize, Vec<f64>)> = steps.iter().map(|step| (step.from, step.parts(eta))).collect();
        let Some(sizes) = view.sizes(&places) else { return true };
        let mut settled = true;
        for (step, (more, std)) in steps.iter_mut().zip(sizes) {
            settled &= more.abs() <= SETTLED * std;
            step.size += more;
            step.std = std;
        }
        settled
    }

    /// Gives the steps between readings to their instruments, now that the others are known; whether they had
    /// them already.
    fn attributed(&mut self, view: &View, least: f64) -> bool {
        let mut rows: Vec<usize> = self.steps.iter().filter(|step| step.sharp()).map(Step::row).collect();
        rows.retain(|row| !self.reassigned.contains(row));
        rows.sort_unstable();
        rows.dedup();
        let mut same = true;
        for row in rows {
            let here = |step: &Step| step.row() == row && step.sharp();
            let own = || self.steps.iter().filter(|step| here(step)).map(|step| &step.event);
            let mut sizes = view.sizes_at(Shape::Step, row);
            for event in own() {
                let parts = event.parts(&self.eta);
                sizes.iter_mut().zip(parts).for_each(|((size, _), part)| *size += part * event.size);
            }
            let again = sources(sizes, least, &self.eta, (EventKind::Step, row));
            let mut known: Vec<_> = own().map(FoundEvent::source).collect();
            let mut found: Vec<_> = again.iter().map(FoundEvent::source).collect();
            known.sort_unstable();
            found.sort_unstable();
            if known != found {
                self.steps.retain(|step| !here(step));
                self.steps.extend(again.into_iter().map(Step::between));
                self.reassigned.insert(row);
                same = false;
            }
        }
        same
    }

    /// Adopts peaks as events until the search is in a new state; whether it is.
    fn adopts(&mut self, view: &View, least: f64) -> bool {
        let mut peaks = view.peaks(least);
        loop {
            peaks.retain(|peak| !self.spent.contains(&peak.row));
            let taken = self.taken(&peaks);
            if taken.is_empty() {
                return false;
            }
            self.seen.insert(self.key());
            self.adopt(&taken, view, least);
            if self.seen.insert(self.key()) {
                self.reassigned.clear();
                return true;
            }
            self.spent.extend(taken.iter().map(|peak| peak.row));
        }
    }

    /// Of the peaks those that belong to what is known, and the largest of those far from each other.
    fn taken(&self, peaks: &[Peak]) -> Vec<Peak> {
        let mut known: Vec<(usize, usize)> =
            self.disturbed.iter().map(|event| (event.from, event.to)).collect();
        known.extend(self.steps.iter().map(|step| (step.row().saturating_sub(1), step.after)));
        let near = |peak: &Peak, (from, to): (usize, usize)| peak.row + NEAR >= from && peak.row <= to + NEAR;
        let mut taken: Vec<Peak> = Vec::new();
        // Peaks in a chain from what is known on belong to it.
        let mut chain = |peaks: &mut dyn Iterator<Item = &Peak>| {
            let mut reached: Option<usize> = None;
            for peak in peaks {
                let follows = reached.is_some_and(|row| peak.row.abs_diff(row) <= NEAR);
                if follows || known.iter().any(|known| near(peak, *known)) {
                    reached = Some(peak.row);
                    taken.push(*peak);
                }
            }
        };
        chain(&mut peaks.iter());
        chain(&mut peaks.iter().rev());
        let mut largest: Vec<&Peak> = peaks.iter().collect();
        largest.sort_by(|a, b| b.z.total_cmp(&a.z).then(a.row.cmp(&b.row)));
        let mut fresh: Vec<Peak> = Vec::new();
        for peak in largest {
            let far = |other: &Peak| other.row.abs_diff(peak.row) > REACH;
            if !taken.iter().any(|other| !far(other)) && fresh.iter().all(far) {
                fresh.push(*peak);
            }
        }
        taken.extend(fresh);
        taken.sort_by_key(|peak| peak.row);
        taken.dedup_by_key(|peak| peak.row);
        taken
    }

    /// Takes peaks for events: what lies close together is a disturbance of all rows between.
    fn adopt(&mut self, peaks: &[Peak], view: &View, least: f64) {
        // First and last row that is out (the last is before the first for a step), and the peak that stands
        // for them.
        let mut sites: Vec<(usize, usize, Option<FoundEvent>)> = Vec::new();
        let mut fresh: Vec<Step> = Vec::new();
        for Peak { shape, row, .. } in peaks.iter().copied() {
            let kind = if shape == Shape::Step { EventKind::Step } else { EventKind::Spike };
            let found = sources(view.sizes_at(shape, row), least, &self.eta, (kind, row));
            if shape == Shape::Spike && self.step_beside(row, &found) {
                continue;
            }
            sites.push((row, if shape == Shape::Step { row - 1 } else { row }, found.first().copied()));
            if shape == Shape::Step {
                fresh.extend(found.into_iter().map(Step::between));
            }
        }
        sites.extend(self.disturbed.drain(..).map(|event| (event.from, event.to, Some(event))));
        let mut steps = std::mem::take(&mut self.steps);
        steps.retain(Step::sharp);
        sites.extend(steps.iter().map(|step| (step.row(), step.row() - 1, Some(step.event))));
        sites.sort_by_key(|(from, to, _)| (*from, *to));
        steps.extend(fresh);
        let mut sites = sites.into_iter().peekable();
        while let Some((from, to, strongest)) = sites.next() {
            let (mut last, mut alone, mut strongest) = (to, true, strongest);
            while let Some((next, until, other)) =
                sites.next_if(|(next, _, _)| *next <= last.max(from) + NEAR)
            {
                alone &= (next, until) == (from, to);
                last = last.max(until);
                let above = |other: &&FoundEvent| {
                    strongest.as_ref().is_none_or(|known| other.z().abs() > known.z().abs())
                };
                strongest = other.filter(|other| above(&other)).or(strongest);
            }
            let is_step = last + 1 == from;
            if alone && is_step {
                // On a row that is out already, it is a step across all of these.
                let (row, after) = self.run(from);
                let mut own: Vec<Step> = steps.iter().filter(|step| step.row() == from).copied().collect();
                own.dedup_by_key(|step| step.event.source());
                if row == after {
                    self.steps.extend(own);
                }
                continue;
            }
            let Some(strongest) = strongest else { continue };
            let last = last.max(from);
            let kind = if from == last { EventKind::Spike } else { EventKind::Interval };
            self.out[from..=last].fill(true);
            self.disturbed.push(FoundEvent { kind, from, to: last, ..strongest });
        }
        self.across();
    }

    /// Moves a step by the row in which a spike of much of its size is left: it stood one row too early or
    /// too late.
    fn step_beside(&mut self, row: usize, spikes: &[FoundEvent]) -> bool {
        let much = |step: &Step, sign: f64| {
            spikes.iter().any(|spike| {
                spike.source() == step.event.source() && sign * spike.size / step.event.size > MUCH
            })
        };
        for step in self.steps.iter_mut().filter(|step| step.sharp()) {
            let later = step.row() == row && much(step, -1.0);
            if later || step.row() == row + 1 && much(step, 1.0) {
                let to = if later { row + 1 } else { row };
                *step = Step::between(FoundEvent { from: to, to, ..step.event });
                return true;
            }
        }
        false
    }

    /// First row of those that are out around a row, and the first after them; the row itself twice where it
    /// is not out.
    fn run(&self, row: usize) -> (usize, usize) {
        let touches = |row: usize| self.out.get(row).copied().unwrap_or(false);
        if !(touches(row) || row > 0 && touches(row - 1)) {
            return (row, row);
        }
        let mut from = row;
        while from > 0 && touches(from - 1) {
            from -= 1;
        }
        let after = (row..self.out.len()).find(|row| !self.out[*row]).unwrap_or(self.out.len());
        (from, after)
    }

    /// Steps across rows that are out: where the levels on either side are not alike.
    fn across(&mut self) {
        let series = self.cleaned();
        let levels: Vec<Levels> = series.iter().map(|series| Levels::of(series, &self.out)).collect();
        let mut row = 0;
        while row < self.out.len() {
            if !self.out[row] {
                row += 1;
                continue;
            }
            let (from, after) = self.run(row);
            row = after;
            if from == 0 || after >= self.out.len() {
                continue;
            }
            let size = |levels: &Levels| {
                let net = levels.net(from, after, 0.0).filter(Net::is_level);
                net.map_or((0.0, f64::INFINITY), |net| (net.size, net.std))
            };
            let sizes = levels.iter().map(size).collect();
            let found = sources(sizes, PROVISIONAL, &self.eta, (EventKind::Step, from));
            self.steps.extend(found.into_iter().map(|event| Step { event, after }));
        }
    }

    /// Steps that together lead back are a pass, and the rows between them are disturbed: of steps that are
    /// each between two readings where too few rows lie between the first and the last to be a level.
    fn returns(&mut self) {
        let shown = |step: &Step| step.event.shown(&self.eta);
        let back = |steps: &[Step]| {
            let (first, last) = (&steps[0], &steps[steps.len() - 1]);
            let reach = if steps.iter().all(Step::sharp) { LONGEST } else { PASS };
            let sum: f64 = steps.iter().map(|step| shown(step).1).sum();
            let variance: f64 = steps.iter().map(|step| step.event.std.powi(2)).sum();
            shown(first).0 == shown(last).0
                && last.row() - first.row() <= reach
                && sum.abs() <= ALIKE * variance.sqrt()
        };
        let mut steps = std::mem::take(&mut self.steps);
        steps.sort_by_key(|step| (shown(step).0, step.row()));
        let mut rest = steps.as_slice();
        while let [first, later @ ..] = rest {
            let Some(count) = (2..=MOST_OF_PASS.min(rest.len())).find(|count| back(&rest[..*count])) else {
                self.steps.push(*first);
                rest = later;
                continue;
            };
            let last = &rest[count - 1];
            let (from, to) = (first.row(), last.after.max(last.row() + 1) - 1);
            let kind = if from == to { EventKind::Spike } else { EventKind::Interval };
            self.out[from..=to].fill(true);
            self.disturbed.push(FoundEvent { kind, from, to, ..first.event });
            rest = &rest[count..];
        }
    }

    /// Leaves those steps that no other part of the series would show, and that are not larger than the
    /// differences are spread.
    fn confirm(&mut self) {
        let series = self.cleaned();
        let spans: Vec<f64> = self.left.iter().map(|left| span(left, &self.out)).collect();
        let stands = step::standing(&series, &self.eta, &self.out, &self.steps);
        let kept = self.steps.iter().zip(stands).filter(|(step, stands)| {
            let (axis, removed) = step.event.shown(&self.eta);
            *stands && removed.abs() <= spans[axis]
        });
        self.steps = kept.map(|(step, _)| *step).collect();
    }

    fn events(self, more: bool) -> Events {
        let mut found = self.disturbed;
        found.extend(self.steps.iter().map(|step| step.event));
        found.sort_by_key(|event| (event.from, event.axis, event.kind == EventKind::Step));
        Events { found, more, ..Events::default() }
    }
}

/// From the least to the largest of the readings that are known.
fn span(series: &[f64], out: &[bool]) -> f64 {
    let known = series.iter().zip(out).filter(|(_, out)| !**out).map(|(value, _)| *value);
    let (low, high) = known
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    (high - low).max(0.0)
}
