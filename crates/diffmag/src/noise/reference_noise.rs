//! Noise of the reference: how far it pulls η toward zero, and η without that.
//!
//! Least squares takes the reference's readings for the field. With their noise P_e it finds (1 − M⁻¹N) η, M
//! = Σ S_RR/P_d and N = Σ P_e/P_d. A third instrument corrects it without any knowledge of noise; else the
//! declared noise does; else the spectra of the two, where these show it; and where nothing is known the pull
//! is bounded.

mod correct;
mod frame;
mod own;
mod words;

pub use words::lines;

use common::{
    Axis, DifferenceAxis, DifferentialCalibration, InSpectrum, PerAxis, PulledElement, Quantity,
    ReferenceNoise, ReferenceNoiseSource,
};
use estimate::stats::mean;
use physics::frames;

use crate::Error;
use crate::difference;
use crate::regression::{self, AxisFit};
use correct::{Corrected, KnownDensity, Spectrum, by_known, by_spectrum, by_third};
use frame::Frame;
use joined::Pair;
use paired::noise::Noise;
use paired::residual::scatter;

/// Noise of the reference is told, and bands that disagree are, below this probability.
const TOLD_BELOW: f64 = 0.01;
/// Shares of the power above one by so many of their uncertainties are none (1 %, one-sided).
const ABOVE_ONE: f64 = 2.326;

/// Looks for noise of the reference where it can be known from, and writes what is found; with the corrected matrix
/// in place of the pulled one, its covariance, and the offset and difference that belong to it. No matrix is
/// corrected by what leaves more of an axis than `levels_nt`, the rms of the readings with levels alone.
pub fn add(
    level: &Pair,
    fits: &[AxisFit; 3],
    levels_nt: [f64; 3],
    calibration: &mut DifferentialCalibration,
) -> Result<(), Error> {
    let pair = &regression::without_exponentials(level, fits);
    let start = Frame::start(pair, fits)?;
    let mut report = ReferenceNoise::default();
    let (mut three_cornered, mut found) = (None, None);
    if let Some(third) = &pair.third {
        let corrected = by_third(pair, &start)?;
        let split = own::split(pair, third, &corrected.frame)?;
        report.known_from = ReferenceNoiseSource::ThirdInstrument;
        report.test = Some(split.test.clone());
        (three_cornered, found) = (Some(split), Some(corrected));
    } else {
        // Where it does not settle the spectra say nothing.
        let spectrum = by_spectrum(pair, &start).unwrap_or(None);
        let declared = declared(pair, &start);
        let usable =
            |spectrum: &Spectrum| declared.is_none() && spectrum.corrected.leaves_less(levels_nt, pair);
        let in_spectrum = spectrum.as_ref().map(|spectrum| evidence(spectrum, usable(spectrum)));
        if let Some(declared) = &declared {
            report.known_from = ReferenceNoiseSource::Declared;
            found =
                by_known(pair, &start, declared)?.filter(|corrected| corrected.leaves_less(levels_nt, pair));
            let frame = found.as_ref().map_or(&start, |corrected| &corrected.frame);
            report.share = Some(shares(frame, declared));
            report.test = Some(own::of_test(frame, pair.step_s, declared)?);
        } else if let Some(spectrum) = spectrum.filter(|_| in_spectrum.as_ref().is_some_and(|s| s.used)) {
            report.known_from = ReferenceNoiseSource::Spectrum;
            report.share = in_spectrum.as_ref().map(|s| s.share.clone());
            let known = spectrum.known();
            report.test = Some(own::of_test(&spectrum.corrected.frame, pair.step_s, &known)?);
            found = Some(spectrum.corrected);
        }
        report.in_spectrum = in_spectrum;
    }
    let largest = largest_pull(pair, fits);
    for (j, to) in Axis::ALL.into_iter().enumerate() {
        for (i, from) in Axis::ALL.into_iter().enumerate() {
            let pulled = fits[j].fit.weighted[i];
            let pulled_std = fits[j].fit.weighted_covariance[(i, i)].sqrt();
            let corrected = found.as_ref().map(|corrected| {
                let variance = corrected.covariance[(3 * j + i, 3 * j + i)];
                Quantity::new(corrected.frame.eta[(i, j)], variance.sqrt())
            });
            let element = PulledElement {
                pulled,
                pulled_std,
                pull: corrected.as_ref().map(|corrected| pulled - corrected.value()),
                corrected,
                largest_pull: largest[i][j],
                largest_pull_over_std: largest[i][j] / pulled_std,
            };
            report.elements.insert(format!("{from}{to}"), element);
        }
    }
    report.ascribed = words::ascribed(&report, three_cornered.as_ref());
    report.findings = words::findings(&report, three_cornered.as_ref(), TOLD_BELOW);
    if let Some(corrected) = &found {
        adopt(level, corrected, report.known_from, calibration)?;
    }
    if let Some(fit) = &mut calibration.fit {
        (fit.three_cornered, fit.reference_noise) = (three_cornered, Some(report));
    }
    Ok(())
}

fn adopt(
    pair: &Pair,
    Corrected { frame, covariance }: &Corrected,
    known_from: ReferenceNoiseSource,
    calibration: &mut DifferentialCalibration,
) -> Result<(), Error> {
    let means = pair.reference.each_ref().map(|column| mean(column));
    let offsets = calibration.offset_nt.get_or_insert_default();
    for axis in Axis::ALL {
        let j = axis.index();
        let offset = mean(&pair.test[j]) - (0..3).map(|i| means[i] * frame.eta[(i, j)]).sum::<f64>();
        let term = |i: usize, k: usize| means[i] * covariance[(3 * j + i, 3 * j + k)] * means[k];
        let of_matrix: f64 = (0..9).map(|at| term(at / 3, at % 3)).sum();
        let of_noise = offsets.get(axis).and_then(Quantity::std).unwrap_or(0.0);
        *offsets.entry(axis) = Some(Quantity::new(offset, (of_noise.powi(2) + of_matrix).sqrt()));
    }
    calibration.matrix = Some(frames::rows(&frame.eta));
    calibration.covariance = Some(covariance.row_iter().map(|row| row.iter().copied().collect()).collect());
    let Some(fit) = &mut calibration.fit else { return Ok(()) };
    fit.quoted = words::quoted(known_from);
    // The pulled matrix left field in the difference.
    for axis in Axis::ALL {
        let Some(of) = fit.axes.entry(axis) else { continue };
        let left = frame.difference(axis.index());
        let described = difference::describe(&left, &left, &Noise::seen(&left, pair)?, pair.step_s)?;
        *of = DifferenceAxis {
            rms_of_readings_nt: of.rms_of_readings_nt,
            rms_of_levels_nt: of.rms_of_levels_nt,
            weighted_up_to_hz: of.weighted_up_to_hz,
            drift: of.drift.clone(),
            follows: std::mem::take(&mut of.follows),
            ..described
        };
    }
    Ok(())
}

/// The largest pull of each element, [reference][test], whichever part of the difference is the reference's.
///
/// With M of the weighted fit the pull of column j is M⁻¹ N η_j, N_kk = Σ P_e,k/P_d,j over the ordinates, and
/// the reference's axis k cannot have more noise than what it would leave in any difference, P_e,k ≤
/// P_d,l/η_kl². Each N_kk takes its largest value where it pulls one way and zero where it pulls the other.
fn largest_pull(pair: &Pair, fits: &[AxisFit; 3]) -> [[f64; 3]; 3] {
    let rows = pair.whole.len();
    let eta = |k: usize, l: usize| fits[l].fit.weighted[k];
    let mut most = [[0.0; 3]; 3];
    for order in 1..=rows / 2 {
        let frequency = order as f64 / (rows as f64 * pair.step_s);
        let twice = if 2 * order == rows { 1.0 } else { 2.0 };
        let level = fits.each_ref().map(|of| of.noise.level(frequency));
        let weighing = fits.each_ref().map(|of| of.noise.density(frequency));
        for (k, most) in most.iter_mut().enumerate() {
            let allowed = (0..3).map(|l| level[l] / eta(k, l).powi(2)).fold(f64::INFINITY, f64::min);
            most.iter_mut().zip(weighing).for_each(|(most, weighing)| *most += twice * allowed / weighing);
        }
    }
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let part = |k: usize| fits[j].fit.weighted_covariance[(i, k)] * most[k][j] * eta(k, j);
            let up: f64 = (0..3).map(|k| part(k).max(0.0)).sum();
            let down: f64 = (0..3).map(|k| (-part(k)).max(0.0)).sum();
            up.max(down)
        })
    })
}

fn declared(pair: &Pair, frame: &Frame) -> Option<KnownDensity> {
    let noise = pair.reference_noise.as_ref()?;
    let of = |axis: Axis| noise.of(axis).cloned().unwrap_or_default();
    let density = Axis::ALL.map(|axis| {
        let noise = of(axis);
        frame.spectra.frequency_hz.iter().map(|f| noise.density(*f, pair.step_s)).collect()
    });
    Some(KnownDensity {
        density,
        // A relative error of the noise is twice as great in its power.
        relative_std: Axis::ALL.map(|axis| 2.0 * of(axis).relative_std.unwrap_or(0.0)),
        together: matches!(noise, common::NoiseOfSensors::Same(_)),
    })
}

/// Share of the power of v that is the reference's.
fn shares(frame: &Frame, known: &KnownDensity) -> PerAxis<Quantity> {
    let power = |density: &[f64]| density.iter().zip(&frame.spectra.freedom).map(|(p, n)| p * n).sum::<f64>();
    let of = |axis: Axis| {
        let i = axis.index();
        let share = power(&known.density[i]) / power(&frame.density[i]);
        (axis, Quantity::new(share, share * known.relative_std[i]))
    };
    Axis::ALL.into_iter().map(of).collect()
}

impl Corrected {
    /// Whether it leaves no more of any axis than levels alone do.
    fn leaves_less(&self, levels_nt: [f64; 3], pair: &Pair) -> bool {
        let left = |axis: usize| scatter(&self.frame.difference(axis), &pair.whole);
        (0..3).all(|axis| left(axis) <= levels_nt[axis])
    }
}

/// What the spectra say, and whether it is used.
fn evidence(spectrum: &Spectrum, usable: bool) -> InSpectrum {
    let share = spectrum.share.map(|(value, std)| Quantity::new(value, std));
    let share = Axis::ALL.into_iter().zip(share).collect();
    let (p, consistency_p) = (spectrum.p(), spectrum.consistency_p());
    let possible = spectrum.share.iter().all(|(value, std)| value - ABOVE_ONE * std < 1.0);
    let used = usable && p < TOLD_BELOW && consistency_p > TOLD_BELOW && possible;
    InSpectrum { share, p, consistency_p, used }
}

impl Spectrum {
    /// The noise of the reference that it tells.
    fn known(&self) -> KnownDensity {
        let frame = &self.corrected.frame;
        let share = self.share.map(|(share, _)| share.clamp(0.0, 1.0));
        KnownDensity {
            density: std::array::from_fn(|i| frame.density[i].iter().map(|p| share[i] * p).collect()),
            relative_std: self.share.map(|(share, std)| if share > 0.0 { std / share } else { 0.0 }),
            together: false,
        }
    }
}
