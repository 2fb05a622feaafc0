//! How well the recordings are met, beside plain regressions of what the calibration fitted again has left, under the
//! same noise and on the same held-out readings as the names.

use common::{PlainRegression, Residual, ResidualOf};
use faer::Mat;
use physics::Acts;

use crate::candidates::Candidate;
use crate::channel::Channel;
use crate::fit::{Fit, Fitter};
use crate::held_out::HeldOut;
use crate::model::Model;
use crate::pool::searched;
use crate::proposal::What;
use crate::search::Searcher;
use crate::{Error, Outcome};

/// Rms of the noise over all readings, nT.
pub(super) fn floor(outcome: &Outcome) -> f64 {
    (outcome.now.noise.variance() * outcome.now.look.rest.scale()).sqrt()
}

/// What the fits leave of all readings and of those left out, beside plain regressions.
pub fn fit(searcher: &mut Searcher<'_, '_>, outcome: &Outcome) -> Result<Residual, Error> {
    let model = searcher.model;
    let (fitter, base) = (&outcome.now.fitter(model), outcome.base.fitter(model));
    let held_before = held_out_nt(model, &base.held_out(&outcome.base.fit)?, &outcome.base.fit);
    let held_after = held_out_nt(model, &fitter.held_out(&outcome.now.fit)?, &outcome.now.fit);
    let scale = outcome.now.look.rest.scale().sqrt();
    let of_channel = |(channel, std): (&Channel, &f64)| ResidualOf {
        recording: model.observed.runs[channel.run].recording.id.clone(),
        column: channel.column.clone(),
        rms_before_nt: rms(outcome.before[channel.range()].iter().copied()),
        rms_after_nt: rms(outcome.now.fit.residual[channel.range()].iter().copied()),
        held_out_before_nt: rms(held_before[channel.range()].iter().flatten().copied()),
        held_out_after_nt: rms(held_after[channel.range()].iter().flatten().copied()),
        noise_floor_nt: std * scale,
    };
    Ok(Residual {
        rms_before_nt: rms(outcome.before.iter().copied()),
        rms_refitted_nt: rms(outcome.base.fit.residual.iter().copied()),
        rms_after_nt: rms(outcome.now.fit.residual.iter().copied()),
        held_out_before_nt: rms(held_before.iter().flatten().copied()),
        held_out_after_nt: rms(held_after.iter().flatten().copied()),
        noise_floor_nt: floor(outcome),
        noise_source: if outcome.now.noise.known > 0.0 { "declared" } else { "residuals" }.into(),
        by_recording: model.observed.channels.iter().zip(&outcome.now.noise.std_nt).map(of_channel).collect(),
        plain: rivals(fitter, searcher, outcome)?,
        ..Residual::default()
    })
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// Of each reading, how far it is from what the others predict of it: in units of what is new in its noise,
/// times what such a unit is in the fit's residual of its channel, nT. (Of noise with memory a recording has
/// by chance more or less than its declaration.)
fn held_out_nt(model: &Model<'_>, held: &HeldOut, fit: &Fit) -> Vec<Option<f64>> {
    let of_channel = |channel: &Channel| -> Vec<Option<f64>> {
        let [in_nt, white] = [&fit.residual, &fit.white].map(|all| rms(all[channel.range()].iter().copied()));
        let unit = if white > 0.0 { in_nt / white } else { 0.0 };
        held.squares[channel.range()].iter().map(|square| square.map(|square| square.sqrt() * unit)).collect()
    };
    model.observed.channels.iter().flat_map(of_channel).collect()
}

fn rivals(
    fitter: &Fitter<'_, '_>,
    searcher: &mut Searcher<'_, '_>,
    outcome: &Outcome,
) -> Result<Vec<PlainRegression>, Error> {
    let base = fitter.at(&outcome.base.fit.state)?;
    let (mut projection, mut screen) = searcher.screen(fitter, &base)?;
    let pool = searcher.pool.clone();
    let mut products = searcher.products(fitter).clone();
    let named = pool.candidates.iter().filter(|one| one.what.is_named());
    let (names, groups): (Vec<String>, Vec<&[usize]>) = named
        .flat_map(|one| one.shapes.iter().map(|shape| (one.what.name(), shape.columns.as_slice())))
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
        _ => false,
    };
    let recorded = pool.candidates.iter().filter(follows);
    let (straight, every): (Vec<String>, Vec<&[usize]>) =
        recorded.filter_map(|one| Some((one.what.name(), one.shapes.first()?.columns.as_slice()))).unzip();
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
fn beside(fitter: &Fitter<'_, '_>, searcher: &mut Searcher<'_, '_>, base: &Fit, columns: &[usize]) -> Fit {
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
