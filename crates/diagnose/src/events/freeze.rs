//! Readings that freeze: rows side by side that all depart, as far as the field has moved since the first of
//! them.

use estimate::events::Departures;
use estimate::stats::median;
use physics::{EffectInstance, Kind};

use crate::Error;
use crate::channel::Reader;
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one};
use crate::proposal::Proposal;

/// A row departs when its departure is more than so many standard deviations, and so many times the middle
/// one: a large departure pulls the calibration, and with it all other rows.
const DEPARTS: f64 = 4.0;

/// Rows to either side of a stretch that may belong to it.
const MARGIN: usize = 3;

pub fn proposal(
    fitter: &Fitter<'_, '_>,
    fit: &Fit,
    rest: &Rest,
    all: &[Departures],
) -> Result<Option<Proposal>, Error> {
    let observed = &fitter.model.observed;
    let mut strongest: Option<(f64, usize, usize, usize)> = None;
    let mut looks = 0.0;
    for (number, (channel, departures)) in observed.channels.iter().zip(all).enumerate() {
        looks += (channel.rows.len() as f64).powi(2);
        if observed.runs[channel.run].time_s.is_none() || !matches!(channel.reader, Reader::Sensor(_)) {
            continue;
        }
        let one = &departures.lengths()[0];
        let squared = |row: usize| departures.along[row].powi(2) / one[row];
        let middle = median(&(0..channel.rows.len()).map(squared).collect::<Vec<_>>());
        let least = DEPARTS * DEPARTS * middle.max(1.0);
        let mut first = None;
        let mut sum = 0.0;
        for row in 0..=channel.rows.len() {
            let departs = row < channel.rows.len() && squared(row) > least;
            if departs {
                first.get_or_insert(row);
                sum += squared(row);
            } else if let Some(from) = first.take() {
                if row - from >= 2 && strongest.is_none_or(|(most, ..)| sum > most) {
                    strongest = Some((sum, number, from, row));
                }
                sum = 0.0;
            }
        }
    }
    let Some((_, number, from, to)) = strongest else { return Ok(None) };
    let channel = &observed.channels[number];
    let run = &observed.runs[channel.run];
    let (Some(time), Reader::Sensor(axis)) = (run.time_s, channel.reader) else { return Ok(None) };
    let last = channel.rows.len() - 1;
    let predicted = &fitter.model.predicted(&fit.state)?[channel.range()];
    let residual = &fit.residual[channel.range()];
    // What is left of the residual where a stretch repeats what was predicted of its first row.
    let mut best: Option<(f64, usize, usize)> = None;
    for begin in from.saturating_sub(MARGIN)..to {
        let mut gain = 0.0;
        for end in begin + 1..=(to + MARGIN).min(last) {
            let frozen = predicted[begin] - predicted[end - 1];
            gain += residual[end - 1].powi(2) - (residual[end - 1] - frozen).powi(2);
            if gain > best.map_or(0.0, |(most, ..)| most) {
                best = Some((gain, begin, end));
            }
        }
    }
    let Some((_, begin, end)) = best else { return Ok(None) };
    let moment = |row: usize| time[channel.rows[row]];
    let parameters = vec![moment(begin), moment(end) - moment(begin)];
    let effect = EffectInstance {
        recording: Some(run.recording.id.clone()),
        ..EffectInstance::new(Kind::Dropout, Some(axis), parameters)
    };
    let gain = fitter.gain_as_it_is(fit, &effect)?;
    let p = at_least_one(rest.p_of_event(gain, all[number].scatter, 1), looks);
    Ok((gain > 0.0).then(|| Proposal::event(effect, &run.recording.id, p, gain, looks)))
}
