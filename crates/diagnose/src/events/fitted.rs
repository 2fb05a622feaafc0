//! One effect more, fitted to what is left.

use physics::{EffectInstance, Parameter, Role};

use crate::Error;
use crate::fit::{Fit, Fitter};

/// An effect with its amplitudes fitted to a residual, and what that gains.
pub fn fitted(
    fitter: &Fitter<'_, '_>,
    fit: &Fit,
    effect: &EffectInstance,
) -> Result<(EffectInstance, f64, usize), Error> {
    let with = fitter.model.with(&fit.state, effect.clone());
    let number = with.effects.len() - 1;
    let amplitudes: Vec<usize> = effect
        .kind
        .parameters()
        .iter()
        .enumerate()
        .filter(|(_, info)| info.role == Role::Amplitude)
        .map(|(k, _)| k)
        .collect();
    let parameters: Vec<Parameter> = amplitudes.iter().map(|k| Parameter::Effect(number, *k)).collect();
    let gain = fitter.gain_of(fit, &fitter.model.derivatives(&with, &parameters)?)?;
    let mut effect = effect.clone();
    for (at, value) in amplitudes.iter().zip(&gain.coefficients) {
        effect.parameters[*at] = *value;
    }
    Ok((effect, gain.gain, gain.rank))
}
