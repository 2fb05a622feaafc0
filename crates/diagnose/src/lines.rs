//! Lines of unknown frequency: the periodogram of the whitened residual, all sensors of a recording together.
//!
//! `estimate::periodogram` takes lines out of one series whose noise it does not know; here the noise is
//! known, and the sensors count together. Uneven times go to the nearest half step.

use estimate::sine::{Series, Strongest, strongest};
use physics::{EffectInstance, Kind};

use crate::algebra::square;
use crate::channel::{Reader, Run};
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one, looks_along};
use crate::proposal::Proposal;

/// Fewest readings of a series whose lines are searched.
const SHORTEST: usize = 24;
/// Frequencies tried for each Fourier frequency.
const OVERSAMPLED: usize = 3;
/// Periods that the recording must hold to be searched, and for the name of a power supply.
const FEWEST: f64 = 2.0;
const PERIODS: f64 = 4.0;
/// Periods of a line that is no power supply's that must have been seen, in all recordings where it acts in all: fewer
/// follow a drive that is repeated.
const CYCLES: f64 = 10.0;
/// Share of what is left that such a line is: a smaller one is a part of something else.
const MOST: f64 = 0.8;
/// Nominal frequencies of power supplies and their harmonics, Hz.
const MAINS_HZ: [f64; 12] =
    [50.0, 60.0, 100.0, 120.0, 150.0, 180.0, 200.0, 240.0, 250.0, 300.0, 350.0, 360.0];
/// Nominal frequency of railway power, Hz.
const TRACTION_HZ: f64 = 50.0 / 3.0;
/// How far a power supply strays from its nominal frequency, as a share.
const STRAY: f64 = 2e-3;
/// A line by chance has an alias within that, at most so often, if the name is to mean anything.
const BY_CHANCE: f64 = 0.3;

#[derive(Clone, Debug)]
pub struct Line {
    /// Recording in which it is strongest.
    pub recording: String,
    /// Its frequency or alias, Hz.
    pub frequency_hz: f64,
    /// Probability of such a line by chance, over all frequencies.
    pub p: f64,
}

/// The strongest line, and the effects that it could be.
pub fn proposals(fitter: &Fitter<'_, '_>, fit: &Fit, rest: &Rest) -> (Option<Line>, Vec<Proposal>) {
    let observed = &fitter.model.observed;
    let mut looks = 0.0;
    let mut best: Option<(f64, f64, usize, f64, f64)> = None;
    for (number, run) in observed.runs.iter().enumerate() {
        let Some(time) = run.time_s else { continue };
        let own = observed.channels_of(number);
        let channels: Vec<_> =
            own.filter(|c| c.reader != Reader::Scalar && c.rows.len() >= SHORTEST).collect();
        let (Some(first), Some(last)) = (time.first(), time.last()) else { continue };
        let length = last - first;
        let Some(most) = channels.iter().map(|c| c.rows.len()).max().filter(|_| length > 0.0) else {
            continue;
        };
        let step = length / (most - 1) as f64;
        let rank = 2 * channels.len();
        let points = (2 * OVERSAMPLED * most).next_power_of_two();
        let series = channels.iter().map(|channel| Series {
            x: channel.rows.iter().map(|row| time[*row]).collect(),
            y: &fit.white[channel.range()],
            weight: 2.0 / channel.rows.len() as f64,
        });
        let series: Vec<Series<'_>> = series.collect();
        let tried = (FEWEST / length, 0.5 / step);
        let Some(found) = strongest(&series, 0.5 * step, points, tried) else { continue };
        let Strongest { frequency, power, band } = found;
        looks += looks_along(time, band, power);
        let p = rest.p(power, rank);
        if best.is_none_or(|(least, .., most)| p < least || (p == least && power > most)) {
            best = Some((p, frequency, number, step, power));
        }
    }
    let Some((p, frequency, number, step, gain)) = best else { return (None, Vec::new()) };
    let p = at_least_one(p, looks);
    let line = Line { recording: observed.runs[number].recording.id.clone(), frequency_hz: frequency, p };
    let length_s = |run: &Run<'_>| run.time_s.map(|time| time[time.len() - 1] - time[0]);
    let mut sources = aliases(frequency, 1.0 / step);
    // What is left of the recording beyond the noise; half of it, where nobody declared that.
    let channels = || observed.channels_of(number).filter(|channel| channel.reader != Reader::Scalar);
    let whole: f64 = channels().map(|channel| square(&fit.white[channel.range()])).sum();
    let rows = channels().map(|channel| channel.rows.len()).sum::<usize>() as f64;
    let beyond = if rest.known > 0.0 { whole - rows } else { 0.5 * whole };
    if frequency * length_s(&observed.runs[number]).unwrap_or(0.0) < PERIODS {
        sources.clear();
    }
    if sources.is_empty() && gain > MOST * beyond {
        sources.push((Kind::PeriodicField, frequency));
    }
    let timed: Vec<&Run<'_>> = observed.runs.iter().filter(|run| run.time_s.is_some()).collect();
    let all_s: f64 = timed.iter().copied().filter_map(length_s).sum();
    let mut found = Vec::new();
    for (kind, f) in sources {
        let name = kind.name();
        let of = |recording: Option<&String>, name: String, group: Option<&String>| {
            let parameters = [vec![0.0; 6], vec![f, 0.0]].concat();
            let effect = EffectInstance {
                recording: recording.cloned(),
                ..EffectInstance::new(kind, None, parameters)
            };
            Proposal { name, group: group.cloned(), ..Proposal::of(effect, p, gain, looks) }
        };
        // While a machine runs in one recording; in all, in phase or not.
        let enough = |length_s: f64| kind != Kind::PeriodicField || frequency * length_s > CYCLES;
        let one = &line.recording;
        if enough(all_s) {
            found.push(of(None, name.into(), None));
        }
        if timed.len() > 1 && enough(length_s(&observed.runs[number]).unwrap_or(0.0)) {
            found.push(of(Some(one), format!("{name} in \"{one}\""), None));
        }
        if timed.len() > 1 && enough(all_s) {
            let each = format!("{name} in each recording");
            // Their frequency was looked for once.
            let looks = timed.iter().map(|run| if run.recording.id == *one { looks } else { 1.0 });
            found.extend(timed.iter().zip(looks).map(|(run, looks)| Proposal {
                looks,
                ..of(Some(&run.recording.id), each.clone(), Some(&each))
            }));
        }
    }
    (Some(line), found)
}

/// Frequencies of power supplies that appear at this one when sampled at a rate.
pub fn aliases(frequency: f64, rate: f64) -> Vec<(Kind, f64)> {
    let nominal = MAINS_HZ.iter().map(|f| (Kind::Mains, *f)).chain([(Kind::TractionPower, TRACTION_HZ)]);
    let found: Vec<(Kind, f64, f64)> = nominal
        .map(|(kind, nominal)| {
            let nearest = [frequency, -frequency]
                .into_iter()
                .map(|f| f + rate * ((nominal - f) / rate).round())
                .min_by(|a, b| (a - nominal).abs().total_cmp(&(b - nominal).abs()))
                .unwrap_or(frequency);
            (kind, nearest, (nearest / nominal - 1.0).abs())
        })
        .collect();
    let chance: f64 = MAINS_HZ.iter().map(|f| 4.0 * f * STRAY / rate).sum();
    let mut found: Vec<_> =
        found.into_iter().filter(|(.., off)| *off < STRAY && chance.min(1.0) < BY_CHANCE).collect();
    found.sort_by(|a, b| a.2.total_cmp(&b.2));
    found.into_iter().map(|(kind, f, _)| (kind, f)).take(2).collect()
}
