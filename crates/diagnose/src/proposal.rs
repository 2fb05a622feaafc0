//! What may come into the model, before it is fitted; and of what happened at moments, at frequencies or in codes which is
//! new, which pays for its search, and what is told as one.

use common::Axis;
use physics::{EffectInstance, Role};

use crate::fit::Fit;
use crate::model::{Model, Single, named};
use crate::waves::mean_step_s;
use crate::whitening::NoiseModel;

#[derive(Clone, Debug)]
pub enum Addition {
    Effect(EffectInstance),
    Single(Single),
}

#[derive(Clone, Debug)]
pub enum What {
    /// An effect of the catalogue, sizes zero.
    Physics(EffectInstance),
    /// Something that happens at moments, or was found among frequencies or codes.
    Event(Vec<Addition>),
    /// A sensor follows smooth functions of something: structure without a name.
    Smooth { covariate: String, axis: Axis },
}

impl What {
    /// The name of a candidate with its target.
    pub fn name(&self) -> String {
        match self {
            What::Physics(effect) => match &effect.recording {
                Some(recording) => format!("{} in \"{recording}\"", named(effect)),
                None => named(effect),
            },
            What::Event(_) => String::new(),
            What::Smooth { covariate, axis } => format!("{axis} with {covariate}"),
        }
    }

    pub fn is_named(&self) -> bool {
        !matches!(self, What::Smooth { .. })
    }
}

/// Something found at a moment, at a frequency or in codes, before it is weighed.
#[derive(Clone, Debug)]
pub struct Proposal {
    pub name: String,
    pub addition: Addition,
    /// Probability by chance within its family, the search included.
    pub p: f64,
    pub gain: f64,
    /// As how many independent looks its search counts.
    pub looks: f64,
    /// Whether it touches few rows, so that rows left out say nothing.
    pub local: bool,
    /// What it is told as one with, such as a sensor's single readings.
    pub group: Option<String>,
}

impl Proposal {
    /// An effect that acts throughout.
    pub fn of(effect: EffectInstance, p: f64, gain: f64, looks: f64) -> Self {
        let name = named(&effect);
        Self { name, addition: Addition::Effect(effect), p, gain, looks, local: false, group: None }
    }

    /// An effect that touches few rows of one recording.
    pub fn event(effect: EffectInstance, recording: &str, p: f64, gain: f64, looks: f64) -> Self {
        let of = Self::of(effect, p, gain, looks);
        Self { name: format!("{} in \"{recording}\"", of.name), local: true, ..of }
    }
}

/// Moments that do not pay for their search beside all that came in: those whose height squared is not 2 ln
/// (looks) times its variance, and those that last for less than the step from reading to reading: they have
/// more unknowns than readings in which they act. The additions stand in the fit from a number of effects and
/// of single readings on.
pub fn insignificant(
    model: &Model<'_>,
    from: (usize, usize),
    (fit, noise): (&Fit, &NoiseModel),
    additions: &[Addition],
    events: &[Proposal],
) -> Vec<Proposal> {
    let free = model.free(&fit.state);
    // Where more than the noise is left, heights are as uncertain as that makes them (Birge's ratio).
    let left = fit.cost / fit.residual.len().saturating_sub(fit.rank).max(1) as f64;
    let scale = if noise.known > 0.0 { left.max(1.0) } else { left };
    let variance = |unknown: usize| {
        let at = model.unknowns.len() + unknown;
        fit.covariance[(at, at)] * scale
    };
    // The unknowns of an effect that have a role.
    let of_effect = |number: usize, role: Role| -> Vec<usize> {
        let infos = fit.state.effects[number].kind.parameters();
        let own = |of: &(usize, usize)| of.0 == number && infos[of.1].role == role;
        (0..free.len()).filter(|unknown| own(&free[*unknown])).collect()
    };
    let value = |unknown: usize| fit.state.effects[free[unknown].0].parameters[free[unknown].1];
    let too_low = |height: f64, unknown: usize, looks: f64| {
        variance(unknown).is_finite() && height * height < 2.0 * looks.max(1.0).ln() * variance(unknown)
    };
    let (mut effects, mut singles) = from;
    let mut found = Vec::new();
    for addition in additions {
        let number = match addition {
            Addition::Effect(_) => &mut effects,
            Addition::Single(_) => &mut singles,
        };
        *number += 1;
        let number = *number - 1;
        let Some(event) = events.iter().find(|event| event.local && is(event, addition)) else { continue };
        let is_none = match addition {
            Addition::Effect(_) => {
                let step_s = step_s(model, &fit.state.effects[number]);
                let unresolved = |unknown: &usize| value(*unknown) < step_s;
                let low = match of_effect(number, Role::Amplitude)[..] {
                    [only] => too_low(value(only), only, event.looks),
                    _ => false,
                };
                low || of_effect(number, Role::Shape).iter().any(unresolved)
            }
            Addition::Single(_) => {
                too_low(fit.state.singles[number].height_nt, free.len() + number, event.looks)
            }
        };
        if is_none {
            found.push(event.clone());
        }
    }
    found
}

/// Mean step from reading to reading of the recording in which an effect acts; zero where it acts in all.
fn step_s(model: &Model<'_>, effect: &EffectInstance) -> f64 {
    let runs = model.observed.runs.iter().filter(|run| Some(&run.recording.id) == effect.recording.as_ref());
    runs.filter_map(|run| run.time_s).find(|time| time.len() > 1).map_or(0.0, mean_step_s)
}

/// Brings lines and codes to the frequencies and periods of a fit, in the additions' order; whether any moved.
pub fn follow(events: &mut [Proposal], additions: &[Addition], fitted: &[EffectInstance]) -> bool {
    let effects = additions.iter().filter(|addition| matches!(addition, Addition::Effect(_)));
    let mut any = false;
    for (addition, fitted) in effects.zip(fitted) {
        let now = Addition::Effect(fitted.clone());
        for event in events.iter_mut().filter(|event| !event.local && is(event, addition)) {
            any |= !is(event, &now);
            event.addition = now.clone();
        }
    }
    any
}

/// Moments, lines and codes that are not known yet.
pub fn fresh(found: &[Proposal], known: &[Proposal]) -> Vec<Proposal> {
    let is_new = |proposal: &&Proposal| !known.iter().any(|other| same(other, proposal));
    found.iter().filter(is_new).cloned().collect()
}

/// Whether two proposals are the same moment, line or code.
pub fn same(one: &Proposal, other: &Proposal) -> bool {
    one.group == other.group && is(one, &other.addition)
}

/// Whether a proposal is that of an addition.
fn is(one: &Proposal, addition: &Addition) -> bool {
    match (&one.addition, addition) {
        (Addition::Effect(a), Addition::Effect(b)) => {
            let shapes = a.kind.parameters().iter().zip(a.parameters.iter().zip(&b.parameters));
            let close = |(x, y): (&f64, &f64)| (x - y).abs() <= 1e-6 * x.abs().max(y.abs());
            a.kind == b.kind
                && a.target() == b.target()
                && shapes.filter(|(info, _)| info.role != Role::Amplitude).all(|(_, pair)| close(pair))
        }
        (Addition::Single(a), Addition::Single(b)) => a.row == b.row,
        _ => false,
    }
}

/// What is told as one together, all else by itself.
pub fn grouped(events: &[Proposal]) -> Vec<Vec<&Proposal>> {
    let mut groups: Vec<Vec<&Proposal>> = Vec::new();
    for event in events {
        match groups.iter_mut().find(|group| event.group.is_some() && group[0].group == event.group) {
            Some(group) => group.push(event),
            None => groups.push(vec![event]),
        }
    }
    groups
}
