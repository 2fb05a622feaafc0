//! Running means: their delay is the same at all periods, and seems a clock's; their response,
//! sin(πfT)/(πfT), is theirs alone.
//!
//! Response and delay by bands are held against three forms: none, g and δ for all; a low-pass filter of
//! first order; a mean over T. Noise of the reference lowers the response too, at most by the share of what
//! is left in a band in the field there; an uncertainty as large as that stands beside each response.

use std::f64::consts::{PI, TAU};

use common::{DelayBand, Quantity};

use super::offset::{Offset, mean};

/// Lengths and time constants are sought from this share of the shortest period …
const SHORTEST: f64 = 0.02;
/// … to this one, where the response in the shortest band has gone through zero; each is so many times the
/// one before.
const LONGEST: f64 = 1.4;
const RATIO: f64 = 1.01;
/// By how much Schwarz' criterion must be smaller than that of the other forms: very strong evidence (Kass
/// and Raftery, J. Am. Stat. Assoc. 90 (1995) 773).
const VERY_STRONG: f64 = 10.0;
/// Fewer bands have no form.
const LEAST: usize = 4;

/// A band with what noise of the reference may lower its response by, at most.
pub struct Band {
    /// The band.
    pub told: DelayBand,
    /// That share.
    pub lowered: f64,
    /// Root of the mean square of its frequencies, by how much each tells, Hz: at long periods a response
    /// falls by the square.
    pub frequency_hz: f64,
}

/// Length of the mean that one instrument's readings are beside the other's, s: the test instrument's where
/// it is positive, the reference's where it is negative. None where another form, or none, says as much.
pub fn length(bands: &[Band]) -> Option<Quantity> {
    if bands.len() < LEAST {
        return None;
    }
    let shortest = bands.iter().map(|band| band.told.shortest_s).fold(f64::INFINITY, f64::min);
    let parameter = (2.0 * bands.len() as f64).ln();
    let none = misfit(bands, &|_| 1.0, &|_| 0.0);
    let low_pass = sought(shortest)
        .map(|tau| {
            let response = |f: f64| (1.0 + (TAU * f * tau).powi(2)).powf(-0.5 * tau.signum());
            misfit(bands, &response, &|f| (TAU * f * tau).atan() / (TAU * f))
        })
        .fold(f64::INFINITY, f64::min);
    let means: Vec<(f64, f64)> = sought(shortest)
        .map(|length| {
            let response = |f: f64| ((PI * f * length).sin() / (PI * f * length)).abs().powf(length.signum());
            (length, misfit(bands, &response, &|_| 0.0))
        })
        .collect();
    let (length, least) = *means.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    // The others' misfit in Schwarz' criterion: none has a parameter less.
    if least + VERY_STRONG > low_pass.min(none - parameter) {
        return None;
    }
    let near = means.iter().filter(|of| of.1 <= least + 1.0);
    let (low, high) = near.fold((length, length), |(low, high), of| (low.min(of.0), high.max(of.0)));
    Some(Quantity::new(length, (0.5 * (high - low)).max((RATIO - 1.0) * length.abs())))
}

/// Sizes of both signs.
fn sought(shortest_s: f64) -> impl Iterator<Item = f64> {
    let count = ((LONGEST / SHORTEST).ln() / RATIO.ln()).ceil() as i32;
    (0..=count).flat_map(move |k| [-1.0, 1.0].map(|sign| sign * SHORTEST * shortest_s * RATIO.powi(k)))
}

/// χ² of responses and delays about a form, the response and the delay at long periods being free.
fn misfit(bands: &[Band], response: &dyn Fn(f64) -> f64, delay: &dyn Fn(f64) -> f64) -> f64 {
    let (mut products, mut squares) = (0.0, 0.0);
    let mut gains = Vec::new();
    let mut delays = Vec::new();
    for band in bands {
        let std = |of: &Quantity| of.std().unwrap_or(f64::INFINITY);
        let form = response(band.frequency_hz);
        let weight = std(&band.told.gain).hypot(band.lowered).powi(-2);
        products += weight * form * band.told.gain.value();
        squares += weight * form * form;
        gains.push((band.told.gain.value(), form, weight));
        delays.push(Offset {
            s: band.told.delay_s.value() - delay(band.frequency_hz),
            std: std(&band.told.delay_s),
        });
    }
    let scale = products / squares;
    let of_gains: f64 = gains.iter().map(|(gain, form, weight)| weight * (gain - scale * form).powi(2)).sum();
    let middle = mean(&delays).map_or(f64::NAN, |of| of.s);
    of_gains + delays.iter().map(|of| ((of.s - middle) / of.std).powi(2)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use noise::Stream;

    /// Bands of a pair with these forms and errors of 1 %.
    fn bands(seed: u64, response: impl Fn(f64) -> f64, delay: impl Fn(f64) -> f64) -> Vec<Band> {
        let mut stream = Stream::new(seed, "bands");
        (0..8)
            .map(|k| {
                let shortest_s = 2.0 * f64::from(1 << k);
                let f = (2.0_f64.sqrt() * shortest_s).recip();
                let gain = 0.98 * response(f) + 0.01 * stream.normal();
                let delay = 0.3 + delay(f) + 0.01 * stream.normal();
                let told = DelayBand {
                    shortest_s,
                    longest_s: 2.0 * shortest_s,
                    delay_s: Quantity::new(delay, 0.01),
                    gain: Quantity::new(gain, 0.01),
                };
                Band { told, lowered: 0.005, frequency_hz: f }
            })
            .collect()
    }

    #[test]
    fn a_mean_is_told_from_a_low_pass_filter_and_from_none() {
        let (mut told, mut within) = (0, 0);
        for seed in 0..100 {
            assert_eq!(length(&bands(seed, |_| 1.0, |_| 0.0)), None, "none, {seed}");
            let slow = |f: f64| 1.0 / (1.0 + (TAU * f * 0.5).powi(2)).sqrt();
            assert_eq!(length(&bands(seed, slow, |f| (TAU * f * 0.5).atan() / (TAU * f))), None, "{seed}");
            for truth in [1.5_f64, -1.5] {
                let response = |f: f64| ((PI * f * truth).sin() / (PI * f * truth)).powf(truth.signum());
                let Some(found) = length(&bands(seed, response, |_| 0.0)) else { continue };
                told += 1;
                within += u32::from((found.value() - truth).abs() < 0.1 * truth.abs());
            }
        }
        assert!(told == 200 && within == told, "{told} told, {within} of the right length");
    }
}
