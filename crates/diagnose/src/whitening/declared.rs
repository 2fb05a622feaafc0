//! The noise of each channel: as the document declares it, or as a residual shows it.

use common::{Axis, Document, Noise};
use nalgebra::Vector3;
use physics::{EffectInstance, Kind, SensorConstants, Setting, Unit};
use std::collections::BTreeMap;

use crate::channel::{Channel, Reader};
use crate::decide::DECLARED;
use crate::model::State;
use crate::observed::Observed;

/// Fewest readings of a sensor that give its white noise by themselves.
const ALONE_FROM: usize = 40;

pub(super) fn declared(observed: &Observed<'_>, state: &State, channel: &Channel) -> Option<Noise> {
    let document = observed.document;
    let mut noise = match channel.reader {
        Reader::Scalar => {
            let std = document.facility.as_ref()?.reference_std_nt?;
            Noise { white_rms_nt: Some(std), ..Noise::default() }
        }
        Reader::Sensor(axis) => document.instrument.as_ref()?.noise_of(axis)?.clone(),
        Reader::Magnitude => of_magnitude(document, channel)?,
    };
    let code = code_nt(observed, channel);
    let white = noise.white_rms_nt.unwrap_or(0.0);
    let variance = match effect_width_nt(state, channel) {
        Some((width, true)) => about_a_code(white, width),
        Some((width, false)) => white * white + width * width / 12.0,
        None => white * white,
    };
    noise.white_rms_nt = Some((variance + code * code / 12.0).sqrt());
    (noise.white_rms_nt > Some(0.0)).then_some(noise)
}

/// The noise of a corrected vector's length and of the scalar magnetometer beside it: each sensor's counts by
/// its mean share. The scalar magnetometer's is none where the document does not state it.
fn of_magnitude(document: &Document, channel: &Channel) -> Option<Noise> {
    let instrument = document.instrument.as_ref()?;
    let scalar = document.facility.as_ref().and_then(|facility| facility.reference_std_nt).unwrap_or(0.0);
    let mut all = Noise::default();
    let (mut white, mut flicker, mut walk, mut most) = (scalar * scalar, 0.0, 0.0, 0.0);
    for (axis, share) in Axis::ALL.into_iter().zip(mean_shares(channel)) {
        let noise = instrument.noise_of(axis)?;
        let own = share * noise.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0);
        white += share * noise.white_rms_nt.unwrap_or(0.0).powi(2);
        walk += share * noise.random_walk_nt_per_sqrt_s.unwrap_or(0.0).powi(2);
        flicker += own;
        if own > most {
            (most, all.flicker_exponent) = (own, noise.flicker_exponent);
        }
        if noise.relative_std > all.relative_std {
            all.relative_std = noise.relative_std;
        }
    }
    all.white_rms_nt = Some(white.sqrt());
    all.flicker_nt2_per_hz_at_1hz = Some(flicker);
    all.random_walk_nt_per_sqrt_s = Some(walk.sqrt());
    Some(all)
}

/// Mean over the rows of each sensor's squared share in a magnitude.
fn mean_shares(channel: &Channel) -> [f64; 3] {
    let squares = channel.shares.iter().fold(Vector3::zeros(), |sum, share| sum + share.component_mul(share));
    (squares / channel.rows.len().max(1) as f64).into()
}

/// Width of a channel's codes, nT; of a magnitude, of codes that would round as much as its sensors'.
pub fn code_nt(observed: &Observed<'_>, channel: &Channel) -> f64 {
    let Some(instrument) = observed.document.instrument.as_ref() else { return 0.0 };
    let Setting { basic, context } = &observed.runs[channel.run].setting;
    let code = match context.unit {
        Unit::Volt => instrument.quantisation_v,
        Unit::Nanotesla => instrument.quantisation_nt,
    };
    let code = code.unwrap_or(0.0);
    match channel.reader {
        Reader::Scalar => 0.0,
        Reader::Sensor(_) => code * channel.to_nt.abs(),
        Reader::Magnitude => {
            let of = |(sensor, share): (&SensorConstants<f64>, f64)| share * sensor.sensitivity.powi(2);
            code * basic.sensors.iter().zip(mean_shares(channel)).map(of).sum::<f64>().sqrt()
        }
    }
}

/// Width of the codes that effects give a channel, nT, and whether they are part of what is predicted.
fn effect_width_nt(state: &State, channel: &Channel) -> Option<(f64, bool)> {
    let of = |effect: &EffectInstance| {
        effect.kind == Kind::Quantisation
            && effect.axis.is_some_and(|axis| channel.reader == Reader::Sensor(axis))
    };
    let found = state.effects.iter().zip(&state.acts).find(|(effect, _)| of(effect));
    found.map(|(effect, acts)| (effect.parameters[0], acts.contains(&true)))
}

/// Variance of a reading about the code of its field, nT²: noise before the converter takes fields close to
/// an edge to the next code.
///
/// E[(q round(u + n/q) − q round(u))²] over u even in a code: q² E[m² + (2m + 1)(t − m)], t = |n|/q, m = ⌊t⌋.
/// For fine codes it is σ² + q²/6, for coarse ones q σ √(2/π).
fn about_a_code(std: f64, width: f64) -> f64 {
    const STEPS: usize = 2000;
    const FARTHEST: f64 = 8.0;
    let step = FARTHEST / STEPS as f64;
    let (mut sum, mut weights) = (0.0, 0.0);
    for z in (0..STEPS).map(|k| (k as f64 + 0.5) * step) {
        let weight = (-0.5 * z * z).exp();
        let t = z * std / width;
        let m = t.floor();
        sum += weight * (m * m + (2.0 * m + 1.0) * (t - m));
        weights += weight;
    }
    width * width * sum / weights
}

/// 1/(2 u²) for the largest relative uncertainty u of a declared noise, as it is stated or else taken to be.
pub fn known_freedom(declared: &[Option<Noise>]) -> f64 {
    if declared.iter().any(Option::is_none) {
        return 0.0;
    }
    let relative = |noise: &Noise| noise.relative_std.unwrap_or(DECLARED);
    let relative = declared.iter().flatten().map(relative).fold(0.0, f64::max);
    if relative > 0.0 { 0.5 / (relative * relative) } else { f64::INFINITY }
}

/// White noise of each kind of channel as a residual shows it.
pub(super) fn estimate(observed: &Observed<'_>, residual: &[f64]) -> Vec<Noise> {
    let kinds = kinds(observed);
    let mut sums: BTreeMap<&str, (f64, usize)> = BTreeMap::new();
    for (channel, kind) in observed.channels.iter().zip(&kinds) {
        let sum: f64 = residual[channel.range()].iter().map(|r| r * r).sum();
        let entry = sums.entry(kind).or_default();
        *entry = (entry.0 + sum, entry.1 + channel.rows.len());
    }
    let of = |(channel, kind): (&Channel, &String)| {
        let (sum, count) = sums[kind.as_str()];
        let variance = (sum / count as f64).max(least_nt2(observed, channel));
        Noise { white_rms_nt: Some(variance.sqrt()), ..Noise::default() }
    };
    observed.channels.iter().zip(&kinds).map(of).collect()
}

/// The least variance of a channel: that of its codes.
pub(super) fn least_nt2(observed: &Observed<'_>, channel: &Channel) -> f64 {
    (code_nt(observed, channel).powi(2) / 12.0).max(f64::MIN_POSITIVE.sqrt())
}

/// What each channel shares its noise with: its sensor's channels, or all where a sensor read too little.
pub(super) fn kinds(observed: &Observed<'_>) -> Vec<String> {
    let of = |channel: &Channel| match channel.reader {
        Reader::Scalar => "scalar".to_string(),
        Reader::Magnitude => "magnitude".to_string(),
        Reader::Sensor(axis) => axis.to_string(),
    };
    let kinds: Vec<String> = observed.channels.iter().map(of).collect();
    let mut readings: BTreeMap<&str, usize> = BTreeMap::new();
    for (channel, kind) in observed.channels.iter().zip(&kinds) {
        *readings.entry(kind).or_default() += channel.rows.len();
    }
    if readings.values().all(|count| *count >= ALONE_FROM) { kinds } else { vec!["all".into(); kinds.len()] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_through_a_converter_has_both_limits() {
        let fine = about_a_code(1.0, 0.01);
        assert!((fine - (1.0 + 0.01 * 0.01 / 6.0)).abs() < 1e-4, "{fine}");
        let coarse = about_a_code(1.0, 100.0) / (100.0 * (2.0 / std::f64::consts::PI).sqrt());
        assert!((coarse - 1.0).abs() < 1e-4, "{coarse}");
    }
}
