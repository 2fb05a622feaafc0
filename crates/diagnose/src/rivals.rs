//! Which of several answers: the best, those that fit as well, and those that lost.

use common::number::{counted, significant};
use estimate::screen::Screen;
use estimate::stats::chi_squared_quantile;
use physics::{EffectInstance, Kind};

use crate::Error;
use crate::covariates;
use crate::fit::{Fit, Fitter};
use crate::search::{Addition, Fault, Refined};
use crate::trust::FORM;

/// Twice the logarithm of the odds at which a rival is out.
const ODDS: f64 = 9.2;
/// Probability at which unknowns that a rival has more are needed.
const NEEDED: f64 = 0.01;
/// Share of an effect's columns that is left beside a rival which holds it.
const HELD: f64 = 0.02;

/// The refined proposal that may be taken: the best that is not idle, unless something of an implausible size fits far better.
pub fn best(refined: &[Refined]) -> Option<&Refined> {
    let best = refined.iter().find(|r| r.why_not.is_none())?;
    let far_better = |r: &&Refined| {
        matches!(r.why_not, Some(Fault::Implausible(_))) && best.criterion() - r.criterion() > ODDS
    };
    refined.iter().find(far_better).is_none().then_some(best)
}

/// Sets aside effects with a lag where the same without one fits as well, if the lag is smaller than its own uncertainty, or if a
/// coefficient alone says the same: of it the lag, and the curvature of the effect without, take no more than chance would.
pub fn without_needless_lags(fitter: &Fitter<'_, '_>, all: &mut [Refined]) {
    let plain: Vec<(EffectInstance, f64, f64)> = all
        .iter()
        .filter(|refined| refined.why_not.is_none())
        .filter_map(|refined| match &refined.proposal.addition {
            Addition::Effect(effect) => {
                let [value, variance] = last_parameter(fitter, refined, "curvature")?;
                Some((effect.clone(), refined.criterion(), refined.deviance + value * value / variance))
            }
            Addition::Column(_) => None,
        })
        .collect();
    for refined in all.iter_mut().filter(|refined| refined.why_not.is_none()) {
        let Addition::Effect(effect) = &refined.proposal.addition else { continue };
        let Some(kind) = without_lag(effect.kind) else { continue };
        let mut without = plain.iter().filter(|(other, ..)| other.kind == kind && other.axis == effect.axis);
        let Some((_, criterion, alone)) = without.next() else { continue };
        // Shapes count by their logarithm: its variance is the relative one.
        let Some([_, relative]) = last_parameter(fitter, refined, "lag_s") else { continue };
        let as_good = criterion - refined.criterion() < ODDS;
        let needless = alone - refined.deviance < chi_squared_quantile(1.0 - NEEDED, 1.0);
        if as_good && (relative > 1.0 || needless) {
            refined.why_not = Some(Fault::Idle(format!(
                "its lag is smaller than its uncertainty, where {} says the same without",
                kind.name()
            )));
        }
    }
}

/// Value and variance of the parameter of a refined effect whose name begins so; of none, zero and one.
fn last_parameter(fitter: &Fitter<'_, '_>, refined: &Refined, name: &str) -> Option<[f64; 2]> {
    let last = refined.fit.state.effects.len().checked_sub(1)?;
    let effect = &refined.fit.state.effects[last];
    let infos = effect.kind.parameters();
    let Some(number) = infos.iter().position(|info| info.name.starts_with(name)) else {
        return Some([0.0, 1.0]);
    };
    let at = fitter.model.free(&refined.fit.state).iter().position(|free| *free == (last, number))?;
    let at = fitter.model.unknowns.len() + at;
    Some([effect.parameters[number], refined.fit.covariance[(at, at)]])
}

/// The same effect without a lag.
pub fn without_lag(kind: Kind) -> Option<Kind> {
    match kind {
        Kind::OffsetTemperatureLag => Some(Kind::OffsetTemperature),
        Kind::SensitivityTemperatureLag => Some(Kind::SensitivityTemperature),
        Kind::AxisCreep => Some(Kind::AxisTemperature),
        Kind::OffsetElectronicsTemperatureLag => Some(Kind::OffsetElectronicsTemperature),
        Kind::SensitivityElectronicsTemperatureLag => Some(Kind::SensitivityElectronicsTemperature),
        _ => None,
    }
}

/// Sets aside effects of which a fuller form explains more than its further unknowns would by chance: what a part of it leaves would be
/// given other names.
pub fn without_mere_parts(all: &mut [Refined]) {
    let of = |refined: &Refined| match &refined.proposal.addition {
        Addition::Effect(effect) if refined.why_not.is_none() => Some(effect.kind),
        _ => None,
    };
    let full: Vec<(Kind, f64, f64)> =
        all.iter().filter_map(|refined| Some((of(refined)?, refined.deviance, refined.unknowns))).collect();
    for refined in all.iter_mut() {
        let Some(fuller) = of(refined).and_then(fuller_form) else { continue };
        let Some((_, deviance, unknowns)) = full.iter().find(|(kind, ..)| *kind == fuller) else { continue };
        let (better, more) = (refined.deviance - deviance, unknowns - refined.unknowns);
        if more > 0.0 && better > chi_squared_quantile(1.0 - NEEDED, more) {
            refined.why_not = Some(Fault::Idle(format!("{} explains more of the same", fuller.name())));
        }
    }
}

/// The effect of which another is a part.
fn fuller_form(kind: Kind) -> Option<Kind> {
    (kind == Kind::SunThermoelectric).then_some(Kind::SunThermoelectricHarmonics)
}

/// What the others of a list say against its first.
#[derive(Clone, Debug, Default)]
pub struct Rivals {
    /// Those that fit equally well.
    pub equal: Vec<String>,
    /// The others, and why they lost.
    pub lost: Vec<(String, String)>,
}

/// Holds the others of a list against its first, which all came to what a fit had left. Where something is left, they are equal also if
/// they differ by no more than that, and than the forms of effects are true to, and need no more unknowns.
pub fn rivals(
    fitter: &Fitter<'_, '_>,
    before: &Fit,
    refined: &[Refined],
    left: f64,
) -> Result<Rivals, Error> {
    let Rivals { mut equal, mut lost } = Rivals::default();
    let Some((best, others)) = refined.split_first() else { return Ok(Rivals { equal, lost }) };
    let of_forms = left.min(FORM * (before.cost - best.fit.cost));
    for other in others {
        let name = other.proposal.name.clone();
        let odds = if other.unknowns > best.unknowns { ODDS } else { ODDS.max(of_forms) };
        if let Some(why) = &other.why_not {
            lost.push((name, why.words().into()));
            continue;
        }
        let behind = other.criterion() - best.criterion();
        if behind > odds {
            let odds = (behind / 2.0).exp();
            let odds = if odds < 1e300 {
                format!("odds of {}", significant(odds, 2))
            } else {
                "odds beyond all counting".into()
            };
            lost.push((name, format!("it fits worse: {odds} against it")));
            continue;
        }
        let more = other.unknowns - best.unknowns;
        let better = best.deviance - other.deviance;
        let needless = more > 0.0 && better < chi_squared_quantile(1.0 - NEEDED, more);
        if needless && follows_the_same(other, best) && holds(fitter, other, best)? {
            let more = counted(more.round() as usize, "more unknown");
            lost.push((name, format!("it says the same with {more} that nothing asks for")));
            continue;
        }
        equal.push(name);
    }
    Ok(Rivals { equal, lost })
}

/// Whether a rival follows all that an effect follows: if not, it is another explanation, however many unknowns it has.
fn follows_the_same(rival: &Refined, effect: &Refined) -> bool {
    let covariates = |refined: &Refined| match &refined.proposal.addition {
        Addition::Effect(effect) => covariates::of(effect),
        Addition::Column(column) => column.follows.iter().map(|follows| follows.column.clone()).collect(),
    };
    let (theirs, own) = (covariates(rival), covariates(effect));
    if own.is_empty() { theirs.is_empty() } else { own.iter().all(|name| theirs.contains(name)) }
}

/// Whether all that an effect does can be done by a rival.
fn holds(fitter: &Fitter<'_, '_>, rival: &Refined, effect: &Refined) -> Result<bool, Error> {
    let own = fitter.jacobian(&effect.fit.state)?;
    let theirs = &rival.fit.jacobian;
    let width = theirs.ncols();
    // Without what is known of each beforehand: they have other unknowns.
    let rows = fitter.model.observed.rows;
    let columns: Vec<Vec<f64>> = (0..own.ncols()).map(|j| own.col_as_slice(j)[..rows].to_vec()).collect();
    let first: Vec<usize> = (0..width).collect();
    let screen = Screen::of(&fitter.products(theirs, &columns, &rival.fit.white)).given(&first)?;
    let base = fitter.model.unknowns.len();
    Ok((base..own.ncols()).all(|j| screen.visible(width + j) < HELD))
}
