//! Which of the names that were found are kept when something is left over.
//!
//! A search that goes on until nothing fits any more gives every shape some name: what the catalogue does not have, it makes up of
//! several effects. Where what is left is noise, the names stand. Where it is not, a name stands only if it explains far more than is
//! left, and if of what the effect itself follows no more is left than forms are true to: else its form is wrong.

use common::Axis;
use faer::Mat;
use physics::{Acts, EffectInstance, Kind, ParameterInfo, Place, Role};
use std::collections::BTreeSet;

use crate::candidates::{What, named};
use crate::course::without;
use crate::covariates;
use crate::fit::{orthonormal, square};
use crate::model::Model;
use crate::observed::Channel;
use crate::search::{Addition, Structure};
use crate::{Error, Found, Stage};

/// What a name explains over what is left.
const FAR_MORE: f64 = 10.0;
/// Most different names in one sensor.
const MOST_IN_ONE: usize = 3;
/// Share of the level above which a further name in a sensor hardly stands out.
const HARDLY: f64 = 0.01;
/// What names of one sensor do together, over the sum of what each does, where they cancel.
const CANCEL: f64 = 0.25;
/// Rows to either side of a moment among which it is the edge of what switches there.
const EDGE: usize = 4;
/// Share of its energy to which the form that the catalogue has of an effect is met.
pub const FORM: f64 = 0.02;

/// The sensors that take more different names than [`MOST_IN_ONE`]: what the catalogue does not have is made up of them there.
fn made_of_pieces(found: &[Found]) -> Vec<Axis> {
    let of = |axis: &Axis| -> usize {
        let acting = found.iter().filter(|one| acts_on(&one.refined.proposal.addition, *axis));
        acting.map(name).collect::<BTreeSet<_>>().len()
    };
    Axis::ALL.into_iter().filter(|axis| of(axis) > MOST_IN_ONE).collect()
}

/// The first name that hardly stands out beside an earlier one in the same sensor, by chance, or by size where both are of one axis or the
/// earlier one has a memory, of which what was before the recording is not known: its form leaves something rather than that there
/// are two.
fn crumbs(found: &[Found], level: f64) -> Option<usize> {
    let crumb = |(at, one): &(usize, &Found)| {
        let own = &one.refined.proposal.addition;
        found[..*at].iter().filter(|earlier| name(earlier) != name(one)).any(|earlier| {
            let theirs = &earlier.refined.proposal.addition;
            let together = Axis::ALL.into_iter().any(|axis| acts_on(own, axis) && acts_on(theirs, axis));
            let by_chance = together && one.refined.p_adjusted > HARDLY * level;
            let of_its_form = same_axis(own, theirs) || together && remembers(theirs);
            by_chance || of_its_form && one.gain < FORM * earlier.gain
        })
    };
    found.iter().enumerate().find(crumb).map(|(at, _)| at)
}

/// Whether two effects are of one sensor, or of a sensor and the coil along it.
fn same_axis(a: &Addition, b: &Addition) -> bool {
    match (a, b) {
        (Addition::Effect(a), Addition::Effect(b)) => a.axis.is_some() && a.axis == b.axis,
        _ => false,
    }
}

/// Whether an effect has a time constant.
fn remembers(addition: &Addition) -> bool {
    let constant = |info: &ParameterInfo| info.role == Role::Shape && info.name.ends_with("_s");
    matches!(addition, Addition::Effect(effect) if effect.kind.parameters().iter().any(constant))
}

/// The sensor on which alone an addition acts.
fn one_sensor(addition: &Addition) -> Option<Axis> {
    match addition {
        Addition::Effect(effect) => effect.axis.filter(|_| effect.kind.about().acts == Acts::OneSensor),
        Addition::Column(column) => column.follows.as_ref().map(|follows| follows.axis),
    }
}

/// Whether an addition acts on a sensor.
fn acts_on(addition: &Addition, sensor: Axis) -> bool {
    match addition {
        Addition::Effect(_) => one_sensor(addition).is_none_or(|own| own == sensor),
        Addition::Column(_) => one_sensor(addition) == Some(sensor),
    }
}

/// The name of an effect and its target, wherever it was found.
fn name(one: &Found) -> String {
    match &one.refined.proposal.addition {
        Addition::Effect(effect) => named(effect),
        Addition::Column(column) => column.what.clone(),
    }
}

/// The first of several single moments (steps, spikes, passes) if a smooth function of one covariate says more with fewer unknowns than
/// all of them: levels that come and go with a temperature are no steps.
fn made_of_moments(found: &[Found], stages: &[Stage]) -> Option<usize> {
    let moments: Vec<&Found> = found.iter().filter(|one| one.refined.proposal.local).collect();
    let first = found.iter().position(|one| one.refined.proposal.local).filter(|_| moments.len() > 1)?;
    let look = &stages[first].look;
    let price = (stages[first].fit.white.len() as f64).ln();
    let worth: f64 = moments.iter().map(|one| one.gain - one.refined.unknowns * price).sum();
    let says_more = |structure: &Structure| match &structure.what {
        What::Smooth { covariate, .. } if covariate == "time_s" || covariate == "row" => false,
        _ => structure.gain - structure.unknowns * price > worth,
    };
    look.structures.iter().any(says_more).then_some(first)
}

/// What was found, with the stages before the first name and after each.
pub struct Judge<'a> {
    pub model: &'a Model<'a>,
    pub found: &'a [Found],
    pub stages: &'a [Stage],
    pub level: f64,
}

impl Judge<'_> {
    /// Which of the names are more than pieces and crumbs of what has another name or none.
    pub fn worth_keeping(&self) -> Result<Vec<usize>, Error> {
        let cuts = [made_of_moments(self.found, self.stages), crumbs(self.found, self.level), self.edges()?];
        let whole = cuts.into_iter().flatten().fold(self.found.len(), usize::min);
        let mut pieces = made_of_pieces(self.found);
        for axis in Axis::ALL {
            if self.cancel(axis)? {
                pieces.push(axis);
            }
        }
        let piece = |number: &usize| {
            one_sensor(&self.found[*number].refined.proposal.addition)
                .is_some_and(|axis| pieces.contains(&axis))
        };
        Ok((0..whole).filter(|number| !piece(number)).collect())
    }

    /// Whether the names of one sensor alone do together far less than each by itself, beyond what the calibration takes up: what the catalogue
    /// does not have, such as the rate of a temperature, is made up of their difference.
    fn cancel(&self, axis: Axis) -> Result<bool, Error> {
        let own = |number: &usize| one_sensor(&self.found[*number].refined.proposal.addition) == Some(axis);
        let names: Vec<usize> = (0..self.found.len()).filter(own).collect();
        let Some(last) = self.stages.last().filter(|_| names.len() > 1) else { return Ok(false) };
        let base = orthonormal(&self.stages[0].fit.jacobian)?;
        let mut together = Mat::zeros(base.nrows(), 1);
        let mut apart = 0.0;
        for number in names {
            let state = without(&last.fit.state, &self.stages[0].fit, self.found, number);
            let change = self.model.change(&state, &last.fit.state)?;
            let white = last.noise.whiten(&self.model.observed, &change);
            let column = Mat::from_fn(base.nrows(), 1, |i, _| white.get(i).copied().unwrap_or(0.0));
            let seen = &column - &base * (base.transpose() * &column);
            apart += seen.squared_norm_l2();
            together += seen;
        }
        Ok(together.squared_norm_l2() < CANCEL * apart)
    }

    /// The first single moment at which an effect that was found before it switches on or off: its own edge, at another minute than told.
    fn edges(&self) -> Result<Option<usize>, Error> {
        for (at, one) in self.found.iter().enumerate().filter(|(_, one)| one.refined.proposal.local) {
            let Addition::Effect(event) = &one.refined.proposal.addition else { continue };
            let fit = &self.stages[at].fit;
            for earlier in (0..at).filter(|earlier| !self.found[*earlier].refined.proposal.local) {
                let without = without(&fit.state, &self.stages[0].fit, self.found, earlier);
                let acts = self.model.change(&without, &fit.state)?;
                if self.switches(&acts, event) {
                    return Ok(Some(at));
                }
            }
        }
        Ok(None)
    }

    /// Whether a contribution goes over more than half of its range within a few rows of an event.
    fn switches(&self, contribution: &[f64], event: &EffectInstance) -> bool {
        let Some(epoch) = event.kind.parameters().iter().position(|info| info.role == Role::Epoch) else {
            return false;
        };
        self.model.observed.channels.iter().any(|channel| {
            let run = &self.model.observed.runs[channel.run];
            let elsewhere = event.recording.as_ref().is_some_and(|only| *only != run.recording.id);
            let Some(times) = self.model.observed.times(channel).filter(|_| !elsewhere) else { return false };
            let own = &contribution[channel.range()];
            let (low, high) =
                own.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
            let middle = times.partition_point(|time| *time < event.parameters[epoch]);
            let near = middle.saturating_sub(EDGE)..(middle + EDGE).min(own.len());
            high > low && own[near].windows(2).any(|pair| (pair[1] - pair[0]).abs() > 0.5 * (high - low))
        })
    }

    /// Of the names of a stage, the last found that does not stand there: half of what a name explains must lie in sensors where it explains
    /// far more than is left, and where something is left in a sensor, it has one name at most. Harmonics of one effect count together,
    /// each single moment for itself.
    pub fn falls(&self, names: &[usize], now: &Stage) -> Option<usize> {
        let left = Axis::ALL.map(|sensor| self.left(now, sensor));
        let stands = |number: &usize| {
            let one = &self.found[*number];
            let own = |other: &&usize| {
                *other == number || !one.refined.proposal.local && name(&self.found[**other]) == name(one)
            };
            let gains = names.iter().filter(own).map(|other| self.gains(*other, now));
            let gains = gains.fold([0.0; 3], |sum, gain| std::array::from_fn(|k| sum[k] + gain[k]));
            let all: f64 = gains.iter().sum();
            let clear: f64 = (0..3).filter(|k| gains[*k] > FAR_MORE * left[*k]).map(|k| gains[k]).sum();
            let own_form = |left: &&Structure| same(&one.refined.proposal.addition, &left.what);
            let of_its_form =
                now.look.structures.iter().filter(own_form).map(|left| left.gain).fold(0.0, f64::max);
            let sensor = one_sensor(&one.refined.proposal.addition);
            let second = names.iter().take_while(|earlier| *earlier != number).any(|earlier| {
                let earlier = &self.found[*earlier];
                one_sensor(&earlier.refined.proposal.addition) == sensor && name(earlier) != name(one)
            });
            let doubtful = sensor.is_some_and(|axis| second && left[axis.index()] > 0.0);
            clear >= 0.5 * all && of_its_form <= FORM * all && !doubtful
        };
        names.iter().copied().rev().find(|number| !stands(number))
    }

    /// By how much a name lowered the sum of squares of each sensor when it came in, in units of the noise of a stage: where the noise is
    /// what a residual shows, it has become less since. What is read by no one sensor counts for each.
    fn gains(&self, number: usize, now: &Stage) -> [f64; 3] {
        let (before, after) = (&self.stages[number], &self.stages[number + 1]);
        Axis::ALL.map(|sensor| {
            let fell =
                |stage: &Stage| self.squares(stage, sensor) * stage.noise.variance() / now.noise.variance();
            (fell(before) - fell(after)).max(0.0)
        })
    }

    /// Σ of a sensor's squared whitened residuals.
    fn squares(&self, stage: &Stage, sensor: Axis) -> f64 {
        self.channels(sensor).map(|channel| square(&stage.fit.white[channel.range()])).sum()
    }

    fn channels(&self, sensor: Axis) -> impl Iterator<Item = &Channel> {
        let of_it = move |channel: &&Channel| channel.axis().is_none_or(|axis| axis == sensor);
        self.model.observed.channels.iter().filter(of_it)
    }

    /// By how much what a stage has left in a sensor, beyond chance, would lower the sum of squares if it had a name. What would act on all
    /// counts where the size of the noise is not known, and with it not what is left of the squares.
    fn left(&self, stage: &Stage, sensor: Axis) -> f64 {
        let look = &stage.look;
        let in_it = |addition: &Addition| match one_sensor(addition) {
            Some(own) => own == sensor,
            None => look.rest.omnibus().is_none(),
        };
        let structures = look.structures.iter().filter(|s| s.what.axis() == Some(sensor)).map(|s| s.gain);
        let proposals = look.proposals.iter().filter(|p| in_it(&p.addition)).map(|p| p.gain);
        let excess = if look.exceeds(self.level) {
            let rows: usize = self.channels(sensor).map(|channel| channel.rows.len()).sum();
            self.squares(stage, sensor) - rows as f64 * look.rest.scale()
        } else {
            0.0
        };
        structures.chain(proposals).fold(excess.max(0.0), f64::max)
    }
}

/// Whether structure follows what an effect follows, in the same sensor.
fn same(addition: &Addition, left: &What) -> bool {
    let (covariate, axis) = match left {
        What::Smooth { covariate, axis } => (covariate.as_str(), *axis),
        What::Dependence { column, axis } => (column.as_str(), *axis),
        What::Physics(_) => return false,
    };
    match addition {
        Addition::Effect(effect) => acts_on(addition, axis) && follows(effect, covariate),
        Addition::Column(column) => column.what.ends_with(covariate),
    }
}

fn follows(effect: &EffectInstance, covariate: &str) -> bool {
    if effect.column.as_deref() == Some(covariate)
        || effect.kind.about().needs.contains(&covariate) && covariate != "time_s"
        || covariates::of(effect).iter().any(|name| name == covariate)
    {
        return true;
    }
    match effect.kind {
        Kind::CrossField | Kind::CrossFieldSensitivity | Kind::AxisTemperature | Kind::AxisCreep => {
            covariate.contains("across")
        }
        Kind::WarmUp | Kind::Ageing | Kind::SensitivityAgeing | Kind::ReadingStep | Kind::PillarSettling => {
            covariate == "time_s"
        }
        kind if matches!(kind.place(), Place::Sensor | Place::Electronics) => covariate.contains("along"),
        kind if kind.place() == Place::Facility => covariate.contains("field"),
        _ => false,
    }
}
