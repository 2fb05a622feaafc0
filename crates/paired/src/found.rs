//! From a pair to what its difference follows, its clocks and its events: columns first, until nothing changes.

use common::{ClockDifference, HeldOutPrediction, Quantity};
use explain::{Cause, Covariate, Explained, Problem, explain};
use joined::Pair;

use crate::Error;
use crate::events::Events;
use crate::followed::Follows;
use crate::look::Shift;
use crate::prepare::{Prepared, prepare, whole_samples};
use crate::problem::{Known, problem, squares};
use crate::{delays, held_out, pauses, segments};

/// Fewer whole rows explain nothing.
pub const LEAST: usize = 32;
/// Rounds of columns and events.
const ROUNDS: usize = 5;

/// What a pair's difference follows, and the pair without it.
pub struct Found {
    /// The pair as it was recorded, cut where a clock was set.
    pub recorded: Pair,
    /// The same less what all columns that are followed explain.
    pub raw: Pair,
    /// The columns that are followed.
    pub follows: Vec<Follows>,
    /// Clocks and events of what they leave.
    pub prepared: Prepared,
    covariates: Vec<Covariate>,
    /// What the engine said last, and of what.
    last: Option<Weighed>,
}

/// How late the test instrument's clock is.
#[derive(Clone, Debug)]
pub struct Clock {
    /// In the middle of the recording, s.
    pub offset_s: Quantity,
    /// How fast that grows, s/s; absent where nothing shows it.
    pub rate: Option<Quantity>,
    /// ln of the odds against equal clocks.
    pub gain: f64,
    /// All that is known of it.
    pub difference: ClockDifference,
}

/// What the engine says of a pair with its clocks and events.
pub struct Explanation {
    /// The causes, of the rows in `rows`.
    pub explained: Explained,
    /// The clock, where it differs.
    pub clock: Option<Clock>,
    /// The rows of the pair that were explained.
    pub rows: Vec<usize>,
    /// The problem they make.
    pub problem: Problem,
    /// The pair without its readings.
    pub frame: Pair,
    /// Rows that are disturbed.
    pub off: usize,
    /// Rms of what plain least squares leave of each channel with the clocks as they were recorded, nT.
    pub unmoved: Vec<f64>,
}

/// An answer of the engine, with the events and the clocks that it was given.
struct Weighed {
    events: Events,
    shift: Shift,
    explained: Explained,
    problem: Problem,
    rows: Vec<usize>,
}

impl Weighed {
    fn of(
        pair: &Pair,
        covariates: &[Covariate],
        known: Known<'_>,
        told: &dyn Fn(&str),
    ) -> Result<Self, Error> {
        let (problem, rows) = problem(pair, covariates, known);
        if rows.len() < LEAST {
            return Err(estimate::Error::TooFew { found: rows.len(), unknowns: LEAST }.into());
        }
        let explained = explain(&problem, told)?;
        Ok(Self { events: known.events.clone(), shift: known.shift, explained, problem, rows })
    }

    fn follows(&self, pair: &Pair, covariates: &[Covariate]) -> Vec<Follows> {
        let time_s: Vec<f64> = (0..pair.whole.len()).map(|row| pair.time_s(row)).collect();
        let named = self.explained.causes.iter().zip(&self.explained.gains);
        let follows = named.filter_map(|(one, gain)| match one.cause {
            Cause::Covariate(number) => Some(Follows::of(&covariates[number], &time_s, one, *gain)),
            _ => None,
        });
        follows.collect()
    }
}

/// Finds what a pair follows of what was recorded beside it, its clocks and its events; `told` hears what is being
/// done.
///
/// # Errors
///
/// Readings that a fit cannot use.
pub fn find(
    recorded: &Pair,
    covariates: Vec<Covariate>,
    correct_clock: bool,
    told: &dyn Fn(&str),
) -> Result<Found, Error> {
    let mut found = Found {
        recorded: recorded.clone(),
        raw: recorded.clone(),
        follows: Vec::new(),
        prepared: Prepared::none(recorded),
        covariates,
        last: None,
    };
    if found.covariates.is_empty() || recorded.samples() < LEAST {
        found.prepare(correct_clock, told)?;
    } else {
        found.weigh_and_prepare(correct_clock, told)?;
    }
    // What parts and bands say of the clock.
    delays::judge(&found.raw, &mut found.prepared)?;
    Ok(found)
}

impl Found {
    /// Columns, then clocks and events in what they leave, until neither changes.
    fn weigh_and_prepare(&mut self, correct_clock: bool, told: &dyn Fn(&str)) -> Result<(), Error> {
        told("comparing the clocks");
        self.prepared.shift = whole_samples(&self.recorded)?;
        for round in 0..ROUNDS {
            // Disturbed rows are left out first: what a step was taken for may then follow a column.
            let with_steps = round != 1 || self.prepared.events.disturbances().found.is_empty();
            if !self.weigh(with_steps, told)? && with_steps {
                break;
            }
            self.prepare(correct_clock, told)?;
        }
        Ok(())
    }

    /// Weighs the columns with what is known of clocks and events; whether that was not done before.
    fn weigh(&mut self, with_steps: bool, told: &dyn Fn(&str)) -> Result<bool, Error> {
        let events = &self.prepared.events;
        let events = if with_steps { events.clone() } else { events.disturbances() };
        let shift = self.prepared.shift;
        let same = |last: &Weighed| last.events.same(&events) && self.prepared.is_near(last.shift);
        if self.last.as_ref().is_some_and(same) {
            return Ok(false);
        }
        told("weighing what was recorded beside");
        let last = Weighed::of(&self.recorded, &self.covariates, Known { events: &events, shift }, told)?;
        self.follows = last.follows(&self.recorded, &self.covariates);
        self.last = Some(last);
        Ok(true)
    }

    /// Finds clocks and events in what the columns leave.
    fn prepare(&mut self, correct_clock: bool, told: &dyn Fn(&str)) -> Result<(), Error> {
        told("looking for steps and disturbed readings, and at the clocks");
        self.raw =
            self.follows.iter().fold(self.recorded.clone(), |pair, follows| follows.added(&pair, -1.0));
        self.raw.segments.iter_mut().for_each(|segment| segment.late_s = 0.0);
        pauses::cut(&mut self.raw)?;
        let segments = segments::find(&mut self.raw)?;
        (self.recorded.segments, self.recorded.boundaries) =
            (self.raw.segments.clone(), self.raw.boundaries.clone());
        self.prepared = prepare(&self.raw, correct_clock)?;
        if let Some(clock) = &mut self.prepared.clock {
            segments.write(clock);
        }
        Ok(())
    }

    /// How well readings that were left out are predicted, by the names and by plain regressions; none where nothing
    /// was recorded beside.
    pub fn held_out(&self) -> Option<HeldOutPrediction> {
        let explained = &self.last.as_ref()?.explained;
        let names: Vec<String> = self.covariates.iter().map(|one| one.name.clone()).collect();
        Some(HeldOutPrediction {
            named_nt: held_out::together(&explained.held_out.named),
            plain: held_out::regressions(explained, &|cause| held_out::named(cause, &names)),
        })
    }

    /// What the engine says with these clocks and events.
    ///
    /// # Errors
    ///
    /// Fewer whole rows than a fit needs.
    pub fn explained(mut self, told: &dyn Fn(&str)) -> Result<Explanation, Error> {
        let as_recorded = Known { events: &Events::default(), shift: Shift::default() };
        let unmoved = problem(&self.recorded, &[], as_recorded).0;
        let rms = |left: f64| (left / unmoved.rows() as f64).sqrt();
        let rms = squares(&unmoved).into_iter().map(rms).collect();
        self.weigh(true, told)?;
        let Some(Weighed { mut explained, problem, rows, .. }) = self.last else {
            return Err(Error::Fit("nothing was weighed".into()));
        };
        let clock = Clock::of(&self.prepared, &problem);
        explained.without(Cause::Clock);
        let disturbed = self.prepared.events.disturbances().found;
        let off = disturbed.iter().map(|event| event.to + 1 - event.from).sum();
        Ok(Explanation { explained, clock, rows, problem, frame: self.recorded.frame(), off, unmoved: rms })
    }
}

impl Clock {
    /// Where offset or rate stand against the same odds as other names.
    fn of(prepared: &Prepared, problem: &Problem) -> Option<Self> {
        let clock = prepared.clock.as_ref()?;
        let square = |of: &Quantity| of.std().map_or(0.0, |std| (of.value() / std).powi(2));
        let odds = |of: &Quantity| explain::odds(square(of), problem.rows(), problem.causes().len());
        let gain = odds(&clock.offset_s).max(odds(&clock.rate_ppm));
        let per_second = |of: &Quantity| Quantity::new(1e-6 * of.value(), 1e-6 * of.std().unwrap_or(0.0));
        (gain > 0.0).then(|| Self {
            offset_s: clock.offset_s.clone(),
            rate: Some(&clock.rate_ppm).filter(|rate| odds(rate) > 0.0).map(per_second),
            gain,
            difference: clock.clone(),
        })
    }
}
