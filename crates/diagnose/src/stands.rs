//! Which fit stands: the weighted one, or least squares.
//!
//! Weights rest on where noise is small. Where two instruments are held against each other, the noise that is
//! estimated from what is left is small at short periods because the field is, and what weighs most there is
//! what they do not share: filters, local noise, iron that only one feels. Least squares rest on what is
//! strong, which is slow, and no weight makes them leave more than came. So where the noise of a magnitude is
//! not declared, the weights say what is determined and how well, and least squares say what the constants
//! are. By how much the two are apart is part of the uncertainty.

use faer::Mat;
use physics::{EffectInstance, Role};

use crate::Error;
use crate::Outcome;
use crate::algebra::square;
use crate::channel::Channel;
use crate::fit::{Fit, Fitter, settled_white};
use crate::magnitude;
use crate::model::{Model, State};
use crate::whitening::NoiseModel;

/// A sum of squares is as large up to this share: the rms of weighted fits is met to half of that.
const AS_LARGE: f64 = 1e-4;

/// Gives an outcome the fits that stand; the calibration stays as it came where a refit would leave more.
pub fn standing(model: &Model<'_>, start: &State, outcome: &mut Outcome) -> Result<(), Error> {
    let most = square(&outcome.before) * (1.0 + AS_LARGE);
    // Where nothing was added there is one fit.
    let same = outcome.found.is_empty() && outcome.now.fit.residual == outcome.base.fit.residual;
    let mut base = least(model, (&outcome.base.fit, &outcome.base.noise))?;
    if square(&base.residual) > most {
        outcome
            .notes
            .push("the stated calibration is kept, because refitting it would increase the residual".into());
        base = outcome.base.fitter(model).at(start)?;
    }
    outcome.now.fit = if same { base.clone() } else { least(model, (&outcome.now.fit, &outcome.now.noise))? };
    outcome.base.fit = base;
    if model.only_magnitudes() && worse_corrected(model, outcome) {
        outcome.without_names("its correction increases the difference from the scalar magnetometer");
    }
    Ok(())
}

/// Whether the readings of vectors, corrected by the effects that were found, are farther from the scalar
/// magnetometer than corrected without them: an effect enters the fit by its part along the field, and one
/// that is no small part of the field need not be met where the chain is solved for the field.
fn worse_corrected(model: &Model<'_>, outcome: &Outcome) -> bool {
    if outcome.now.fit.state.effects.len() == outcome.base.fit.state.effects.len() {
        return false;
    }
    let left = |state: &State| -> Option<f64> {
        let of = |channel: &Channel| {
            let (basic, context) = model.setting(state, channel.run);
            let effects = state.effects.iter().zip(&state.acts).filter(|(_, acts)| acts[channel.run]);
            let effects: Vec<EffectInstance> = effects.map(|(effect, _)| effect.clone()).collect();
            Some(square(&magnitude::solved(channel, (&basic, &context), &effects)?))
        };
        model.observed.channels.iter().map(of).sum()
    };
    match (left(&outcome.base.fit.state), left(&outcome.now.fit.state)) {
        (Some(without), Some(with)) => with > without,
        (Some(_), None) => true,
        (None, _) => false,
    }
}

/// The fit by least squares where there are only magnitudes of undeclared noise; else the weighted one.
fn least(model: &Model<'_>, (weighted, noise): (&Fit, &NoiseModel)) -> Result<Fit, Error> {
    if noise.known > 0.0 || !model.only_magnitudes() {
        return Ok(weighted.clone());
    }
    let (plain, _) = settled_white(model, &weighted.state)?;
    let at = Fitter { model, noise }.at(&plain.state)?;
    let as_weighted = Fit { covariance: weighted.covariance.clone(), beyond: weighted.beyond.clone(), ..at };
    Ok(as_weighted.widened(&apart(model, weighted, &plain)))
}

/// By how much least squares are off a weighted fit, as what comes on top of its covariance.
fn apart(model: &Model<'_>, weighted: &Fit, plain: &Fit) -> Mat<f64> {
    let [from, to] = [weighted, plain].map(|fit| unknowns(model, &fit.state));
    let off: Vec<f64> = to.iter().zip(&from).map(|(to, from)| to - from).collect();
    Mat::from_fn(off.len(), off.len(), |i, j| off[i] * off[j])
}

/// The unknowns of a state in the order of a fit's columns, shapes by their logarithm.
fn unknowns(model: &Model<'_>, state: &State) -> Vec<f64> {
    let of_effects = model.free(state).into_iter().map(|(effect, parameter)| {
        let effect = &state.effects[effect];
        let value = effect.parameters[parameter];
        if effect.kind.parameters()[parameter].role == Role::Shape { value.ln() } else { value }
    });
    let of_singles = state.singles.iter().map(|single| single.height_nt);
    let of_past = state.past.iter().map(|past| past.height_nt);
    state.base.iter().copied().chain(of_effects).chain(of_singles).chain(of_past).collect()
}
