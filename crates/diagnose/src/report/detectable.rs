//! What the recordings could have shown.

use common::Detectable;
use estimate::stats::chi_squared_quantile;
use indexmap::IndexMap;
use physics::{EffectInstance, Role};

use crate::model::target;
use crate::proposal::What;
use crate::search::Searcher;
use crate::{Error, Outcome};

/// Standard deviations that make nine claims of ten out of five.
const NINE_OF_TEN: f64 = 1.2816;

/// For each candidate that was not found, the smallest size that would be claimed nine times in ten.
pub(super) fn detectable(
    searcher: &mut Searcher<'_, '_>,
    outcome: &Outcome,
) -> Result<Vec<Detectable>, Error> {
    let mut all = match &searcher.detectable {
        Some(all) => all.clone(),
        None => of_all(searcher, outcome)?,
    };
    let is_found = |one: &Detectable| {
        let of = |effect: &EffectInstance| one.effect == effect.kind.name() && one.target == target(effect);
        outcome.now.fit.state.effects.iter().any(of)
    };
    all.retain(|one| !is_found(one));
    Ok(all)
}

/// The same for each candidate, found or not.
pub fn of_all(searcher: &mut Searcher<'_, '_>, outcome: &Outcome) -> Result<Vec<Detectable>, Error> {
    let (_, screen) = searcher.screen(&outcome.now.fitter(searcher.model), &outcome.now.fit)?;
    let scale = outcome.now.look.rest.scale();
    let mut all: Vec<Detectable> = Vec::new();
    for (number, candidate) in searcher.pool.candidates.iter().enumerate() {
        let What::Physics(effect) = &candidate.what else { continue };
        // Once for each name, whatever it begins with.
        let target = target(effect);
        let is_told = |one: &Detectable| one.effect == effect.kind.name() && one.target == target;
        if effect.recording.is_some() || all.iter().any(is_told) {
            continue;
        }
        let infos = effect.kind.parameters().iter();
        let sizes = infos.filter(|info| (info.role == Role::Amplitude) != candidate.finite);
        let amplitudes: Vec<&str> = sizes.map(|info| info.name).collect();
        let threshold = chi_squared_quantile(1.0 - searcher.threshold(number), amplitudes.len() as f64);
        let z = threshold.sqrt() + NINE_OF_TEN;
        let mut smallest: IndexMap<String, f64> = IndexMap::new();
        let mut visible = 0.0_f64;
        for of in candidate.shapes.iter().filter(|of| of.form.is_none()) {
            for (name, column) in amplitudes.iter().zip(&of.columns) {
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
                    match of.value.filter(|_| size <= 1.0) {
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
