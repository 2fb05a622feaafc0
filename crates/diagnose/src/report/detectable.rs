//! What the recordings could have shown.

use common::Detectable;
use estimate::stats::chi_squared_quantile;
use indexmap::IndexMap;
use physics::{EffectInstance, Role};

use crate::fit::Fitter;
use crate::search::Searcher;
use crate::what::What;
use crate::{Error, Options, Outcome};

/// Standard deviations that make nine claims of ten out of five.
const NINE_OF_TEN: f64 = 1.2816;

/// For each candidate of the catalogue that was not found, the smallest size that would have been claimed
/// nine times in ten.
pub(super) fn detectable(
    searcher: &mut Searcher,
    outcome: &Outcome,
    fitter: &Fitter<'_, '_>,
    options: &Options,
) -> Result<Vec<Detectable>, Error> {
    let mut all = match &searcher.detectable {
        Some(all) => all.clone(),
        None => of_all(searcher, outcome, fitter, options)?,
    };
    let is_found = |one: &Detectable| {
        let of = |effect: &EffectInstance| one.effect == effect.kind.name() && one.target == target(effect);
        outcome.fit.state.effects.iter().any(of)
    };
    all.retain(|one| !is_found(one));
    Ok(all)
}

/// The same for each candidate, found or not.
pub fn of_all(
    searcher: &mut Searcher,
    outcome: &Outcome,
    fitter: &Fitter<'_, '_>,
    options: &Options,
) -> Result<Vec<Detectable>, Error> {
    let (_, screen) = searcher.screen(fitter, &outcome.fit)?;
    let scale = outcome.last.rest.scale();
    let mut all: Vec<Detectable> = Vec::new();
    for (number, candidate) in searcher.pool.candidates.iter().enumerate() {
        let What::Physics(effect) = &candidate.what else { continue };
        // Once for each name, whatever it begins with.
        let target = target(effect);
        let is_told = |one: &Detectable| one.effect == effect.kind.name() && one.target == target;
        if effect.recording.is_some() || all.iter().any(is_told) {
            continue;
        }
        let amplitudes: Vec<&str> = effect
            .kind
            .parameters()
            .iter()
            .filter(|info| (info.role == Role::Amplitude) != candidate.finite)
            .map(|info| info.name)
            .collect();
        let threshold =
            chi_squared_quantile(1.0 - searcher.threshold(number, options.level), amplitudes.len() as f64);
        let z = threshold.sqrt() + NINE_OF_TEN;
        let mut smallest: IndexMap<String, f64> = IndexMap::new();
        let mut visible = 0.0_f64;
        for trial in candidate.trials.iter().filter(|trial| trial.fuller.is_none()) {
            for (name, column) in amplitudes.iter().zip(&trial.columns) {
                visible = visible.max(screen.visible(*column));
                let one = screen.gain(&[*column])?;
                if one.rank == 0 {
                    continue;
                }
                let mut size = z * (one.covariance[(0, 0)] * scale).sqrt();
                // Of a column that the calibration takes up but for rounding, no size would be seen.
                if !size.is_finite() {
                    continue;
                }
                if candidate.finite {
                    // The column is what the effect does at this shape, so that a share of it is about that
                    // share of the shape.
                    match trial.shape.filter(|_| size <= 1.0) {
                        Some(shape) => size *= shape,
                        None => continue,
                    }
                }
                let entry = smallest.entry((*name).to_string()).or_insert(f64::INFINITY);
                *entry = entry.min(size);
            }
        }
        all.push(Detectable {
            effect: effect.kind.name().into(),
            target,
            smallest,
            visible_fraction: visible,
        });
    }
    Ok(all)
}

/// What an effect acts on.
fn target(effect: &EffectInstance) -> Option<String> {
    effect.axis.map(|axis| axis.to_string()).or_else(|| effect.column.clone())
}
