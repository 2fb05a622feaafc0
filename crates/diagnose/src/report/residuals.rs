//! How well the recordings are met.

use common::{Residual, ResidualOf};

use super::rivals::rivals;
use crate::channel::Channel;
use crate::fit::{Fit, Fitter};
use crate::held_out::HeldOut;
use crate::model::Model;
use crate::search::Searcher;
use crate::{Error, Outcome};

/// Rms of the noise over all readings, nT.
pub(super) fn floor(outcome: &Outcome) -> f64 {
    (outcome.noise.variance() * outcome.last.rest.scale()).sqrt()
}

/// What the fits leave of all readings and of those left out, beside plain regressions.
pub fn fit(model: &Model<'_>, searcher: &mut Searcher, outcome: &Outcome) -> Result<Residual, Error> {
    let fitter = &Fitter { model, noise: &outcome.noise };
    let base = Fitter { model, noise: &outcome.base_noise };
    let held_before = held_out_nt(model, &base.held_out(&outcome.base)?, &outcome.base);
    let held_after = held_out_nt(model, &fitter.held_out(&outcome.fit)?, &outcome.fit);
    let scale = outcome.last.rest.scale().sqrt();
    let of_channel = |(channel, std): (&Channel, &f64)| ResidualOf {
        recording: model.observed.runs[channel.run].recording.id.clone(),
        column: channel.column.clone(),
        rms_before_nt: rms(outcome.before[channel.range()].iter().copied()),
        rms_after_nt: rms(outcome.fit.residual[channel.range()].iter().copied()),
        held_out_before_nt: rms(held_before[channel.range()].iter().flatten().copied()),
        held_out_after_nt: rms(held_after[channel.range()].iter().flatten().copied()),
        noise_floor_nt: std * scale,
    };
    Ok(Residual {
        rms_before_nt: rms(outcome.before.iter().copied()),
        rms_refitted_nt: rms(outcome.base.residual.iter().copied()),
        rms_after_nt: rms(outcome.fit.residual.iter().copied()),
        held_out_before_nt: rms(held_before.iter().flatten().copied()),
        held_out_after_nt: rms(held_after.iter().flatten().copied()),
        noise_floor_nt: floor(outcome),
        noise_source: outcome.noise.source.into(),
        by_recording: model.observed.channels.iter().zip(&outcome.noise.std_nt).map(of_channel).collect(),
        plain: rivals(fitter, searcher, outcome)?,
        ..Residual::default()
    })
}

pub(super) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// Of each reading, how far it is from what the others predict of it: in units of what is new in its noise,
/// times what such a unit is in the fit's residual of its channel, nT. (Of noise with memory a recording has
/// by chance more or less than its declaration.)
pub(super) fn held_out_nt(model: &Model<'_>, held: &HeldOut, fit: &Fit) -> Vec<Option<f64>> {
    let of_channel = |channel: &Channel| -> Vec<Option<f64>> {
        let [in_nt, white] = [&fit.residual, &fit.white].map(|all| rms(all[channel.range()].iter().copied()));
        let unit = if white > 0.0 { in_nt / white } else { 0.0 };
        held.squares[channel.range()].iter().map(|square| square.map(|square| square.sqrt() * unit)).collect()
    };
    model.observed.channels.iter().flat_map(of_channel).collect()
}
