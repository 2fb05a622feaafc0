//! What happened at moments, at frequencies or in codes: which of it is new, which pays for its search, and
//! what is told as one.

use physics::{EffectInstance, Role};

use crate::fit::Fit;
use crate::model::Model;
use crate::proposal::{Addition, Proposal};
use crate::whitening::NoiseModel;

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
    let time = runs.filter_map(|run| run.time_s).find(|time| time.len() > 1);
    time.map_or(0.0, |time| (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64)
}

/// Brings lines and codes to the frequencies and periods that a fit has of them, its effects in the order of
/// the additions; whether any moved.
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
