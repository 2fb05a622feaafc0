//! How a delay depends on the period.
//!
//! The delay of a running mean is the same at all periods, and seems a clock's; its response, sin(πfT)/(πfT), is
//! its alone. Response and delay by bands are held against three forms: none, g and δ for all; a low-pass filter
//! of first order; a mean over T. Noise of the reference lowers the response too, at most by the share of what
//! is left in a band in the field there; an uncertainty as large as that stands beside each response.

use std::f64::consts::{PI, TAU};

use common::{DelayBand, DelayBands, DelayForm, Quantity};
use estimate::stats::chi_squared_p;

use super::offset::{Offset, mean, scatter};
use crate::{TOLD_BELOW, std};

/// Lengths and time constants are sought from these shares of the shortest period, …
const MEANS: [f64; 2] = [0.02, 1.4];
/// … and time constants alone from this share of a step to this one of the longest period; each is so many times
/// the one before.
const LOW_PASS: [f64; 2] = [0.01, 0.5];
const RATIO: f64 = 1.01;
/// By how much Schwarz' criterion must be smaller than that of the other forms: very strong evidence (Kass
/// and Raftery, J. Am. Stat. Assoc. 90 (1995) 773).
const VERY_STRONG: f64 = 10.0;
/// Fewer bands have no form of the response.
const LEAST: usize = 4;

/// A band with what noise of the reference may lower its response by, at most.
pub struct Band {
    pub told: DelayBand,
    /// That share.
    pub lowered: f64,
    /// Root of the mean square of its frequencies, by how much each tells, Hz: at long periods a response
    /// falls by the square.
    pub frequency_hz: f64,
}

/// Bands with what their delays say; `shift_s` is what the readings were moved by before.
pub fn told(bands: Vec<Band>, shift_s: f64, step_s: f64) -> DelayBands {
    let average_s = length(&bands);
    let mut bands: Vec<DelayBand> = bands.into_iter().map(|band| band.told).collect();
    let frequencies: Vec<f64> =
        bands.iter().map(|band| (band.shortest_s * band.longest_s).sqrt().recip()).collect();
    for band in &mut bands {
        band.delay_s = Quantity::new(band.delay_s.value() + shift_s, std(&band.delay_s));
    }
    let delays: Vec<Offset> =
        bands.iter().map(|band| Offset { s: band.delay_s.value(), std: std(&band.delay_s) }).collect();
    let scatter = scatter(&delays).unwrap_or_default();
    let mut told = DelayBands { bands, scatter, average_s, ..DelayBands::default() };
    if told.average_s.is_some() {
        told.form = DelayForm::Average;
        return told;
    }
    if told.scatter.p >= TOLD_BELOW {
        return told;
    }
    told.form = DelayForm::Other;
    let longest = told.bands.iter().map(|band| band.longest_s).fold(0.0, f64::max);
    let freedom = (delays.len() as f64 - 2.0).max(1.0);
    let filter = low_pass(&delays, &frequencies, [LOW_PASS[0] * step_s, LOW_PASS[1] * longest]);
    let agrees = |(chi_squared, ..): &(f64, Quantity, Offset)| {
        chi_squared_p(*chi_squared, freedom) >= TOLD_BELOW && delays.len() > 2
    };
    if let Some((_, time_constant_s, beside)) = filter.filter(agrees) {
        told.form = DelayForm::LowPass;
        told.time_constant_s = Some(time_constant_s);
        told.beside_filter_s = Some(Quantity::new(beside.s, beside.std));
    }
    told
}

/// δ(f) = δ₀ + atan(2πfτ)/(2πf) by least squares: χ², τ and δ₀; τ below zero is a filter of the reference.
fn low_pass(delays: &[Offset], frequencies: &[f64], range: [f64; 2]) -> Option<(f64, Quantity, Offset)> {
    let at = |tau: f64| -> Option<(f64, Offset)> {
        let own = |f: &f64| (TAU * f * tau).atan() / (TAU * f);
        let rest: Vec<Offset> =
            delays.iter().zip(frequencies).map(|(of, f)| Offset { s: of.s - own(f), std: of.std }).collect();
        let beside = mean(&rest)?;
        Some((rest.iter().map(|of| ((of.s - beside.s) / of.std).powi(2)).sum(), beside))
    };
    let all: Vec<(f64, f64)> = sought(range).filter_map(|tau| Some((tau, at(tau)?.0))).collect();
    let (tau, _) = best(&all)?;
    let (chi_squared, beside) = at(tau.value())?;
    Some((chi_squared, tau, beside))
}

/// Length of the mean that one instrument's readings are beside the other's, s: the test instrument's where
/// it is positive, the reference's where it is negative. None where another form, or none, says as much.
fn length(bands: &[Band]) -> Option<Quantity> {
    if bands.len() < LEAST {
        return None;
    }
    let shortest = bands.iter().map(|band| band.told.shortest_s).fold(f64::INFINITY, f64::min);
    let range = MEANS.map(|share| share * shortest);
    let parameter = (2.0 * bands.len() as f64).ln();
    let none = misfit(bands, &|_| 1.0, &|_| 0.0);
    let low_pass = |tau: f64| {
        let response = |f: f64| (1.0 + (TAU * f * tau).powi(2)).powf(-0.5 * tau.signum());
        misfit(bands, &response, &|f| (TAU * f * tau).atan() / (TAU * f))
    };
    let low_pass = sought(range).map(low_pass).fold(f64::INFINITY, f64::min);
    let average = |length: f64| {
        let response = |f: f64| ((PI * f * length).sin() / (PI * f * length)).abs().powf(length.signum());
        (length, misfit(bands, &response, &|_| 0.0))
    };
    let (length, least) = best(&sought(range).map(average).collect::<Vec<_>>())?;
    // The others' misfit in Schwarz' criterion: none has a parameter less.
    (least + VERY_STRONG <= low_pass.min(none - parameter)).then_some(length)
}

/// Sizes of both signs.
fn sought([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    let count = ((to / from).ln() / RATIO.ln()).ceil().max(0.0) as i32;
    (0..=count).flat_map(move |k| [-1.0, 1.0].map(|sign| sign * from * RATIO.powi(k)))
}

/// Of sizes with their χ² the best one and its χ²; its uncertainty is where χ² is one more.
fn best(all: &[(f64, f64)]) -> Option<(Quantity, f64)> {
    let (size, least) = *all.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let near = all.iter().filter(|of| of.1 <= least + 1.0);
    let (low, high) = near.fold((size, size), |(low, high), of| (low.min(of.0), high.max(of.0)));
    Some((Quantity::new(size, (0.5 * (high - low)).max((RATIO - 1.0) * size.abs())), least))
}

/// χ² of responses and delays about a form, the response and the delay at long periods being free.
fn misfit(bands: &[Band], response: &dyn Fn(f64) -> f64, delay: &dyn Fn(f64) -> f64) -> f64 {
    let (mut products, mut squares) = (0.0, 0.0);
    let (mut gains, mut delays) = (Vec::new(), Vec::new());
    for Band { told, lowered, frequency_hz } in bands {
        let form = response(*frequency_hz);
        let weight = std(&told.gain).hypot(*lowered).powi(-2);
        products += weight * form * told.gain.value();
        squares += weight * form * form;
        gains.push((told.gain.value(), form, weight));
        delays.push(Offset { s: told.delay_s.value() - delay(*frequency_hz), std: std(&told.delay_s) });
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

    /// Bands of a pair, each with its frequency, the response and the delay there, and standard uncertainties.
    fn bands(mut of: impl FnMut(f64) -> [f64; 2], [gain, delay]: [f64; 2]) -> Vec<Band> {
        let one = |k: i32| {
            let shortest_s = 2.0 * f64::from(1 << k);
            let frequency_hz = (2.0_f64.sqrt() * shortest_s).recip();
            let [response, late] = of(frequency_hz);
            let told = DelayBand {
                shortest_s,
                longest_s: 2.0 * shortest_s,
                delay_s: Quantity::new(late, delay),
                gain: Quantity::new(response, gain),
            };
            Band { told, lowered: 0.5 * delay, frequency_hz }
        };
        (0..8).map(one).collect()
    }

    fn late(tau: f64) -> impl Fn(f64) -> f64 {
        move |f| (TAU * f * tau).atan() / (TAU * f)
    }

    #[test]
    fn a_mean_is_told_from_a_low_pass_filter_and_from_none() {
        for seed in 0..100 {
            let mut stream = Stream::new(seed, "bands");
            let mut found = |response: &dyn Fn(f64) -> f64, delay: &dyn Fn(f64) -> f64| {
                let mut error = || 0.01 * stream.normal();
                let of = |f: f64| [0.98 * response(f) + error(), 0.3 + delay(f) + error()];
                length(&bands(of, [0.01; 2]))
            };
            assert_eq!(found(&|_| 1.0, &|_| 0.0), None, "none, {seed}");
            let slow = |f: f64| 1.0 / (1.0 + (TAU * f * 0.5).powi(2)).sqrt();
            assert_eq!(found(&slow, &late(0.5)), None, "{seed}");
            for truth in [1.5_f64, -1.5] {
                let response = |f: f64| ((PI * f * truth).sin() / (PI * f * truth)).powf(truth.signum());
                let told = found(&response, &|_| 0.0).expect("a length").value();
                assert!((told - truth).abs() < 0.1 * truth.abs(), "{seed}: {told} {truth}");
            }
        }
    }

    #[test]
    fn a_filter_is_told_with_its_time_constant() {
        let found = |delay: &dyn Fn(f64) -> f64| told(bands(|f| [1.0, delay(f)], [0.1, 0.002]), 0.0, 1.0);
        for tau in [0.8, -2.5] {
            let told = found(&|f| 0.2 + late(tau)(f));
            assert_eq!(told.form, DelayForm::LowPass);
            let found = told.time_constant_s.expect("a time constant");
            assert!((found.value() - tau).abs() < 0.03 * tau.abs(), "{tau}: {found:?}");
            assert!((told.beside_filter_s.expect("the rest").value() - 0.2).abs() < 0.02);
        }
        assert_eq!(found(&|_| 0.2).form, DelayForm::Constant);
        let bump = |f: f64| if (0.02..0.05).contains(&f) { 0.4 } else { 0.2 };
        assert_eq!(found(&bump).form, DelayForm::Other);
    }
}
