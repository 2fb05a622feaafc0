//! Plain regressions of what the calibration fitted again has left, under the same noise and on the same held-out
//! readings as the names.

use common::PlainRegression;
use faer::Mat;
use physics::Acts;

use super::residuals::{held_out_nt, rms};
use crate::candidates::Candidate;
use crate::fit::{Fit, Fitter};
use crate::pool::searched;
use crate::search::Searcher;
use crate::what::What;
use crate::{Error, Outcome};

pub(super) fn rivals(
    fitter: &Fitter<'_, '_>,
    searcher: &mut Searcher,
    outcome: &Outcome,
) -> Result<Vec<PlainRegression>, Error> {
    let base = fitter.at(&outcome.base.state)?;
    let (mut projection, mut screen) = searcher.screen(fitter, &base)?;
    let pool = searcher.pool.clone();
    let mut products = searcher.products(fitter).clone();
    let named = pool.candidates.iter().filter(|one| !matches!(one.what, What::Smooth { .. }));
    let (names, groups): (Vec<String>, Vec<&[usize]>) = named
        .flat_map(|one| one.trials.iter().map(|trial| (one.what.name(), trial.columns.as_slice())))
        .unzip();
    let mut taken = Vec::new();
    let chosen = screen.clone().stepwise(&groups, |chosen| {
        let newest = chosen.last().map_or(&[][..], |number| groups[*number]);
        taken.extend(products.len()..products.len() + newest.len());
        products.push_again(newest, 0);
        projection.extend(&mut screen, &products);
        screen.given(&taken)
    })?;
    let follows = |one: &&Candidate| match &one.what {
        What::Physics(effect) => {
            matches!(effect.kind.about().acts, Acts::WithColumn(_)) && searched(effect.kind).is_none()
        }
        What::Smooth { .. } => false,
    };
    let recorded = pool.candidates.iter().filter(follows);
    let (straight, every): (Vec<String>, Vec<&[usize]>) =
        recorded.filter_map(|one| Some((one.what.name(), one.trials.first()?.columns.as_slice()))).unzip();
    let mut of = |name: &str, mut terms: Vec<String>, groups: Vec<&[usize]>| -> Result<_, Error> {
        let columns: Vec<usize> = groups.concat();
        let fit = beside(fitter, searcher, &base, &columns);
        let held = held_out_nt(fitter.model, &fitter.held_out(&fit)?, &fit);
        terms.sort_unstable();
        terms.dedup();
        Ok(PlainRegression { name: name.into(), held_out_nt: rms(held.iter().flatten().copied()), terms })
    };
    Ok(vec![
        of(
            "stepwise regression",
            chosen.iter().map(|number| names[*number].clone()).collect(),
            chosen.iter().map(|number| groups[*number]).collect(),
        )?,
        of("least squares with every column", straight, every)?,
    ])
}

/// A fit with further columns of the pool beside its own.
fn beside(fitter: &Fitter<'_, '_>, searcher: &mut Searcher, base: &Fit, columns: &[usize]) -> Fit {
    let products = searcher.products(fitter);
    let observed = &fitter.model.observed;
    let more: Vec<Vec<f64>> = columns.iter().map(|column| products.column(*column).dense(observed)).collect();
    let own = base.jacobian.ncols();
    let value = |i: usize, j: usize| match j.checked_sub(own) {
        None => base.jacobian[(i, j)],
        Some(column) => more[column].get(i).copied().unwrap_or(0.0),
    };
    Fit { jacobian: Mat::from_fn(base.white.len(), own + more.len(), value).into(), ..base.clone() }
}
