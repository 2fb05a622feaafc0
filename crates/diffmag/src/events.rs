//! Steps and spikes of the difference, in the test instrument or in the reference.

use common::{EventInstrument, EventKind};
use estimate::events::{Event, Search, Shape, fill, threshold};
use estimate::stats;
use physics::memory::bridged;

use crate::Error;
use crate::clock::{Look, Shift, late_s};
use crate::difference::Noise;
use crate::series::Pair;

/// Probability that a recording without events shows one.
pub const FALSE_ALARM: f64 = 0.01;
/// Most events that are looked for.
pub const MOST: usize = 200;
/// Rounds of finding events and fitting the noise without them.
const ROUNDS: usize = 6;
/// Rounds in which the sizes are fitted together.
const SWEEPS: usize = 8;
/// Events so many rows apart are one disturbance.
const NEAR: usize = 3;
/// An instrument is ruled out when what it does not explain is so improbable …
const RULED_OUT: f64 = 1e-3;
/// … beyond this share of the whole, which an error of η explains.
const OF_ETA: f64 = 1e-6;
/// An event whose size under the final fit is below so many of its uncertainties is none.
pub const CONFIRMED: f64 = 4.0;

/// An event of the recording, on the test instrument's clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
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
    /// Size over uncertainty.
    pub z: f64,
}

impl Found {
    /// Test axes whose difference has it.
    fn axes(&self) -> std::ops::Range<usize> {
        match self.instrument {
            EventInstrument::Reference => 0..3,
            _ => self.axis..self.axis + 1,
        }
    }
}

/// All events of a recording.
#[derive(Clone, Debug, Default)]
pub struct Events {
    /// In the order of time.
    pub found: Vec<Found>,
    /// Whether there were more than are looked for.
    pub more: bool,
    /// How many steps, and how many others, the final fit did not confirm.
    pub unconfirmed: [usize; 2],
}

impl Events {
    /// Whether the same rows are taken out and the steps are in the same places.
    pub fn same(&self, other: &Self) -> bool {
        let key = |found: &Found| (found.kind, found.axis, found.from, found.to);
        self.found.iter().map(key).eq(other.found.iter().map(key))
    }

    /// These without those that are not `kept`.
    pub fn confirmed(&self, kept: &[bool]) -> Self {
        let mut confirmed = Self { found: Vec::new(), ..self.clone() };
        for (event, kept) in self.found.iter().zip(kept) {
            if *kept {
                confirmed.found.push(event.clone());
            } else {
                confirmed.unconfirmed[usize::from(event.kind != EventKind::Step)] += 1;
            }
        }
        confirmed
    }

    /// The steps alone.
    pub fn steps(&self) -> Self {
        let kept: Vec<bool> = self.found.iter().map(|event| event.kind == EventKind::Step).collect();
        self.confirmed(&kept)
    }

    /// Of each step its places among the steps that are fitted to the axes, in the order of [`Pair::steps`].
    pub fn places(&self) -> Vec<[Option<usize>; 3]> {
        let mut rows: [Vec<usize>; 3] = Default::default();
        let place = |event: &Found| {
            let mut places = [None; 3];
            if event.kind == EventKind::Step {
                for axis in event.axes() {
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

    /// The pair without its events: steps taken off, the rows of the others missing. The reference's own rows are earlier by `shift`.
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
            for steps in &mut pair.steps[event.axes()] {
                if !steps.contains(&event.from) {
                    steps.push(event.from);
                }
            }
        }
        pair.bridge();
        pair
    }
}

/// A step or spike of one instrument's axis.
struct Single {
    instrument: EventInstrument,
    axis: usize,
    event: Event,
}

/// The events of a pair whose instruments are at the same moments, given a fit of it without those that are known, `calm`.
pub fn search(pair: &Pair, calm: &Pair, look: &Look) -> Result<Events, Error> {
    let left: [Vec<f64>; 3] = std::array::from_fn(|axis| look.left(pair, calm, axis));
    let eta: [[f64; 3]; 3] = std::array::from_fn(|axis| look.axes[axis].eta);
    let mut out: Vec<bool> = pair.whole.iter().map(|whole| !whole).collect();
    let (mut disturbed, mut steps): (Vec<Found>, Vec<Single>) = (Vec::new(), Vec::new());
    let mut own: Option<[Noise; 3]> = None;
    let mut more = false;
    for _ in 0..ROUNDS {
        let noise: [&Noise; 3] =
            std::array::from_fn(|axis| own.as_ref().map_or(&look.axes[axis].noise, |own| &own[axis]));
        // Rows that are out stand between the levels on either side.
        let mut series = cleaned(&left, &steps, &eta, &out, pair.step_s, &noise)?;
        steps.iter().for_each(|step| add(&mut series, step, &eta, 1.0));
        let (singles, full) = pursue(&series, pair.step_s, &noise, &eta)?;
        more = full;
        let (again, new) = grouped(singles, &out);
        let key = |step: &Single| (step.instrument, step.axis, step.event.row);
        let settled = new.is_empty() && again.iter().map(key).eq(steps.iter().map(key));
        steps = again;
        new.iter().for_each(|event| out[event.from..=event.to].fill(true));
        disturbed.extend(new);
        if settled {
            break;
        }
        let without = cleaned(&left, &steps, &eta, &out, pair.step_s, &noise)?;
        let fit = |axis: usize| Noise::seen(&without[axis], pair);
        own = Some([fit(0)?, fit(1)?, fit(2)?]);
    }
    let mut found = joined(disturbed);
    found.extend(steps.iter().map(|step| step.found(EventKind::Step)));
    found.sort_by_key(|event| (event.from, event.axis));
    Ok(Events { found, more, ..Events::default() })
}

/// Whether in rows that are out a difference is off what stands around them: by [`CONFIRMED`] uncertainties of a single reading.
///
/// `left` are the differences with the readings of these rows in them; `out` are all rows that are out.
pub fn off(
    left: &[Vec<f64>; 3],
    out: &[bool],
    step_s: f64,
    noise: &[&Noise; 3],
    disturbed: &[&Found],
) -> Result<Vec<bool>, Error> {
    let mut off = vec![false; disturbed.len()];
    for (left, noise) in left.iter().zip(noise) {
        let density = |f: f64| noise.level(f);
        let likely = fill(left, out, step_s, &density)?;
        let search = Search::new(&likely, step_s, &density)?;
        for (off, event) in off.iter_mut().zip(disturbed) {
            let far =
                |row: usize| (left[row] - likely[row]).abs() >= CONFIRMED * search.size(Shape::Spike, row).1;
            *off |= (event.from..=event.to).any(far);
        }
    }
    Ok(off)
}

impl Single {
    fn found(&self, kind: EventKind) -> Found {
        let Event { row, size, std, z, .. } = self.event;
        Found { kind, instrument: self.instrument, axis: self.axis, from: row, to: row, size, std, z }
    }

    /// Its size in each of the differences: of the reference −η times its own.
    fn parts(&self, eta: &[[f64; 3]; 3]) -> [f64; 3] {
        std::array::from_fn(|axis| match self.instrument {
            EventInstrument::Reference => -eta[axis][self.axis],
            _ if axis == self.axis => 1.0,
            _ => 0.0,
        })
    }
}

/// Adds a step to the three differences, `share` times.
fn add(series: &mut [Vec<f64>; 3], step: &Single, eta: &[[f64; 3]; 3], share: f64) {
    for (series, part) in series.iter_mut().zip(step.parts(eta)).filter(|(_, part)| *part != 0.0) {
        series[step.event.row..].iter_mut().for_each(|value| *value += share * part * step.event.size);
    }
}

/// The differences without the steps, and with their most likely values where rows are out.
fn cleaned(
    left: &[Vec<f64>; 3],
    steps: &[Single],
    eta: &[[f64; 3]; 3],
    out: &[bool],
    step_s: f64,
    noise: &[&Noise; 3],
) -> Result<[Vec<f64>; 3], Error> {
    let mut series = left.clone();
    steps.iter().for_each(|step| add(&mut series, step, eta, -1.0));
    let rows: Vec<f64> = (0..out.len()).map(|row| row as f64).collect();
    for (column, noise) in series.iter_mut().zip(noise) {
        column.iter_mut().zip(out).filter(|(_, out)| **out).for_each(|(value, _)| *value = f64::NAN);
        let straight = bridged(&rows, std::mem::take(column));
        *column = fill(&straight, out, step_s, &|f| noise.density(f))?;
    }
    Ok(series)
}

/// Steps and spikes of the three differences together, the largest first; and whether there are more.
fn pursue(
    series: &[Vec<f64>; 3],
    step_s: f64,
    noise: &[&Noise; 3],
    eta: &[[f64; 3]; 3],
) -> Result<(Vec<Single>, bool), Error> {
    let search = |axis: usize| Search::new(&series[axis], step_s, &|f| noise[axis].density(f));
    let mut searches = [search(0)?, search(1)?, search(2)?];
    let least = threshold(series[0].len(), FALSE_ALARM / 3.0);
    let mut singles: Vec<Single> = Vec::new();
    let mut more = true;
    for _ in 0..MOST {
        let largest = searches.each_ref().map(Search::largest);
        let axis = (0..3).fold(0, |a, b| if largest[b].z.abs() > largest[a].z.abs() { b } else { a });
        if largest[axis].z.abs() < least {
            more = false;
            break;
        }
        let single = attributed(&searches, axis, largest[axis], eta);
        remove(&mut searches, &single, eta, single.event.size);
        let same = |known: &&mut Single| {
            (known.instrument, known.axis, known.event.shape, known.event.row)
                == (single.instrument, single.axis, single.event.shape, single.event.row)
        };
        match singles.iter_mut().find(same) {
            Some(known) => known.event.size += single.event.size,
            None => singles.push(single),
        }
        // A size that was found beside a larger event is wrong by some of that one.
        refit(&mut searches, &mut singles, eta);
    }
    let mut singles = attributed_anew(&mut searches, singles, least, eta);
    let wide = [Shape::Step, Shape::Spike]
        .map(|shape| searches.iter().map(|search| search.scale(shape)).fold(1.0, f64::max));
    for single in &mut singles {
        single.event.z /= wide[single.event.shape as usize];
    }
    singles.retain(|single| {
        let kept = single.event.z.abs() >= least;
        if !kept {
            remove(&mut searches, single, eta, -single.event.size);
        }
        kept
    });
    (0..SWEEPS).for_each(|_| refit(&mut searches, &mut singles, eta));
    Ok((singles, more))
}

/// The sizes of all, each with the others as they are.
fn refit(searches: &mut [Search; 3], singles: &mut [Single], eta: &[[f64; 3]; 3]) {
    for single in singles {
        let (size, _) = sized(searches, &single.parts(eta), single.event.shape, single.event.row);
        remove(searches, single, eta, size);
        single.event.size += size;
    }
}

/// The same events, each place's attributed with all other places' taken out: when it was found, some were not.
fn attributed_anew(
    searches: &mut [Search; 3],
    mut singles: Vec<Single>,
    least: f64,
    eta: &[[f64; 3]; 3],
) -> Vec<Single> {
    let mut done: Vec<Single> = Vec::new();
    while let Some(Event { shape, row, .. }) = singles.first().map(|single| single.event) {
        let (here, others) =
            singles.into_iter().partition(|single| (single.event.shape, single.event.row) == (shape, row));
        singles = others;
        let here: Vec<Single> = here;
        here.iter().for_each(|single| remove(searches, single, eta, -single.event.size));
        for _ in 0..=here.len() {
            let sizes = searches.each_ref().map(|search| search.size(shape, row));
            let z = sizes.map(|(size, std)| size / std);
            let axis = (0..3).fold(0, |a, b| if z[b].abs() > z[a].abs() { b } else { a });
            if z[axis].abs() < least {
                break;
            }
            let event = Event { shape, row, size: sizes[axis].0, std: sizes[axis].1, z: z[axis] };
            let single = attributed(searches, axis, event, eta);
            remove(searches, &single, eta, single.event.size);
            done.push(single);
        }
    }
    done
}

fn remove(searches: &mut [Search; 3], single: &Single, eta: &[[f64; 3]; 3], size: f64) {
    for (search, part) in searches.iter_mut().zip(single.parts(eta)).filter(|(_, part)| *part != 0.0) {
        search.remove(single.event.shape, single.event.row, part * size);
    }
}

/// Size and uncertainty of a shape that the differences share in the proportions `parts`.
fn sized(searches: &[Search; 3], parts: &[f64; 3], shape: Shape, row: usize) -> (f64, f64) {
    let (mut above, mut below) = (0.0, 0.0);
    for (search, part) in searches.iter().zip(parts) {
        let (size, std) = search.size(shape, row);
        above += part * size / (std * std);
        below += (part / std).powi(2);
    }
    if below > 0.0 { (above / below, below.sqrt().recip()) } else { (0.0, f64::INFINITY) }
}

/// The instrument that an event belongs to: the reference where the other differences have it in the proportions of η and one axis of
/// the test instrument does not explain it, the test instrument where it is the other way about or neither does.
fn attributed(searches: &[Search; 3], axis: usize, event: Event, eta: &[[f64; 3]; 3]) -> Single {
    let Event { shape, row, .. } = event;
    let all: f64 = searches
        .iter()
        .map(|search| {
            let (size, std) = search.size(shape, row);
            (size / std).powi(2)
        })
        .sum();
    let limit = stats::chi_squared_quantile(1.0 - RULED_OUT, 2.0) + OF_ETA * all;
    let test = Single { instrument: EventInstrument::Test, axis, event };
    let gain = |(size, std): (f64, f64)| (size / std).powi(2);
    let reference = (0..3)
        .map(|own| {
            let mut single = Single { instrument: EventInstrument::Reference, axis: own, event };
            let (size, std) = sized(searches, &single.parts(eta), shape, row);
            (single.event.size, single.event.std, single.event.z) = (size, std, size / std);
            single
        })
        .max_by(|a, b| a.event.z.abs().total_cmp(&b.event.z.abs()));
    let in_test = all - gain((event.size, event.std)) < limit;
    match reference {
        Some(single) if all - gain((single.event.size, single.event.std)) < limit => {
            if in_test {
                Single { instrument: EventInstrument::Either, ..test }
            } else {
                single
            }
        }
        _ => test,
    }
}

/// Lone steps, and disturbances made of what lies close together. What lies in rows that are out already can only be a step between
/// their two sides.
fn grouped(mut singles: Vec<Single>, out: &[bool]) -> (Vec<Single>, Vec<Found>) {
    let in_gap = |row: usize| out[row] || out[row - 1];
    singles.retain(|single| single.event.shape == Shape::Step || !out[single.event.row]);
    singles.sort_by_key(|single| (single.event.row, single.instrument as usize, single.axis));
    let (mut steps, mut disturbed): (Vec<Single>, Vec<Found>) = (Vec::new(), Vec::new());
    let mut rest = singles.into_iter().peekable();
    while let Some(first) = rest.next() {
        let mut group = vec![first];
        while let Some(next) = rest.next_if(|next| next.event.row - group[group.len() - 1].event.row <= NEAR)
        {
            group.push(next);
        }
        let all_steps = group.iter().all(|single| single.event.shape == Shape::Step);
        let one_row = group.iter().all(|single| single.event.row == group[0].event.row);
        if all_steps && (one_row || group.iter().all(|single| in_gap(single.event.row))) {
            group.into_iter().for_each(|single| merge(&mut steps, single, out));
            continue;
        }
        let last = |single: &Single| match single.event.shape {
            Shape::Step => single.event.row - 1,
            Shape::Spike => single.event.row,
        };
        let from = group[0].event.row;
        let to = group.iter().map(last).max().unwrap_or(from).max(from);
        let kind = if from == to { EventKind::Spike } else { EventKind::Interval };
        let strongest = group.into_iter().max_by(|a, b| a.event.z.abs().total_cmp(&b.event.z.abs()));
        disturbed.extend(strongest.map(|single| Found { from, to, ..single.found(kind) }));
    }
    (steps, disturbed)
}

/// Steps of one axis within one gap are one step.
fn merge(steps: &mut Vec<Single>, single: Single, out: &[bool]) {
    let one_gap = |known: &&mut Single| {
        (known.instrument, known.axis) == (single.instrument, single.axis)
            && out[known.event.row..single.event.row].iter().all(|out| *out)
    };
    match steps.iter_mut().find(one_gap) {
        Some(known) => known.event.size += single.event.size,
        None => steps.push(single),
    }
}

/// Disturbances that touch are one.
fn joined(mut disturbed: Vec<Found>) -> Vec<Found> {
    disturbed.sort_by_key(|event| event.from);
    let mut joined: Vec<Found> = Vec::new();
    for event in disturbed {
        match joined.last_mut().filter(|last| event.from <= last.to + 1) {
            Some(last) => {
                let (from, to) = (last.from, last.to.max(event.to));
                let larger = if event.z.abs() > last.z.abs() { event } else { last.clone() };
                *last = Found { from, to, kind: EventKind::Interval, ..larger };
            }
            None => joined.push(event),
        }
    }
    joined
}
