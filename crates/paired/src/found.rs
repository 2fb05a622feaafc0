//! From a pair to what its difference follows, its clocks and its events: columns first, until nothing changes.

use common::{ClockDifference, EventInstrument, HeldOutPrediction, Quantity};
use explain::{Amplitude, Cause, Covariate, Explained, Form, Problem, explain};
use joined::Pair;
use std::mem::discriminant;

use crate::Error;
use crate::courses::{Acting, Given, Sensors, are_one_step};
use crate::events::{Events, FoundEvent};
use crate::followed::{Follows, add};
use crate::look::Shift;
use crate::prepare::{Prepared, coarse_shift, prepare};
use crate::problem::{problem, squares};
use crate::striking::striking;
use crate::{delays, held_out, pauses, segments};

/// Fewer whole rows explain nothing.
pub const LEAST: usize = 32;
/// Rounds of columns and events.
const ROUNDS: usize = 5;
/// Rounds of what is striking in what is left.
const STRIKING: usize = 6;
/// More lines, or more steps that are striking at once, are structure of another kind, …
const FEW: usize = 3;
/// … and so are more steps that act.
const MOST_STEPS: usize = 8;

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
    /// What may act without having been recorded, each with the number of alike ones among which it was found.
    acting: Vec<(Acting, f64)>,
    given: Vec<Given>,
    /// Whether more is looked for, and what was found before.
    unrecorded: bool,
    tried: Vec<Acting>,
    /// What is left of each channel in each row, as far as it is known.
    left: Vec<Vec<f64>>,
    /// What the engine said last, and of what.
    last: Option<Weighed>,
}

/// What is asked of a pair.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// What was recorded beside it.
    pub covariates: Vec<Covariate>,
    /// Whether the test instrument's clock is corrected.
    pub correct_clock: bool,
    /// Whether what was not recorded is looked for: sensors that answer late, lines, steps, codes.
    pub unrecorded: bool,
    /// Courses that may act besides.
    pub given: Vec<Given>,
}

/// How late the test instrument's clock is.
#[derive(Clone, Debug)]
pub struct Clock {
    /// How fast its offset grows, s/s; absent where nothing shows it.
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
    /// What the courses are.
    pub acting: Vec<Acting>,
    /// Single readings that are disturbed, where they are not known to be the reference's.
    pub spikes: Vec<FoundEvent>,
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
    disturbed: Events,
    shift: Shift,
    explained: Explained,
    problem: Problem,
    sensors: Sensors,
    acting: Vec<(Acting, f64)>,
    rows: Vec<usize>,
}

impl Weighed {
    fn of(of: &Found, disturbed: &Events, told: &dyn Fn(&str)) -> Result<Self, Error> {
        let shift = of.prepared.shift;
        let (mut problem, sensors, rows) = problem(&of.recorded, &of.covariates, (disturbed, shift));
        if rows.len() < LEAST {
            return Err(estimate::Error::TooFew { found: rows.len(), unknowns: LEAST }.into());
        }
        let left: Vec<Vec<f64>> =
            of.left.iter().map(|left| rows.iter().map(|row| left[*row]).collect()).collect();
        let course =
            |(acting, looks): &(Acting, f64)| acting.course((&problem, &sensors), &left, &of.given, *looks);
        problem.courses = of.acting.iter().map(course).collect();
        let explained = explain(&problem, told)?;
        let (disturbed, acting) = (disturbed.clone(), of.acting.clone());
        Ok(Self { disturbed, shift, explained, problem, sensors, acting, rows })
    }

    /// The causes in their forms.
    fn causes(&self) -> Vec<(Cause, Form, Option<Acting>)> {
        let of = |one: &Amplitude| match one.cause {
            Cause::Course(number) => (Cause::Course(0), one.form, Some(self.acting[number].0)),
            cause => (cause, one.form, None),
        };
        self.explained.causes.iter().map(of).collect()
    }

    /// Whether a course was chosen.
    fn chose(&self, number: usize) -> bool {
        self.explained.causes.iter().any(|one| one.cause == Cause::Course(number))
    }

    /// What courses contribute to each channel is added so many times to a pair; steps stay to be found by the search for
    /// events.
    fn add_courses(&self, pair: &mut Pair, times: f64) {
        let time_s = pair.times_s();
        for (one, channels) in self.explained.causes.iter().zip(&self.explained.contributions) {
            let Cause::Course(number) = one.cause else { continue };
            if let Acting::Step(_) = self.acting[number].0 {
                continue;
            }
            // What is known at any time, also in rows that were left out.
            if let Some(columns) = self.acting[number].0.of_time(&time_s) {
                let sizes = one.channels.iter().map(|of| of.iter().map(|size| times * size.value()));
                for (test, sizes) in pair.test.iter_mut().zip(sizes) {
                    add(test, columns.iter().zip(sizes));
                }
                continue;
            }
            for (test, contribution) in pair.test.iter_mut().zip(channels) {
                self.rows.iter().zip(contribution).for_each(|(row, value)| test[*row] += times * value);
            }
        }
        pair.bridge();
    }

    fn follows(&self, pair: &Pair, covariates: &[Covariate]) -> Vec<Follows> {
        let time_s = pair.times_s();
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
/// Refused: readings that a fit cannot use.
pub fn find(recorded: &Pair, asked: Asked, told: &dyn Fn(&str)) -> Result<Found, Error> {
    let usual = asked.unrecorded.then(|| Acting::usual(&recorded.reference, &asked.covariates));
    let acting = usual.into_iter().flatten().chain((0..asked.given.len()).map(Acting::Given));
    let correct_clock = asked.correct_clock;
    let mut found = Found {
        recorded: recorded.clone(),
        raw: recorded.clone(),
        follows: Vec::new(),
        prepared: Prepared::none(recorded),
        covariates: asked.covariates,
        acting: acting.map(|one| (one, 1.0)).collect(),
        given: asked.given,
        unrecorded: asked.unrecorded,
        tried: Vec::new(),
        left: vec![vec![0.0; recorded.whole.len()]; recorded.test.len()],
        last: None,
    };
    let nothing = found.covariates.is_empty() && !asked.unrecorded;
    if nothing || recorded.samples() < LEAST {
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
        self.prepared.shift = coarse_shift(&self.recorded)?;
        let mut before = Vec::new();
        for round in 0..ROUNDS {
            if !self.weigh(told)? {
                break;
            }
            // Clocks and events are those beside the same causes.
            let causes = self.last.as_ref().map(Weighed::causes).unwrap_or_default();
            let same = causes.len() == before.len() && causes.iter().all(|one| before.contains(one));
            if round > 0 && same {
                break;
            }
            before = causes;
            self.prepare(correct_clock, told)?;
        }
        Ok(())
    }

    /// Weighs the columns with what is known of clocks and events; whether that was not done before.
    fn weigh(&mut self, told: &dyn Fn(&str)) -> Result<bool, Error> {
        let disturbed = self.prepared.events.disturbances();
        let stepped = self.try_steps();
        let same = |last: &Weighed| last.disturbed.same(&disturbed) && self.prepared.is_near(last.shift);
        if !stepped && self.last.as_ref().is_some_and(same) {
            return Ok(false);
        }
        told("weighing what was recorded beside");
        let mut last = Weighed::of(self, &disturbed, told)?;
        let mut new = Vec::new();
        for _ in 0..STRIKING {
            self.keep_what_acts(&last);
            if !self.unrecorded || !new.is_empty() && !self.acting.iter().any(|one| new.contains(one)) {
                break;
            }
            new = striking(&last.problem, &last.sensors, &last.explained, FEW + 1)?;
            new.retain(|(new, _)| {
                let near = |known: &Acting| known.is_near(new, &last.problem, &last.sensors);
                let is_new = !self.tried.iter().any(near);
                self.tried.extend(is_new.then_some(*new));
                is_new
            });
            // Where there are more, none of them is adopted.
            let mut fewer = false;
            for (like, most) in [(Acting::Line(0.0), FEW), (Acting::Step(0.0), MOST_STEPS)] {
                let is_like = |one: &&(Acting, f64)| discriminant(&one.0) == discriminant(&like);
                let chosen = self.acting.iter().filter(is_like).count();
                if chosen > most || new.iter().filter(is_like).count() > FEW {
                    new.retain(|one| !is_like(&one));
                    self.acting.retain(|one| !is_like(&one));
                    fewer |= chosen > 0;
                }
            }
            if new.is_empty() && !fewer {
                break;
            }
            self.acting.extend(new.iter().copied());
            last = Weighed::of(self, &disturbed, told)?;
        }
        self.follows = last.follows(&self.recorded, &self.covariates);
        self.last = Some(last);
        Ok(true)
    }

    /// The steps that the search for events found may act too, where they are few; whether there are new ones.
    fn try_steps(&mut self) -> bool {
        let pair = &self.recorded;
        let length_s = pair.whole.len() as f64 * pair.step_s;
        let mut new: Vec<f64> = Vec::new();
        for step in self.prepared.events.steps().found {
            let at_s = pair.time_s(step.from);
            let tried = self.tried.iter().filter_map(|one| match one {
                Acting::Step(known) => Some(*known),
                _ => None,
            });
            if !tried.chain(new.iter().copied()).any(|known| are_one_step(known, at_s, length_s)) {
                new.push(at_s);
            }
        }
        if new.len() > MOST_STEPS {
            return false;
        }
        self.tried.extend(new.iter().map(|at_s| Acting::Step(*at_s)));
        self.acting.extend(new.iter().map(|at_s| (Acting::Step(*at_s), pair.whole.len() as f64)));
        !new.is_empty()
    }

    /// Keeps what is left, and of what was looked for that which was chosen.
    fn keep_what_acts(&mut self, last: &Weighed) {
        for (left, own) in self.left.iter_mut().zip(&last.explained.residual) {
            last.rows.iter().zip(own).for_each(|(row, value)| left[*row] = *value);
        }
        let stays = |(number, one): &(usize, &(Acting, f64))| one.0.is_usual() || last.chose(*number);
        self.acting = last.acting.iter().enumerate().filter(stays).map(|(_, one)| *one).collect();
    }

    /// Finds clocks and events in what the columns leave.
    fn prepare(&mut self, correct_clock: bool, told: &dyn Fn(&str)) -> Result<(), Error> {
        told("looking for steps and disturbed readings, and at the clocks");
        self.raw =
            self.follows.iter().fold(self.recorded.clone(), |pair, follows| follows.added(&pair, -1.0));
        if let Some(last) = &self.last {
            last.add_courses(&mut self.raw, -1.0);
        }
        self.raw.segments.iter_mut().for_each(|segment| segment.late_s = 0.0);
        pauses::cut(&mut self.raw)?;
        let (segments, jumps) = segments::find(&mut self.raw, self.prepared.shift)?;
        (self.recorded.segments, self.recorded.boundaries) =
            (self.raw.segments.clone(), self.raw.boundaries.clone());
        self.prepared = prepare(&self.raw, self.prepared.shift, correct_clock)?;
        if let Some(clock) = &mut self.prepared.clock {
            (clock.segments, clock.jumps) = (segments, jumps);
        }
        Ok(())
    }

    /// How well readings that were left out are predicted, by the names and by plain regressions; none where nothing
    /// was recorded beside.
    pub fn held_out(&self) -> Option<HeldOutPrediction> {
        let explained = &self.last.as_ref()?.explained;
        let names: Vec<String> = self.covariates.iter().map(|one| one.name.clone()).collect();
        Some(HeldOutPrediction {
            named_nt: estimate::stats::rms(&explained.held_out.named),
            plain: held_out::regressions(explained, &|cause| held_out::named(cause, &names)),
        })
    }

    /// What the engine says with these clocks and events.
    /// Refused: fewer whole rows than a fit needs.
    pub fn explained(mut self, told: &dyn Fn(&str)) -> Result<Explanation, Error> {
        let unmoved = problem(&self.recorded, &[], (&Events::default(), Shift::default())).0;
        let rms = |left: f64| (left / unmoved.rows() as f64).sqrt();
        let rms = squares(&unmoved).into_iter().map(rms).collect();
        self.weigh(told)?;
        let Some(Weighed { mut explained, problem, acting, rows, .. }) = self.last else {
            return Err(Error::Fit("nothing was weighed".into()));
        };
        let clock = Clock::of(&self.prepared, &problem);
        explained.without(Cause::Clock);
        let disturbed = self.prepared.events.disturbances().found;
        // Beside a magnitude the sensors are the reference, and one of them or the magnitude may be off.
        let own = |event: &FoundEvent| {
            self.recorded.test.len() == 1 || event.instrument != EventInstrument::Reference
        };
        let is_spike = |event: &&FoundEvent| event.from == event.to && own(event);
        let spikes = disturbed.iter().filter(is_spike).cloned().collect();
        let off = disturbed.iter().map(|event| event.to + 1 - event.from).sum();
        Ok(Explanation {
            explained,
            acting: acting.iter().map(|(acting, _)| *acting).collect(),
            spikes,
            clock,
            rows,
            problem,
            frame: self.recorded.frame(),
            off,
            unmoved: rms,
        })
    }
}

impl Clock {
    /// Where offset or rate stand against the same odds as other names.
    fn of(prepared: &Prepared, problem: &Problem) -> Option<Self> {
        let clock = prepared.clock.as_ref()?;
        let square = |of: &Quantity| of.std().map_or(0.0, |std| (of.value() / std).powi(2));
        let odds = |of: &Quantity| explain::odds(&[square(of)], 1, problem.rows(), problem.causes().len());
        let gain = odds(&clock.offset_s).max(odds(&clock.rate_ppm));
        let per_second = |of: &Quantity| Quantity::new(1e-6 * of.value(), 1e-6 * of.std().unwrap_or(0.0));
        (gain > 0.0).then(|| Self {
            rate: Some(&clock.rate_ppm).filter(|rate| odds(rate) > 0.0).map(per_second),
            gain,
            difference: clock.clone(),
        })
    }
}
