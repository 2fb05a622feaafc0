//! How a delay depends on the period.

use std::f64::consts::TAU;

use common::{DelayBand, DelayBands, DelayForm, Quantity};
use estimate::stats::chi_squared_p;

use super::average::{self, Band};
use super::offset::{Offset, mean, scatter};
use crate::TOLD_BELOW;

/// Time constants are sought from this share of a step …
const SHORTEST: f64 = 0.01;
/// … to this share of the longest period, each so many times the one before.
const LONGEST: f64 = 0.5;
const RATIO: f64 = 1.01;

/// Bands with what their delays say; `shift_s` is what the readings were moved by before.
pub fn told(bands: Vec<Band>, shift_s: f64, step_s: f64) -> DelayBands {
    let average_s = average::length(&bands);
    let mut bands: Vec<DelayBand> = bands.into_iter().map(|band| band.told).collect();
    let frequencies: Vec<f64> =
        bands.iter().map(|band| (band.shortest_s * band.longest_s).sqrt().recip()).collect();
    for band in &mut bands {
        band.delay_s =
            Quantity::new(band.delay_s.value() + shift_s, band.delay_s.std().unwrap_or(f64::INFINITY));
    }
    let delays: Vec<Offset> = bands
        .iter()
        .map(|band| Offset { s: band.delay_s.value(), std: band.delay_s.std().unwrap_or(f64::INFINITY) })
        .collect();
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
    let Some(fit) = low_pass(&delays, &frequencies, [SHORTEST * step_s, LONGEST * longest]) else {
        return told;
    };
    if chi_squared_p(fit.chi_squared, (delays.len() as f64 - 2.0).max(1.0)) >= TOLD_BELOW && delays.len() > 2
    {
        told.form = DelayForm::LowPass;
        told.time_constant_s = Some(Quantity::new(fit.tau, fit.tau_std));
        told.beside_filter_s = Some(Quantity::new(fit.beside.s, fit.beside.std));
    }
    told
}

struct LowPass {
    tau: f64,
    tau_std: f64,
    beside: Offset,
    chi_squared: f64,
}

/// δ(f) = δ₀ + atan(2πfτ)/(2πf) by least squares; τ below zero is a filter of the reference. The uncertainty
/// of τ is where χ² is one more.
fn low_pass(delays: &[Offset], frequencies: &[f64], [from, to]: [f64; 2]) -> Option<LowPass> {
    let at = |tau: f64| -> Option<(f64, Offset)> {
        let own = |f: &f64| (TAU * f * tau).atan() / (TAU * f);
        let rest: Vec<Offset> =
            delays.iter().zip(frequencies).map(|(of, f)| Offset { s: of.s - own(f), std: of.std }).collect();
        let beside = mean(&rest)?;
        Some((rest.iter().map(|of| ((of.s - beside.s) / of.std).powi(2)).sum(), beside))
    };
    let count = ((to / from).ln() / RATIO.ln()).ceil().max(0.0) as i32;
    let sizes = || (0..=count).map(|k| from * RATIO.powi(k));
    let taus: Vec<f64> =
        sizes().map(|tau| -tau).collect::<Vec<f64>>().into_iter().rev().chain(sizes()).collect();
    let all: Vec<(f64, f64, Offset)> = taus
        .into_iter()
        .filter_map(|tau| at(tau).map(|(chi_squared, beside)| (tau, chi_squared, beside)))
        .collect();
    let (tau, chi_squared, beside) = *all.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let near = |of: &&(f64, f64, Offset)| of.1 <= chi_squared + 1.0;
    let (low, high) =
        all.iter().filter(near).fold((tau, tau), |(low, high), of| (low.min(of.0), high.max(of.0)));
    let tau_std = (0.5 * (high - low)).max((RATIO - 1.0) * tau.abs());
    Some(LowPass { tau, tau_std, beside, chi_squared })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bands(delay: impl Fn(f64) -> f64, std: f64) -> Vec<Band> {
        (0..8)
            .map(|k| {
                let shortest_s = 2.0 * f64::from(1 << k);
                let f = (2.0_f64.sqrt() * shortest_s).recip();
                let told = DelayBand {
                    shortest_s,
                    longest_s: 2.0 * shortest_s,
                    delay_s: Quantity::new(delay(f), std),
                    gain: Quantity::new(1.0, 0.1),
                };
                Band { told, lowered: 0.0, frequency_hz: f }
            })
            .collect()
    }

    #[test]
    fn a_filter_is_told_with_its_time_constant() {
        let of = |tau: f64| move |f: f64| 0.2 + (TAU * f * tau).atan() / (TAU * f);
        for tau in [0.8, -2.5] {
            let told = told(bands(of(tau), 0.002), 0.0, 1.0);
            assert_eq!(told.form, DelayForm::LowPass);
            let found = told.time_constant_s.expect("a time constant");
            assert!((found.value() - tau).abs() < 0.03 * tau.abs(), "{tau}: {found:?}");
            assert!((told.beside_filter_s.expect("the rest").value() - 0.2).abs() < 0.02);
        }
        assert_eq!(told(bands(|_| 0.2, 0.002), 0.1, 1.0).form, DelayForm::Constant);
        let bump = |f: f64| if (0.02..0.05).contains(&f) { 0.4 } else { 0.2 };
        assert_eq!(told(bands(bump, 0.002), 0.0, 1.0).form, DelayForm::Other);
    }
}
