//! The forms of noise that are weighed with the names.

use common::Noise;
use estimate::Error;
use noise::{Process, Whitening};
use std::f64::consts::PI;

/// Exponents of the part with memory, and by how many times it exceeds the white part at the frequency of
/// twenty steps.
const EXPONENTS: [f64; 3] = [1.0, 1.5, 2.0];
const RATIOS: [f64; 5] = [0.03, 0.3, 3.0, 30.0, 300.0];
/// That frequency, in cycles a step.
const AT: f64 = 0.05;
/// Corners below which noise is as large as at the longest periods, in radians a step, and by how many times it
/// exceeds the white part there: what noise of the reference leaves beside an answer to the smooth field.
const CORNERS: [f64; 3] = [0.25, 1.0 / 32.0, 1.0 / 256.0];
const PLATEAUS: [f64; 2] = [3.0, 30.0];
/// The longest period of noise with memory, in lengths of the recording.
const OLDEST: f64 = 2.0;
/// From one corner frequency of a fitted spectrum to the next, and the highest, in cycles a step.
const APART: f64 = 2.5;
const HIGHEST: f64 = 0.4;
/// Bins of frequency in each octave, rounds of the fit, and unknowns that it costs.
const BINS: f64 = 6.0;
const ROUNDS: usize = 300;
const UNKNOWNS: f64 = 6.0;
/// A process that is nowhere more than this share of a spectrum is left out.
const SHOWS: f64 = 1e-3;

/// Noise, up to its scale.
#[derive(Clone, Debug)]
pub enum Form {
    /// White noise and a power law.
    Law(Noise),
    /// White noise of one and a process.
    Plateau(Process),
    /// White noise (its variance) and processes whose sum has the spectrum of a residual.
    Fitted(f64, Vec<Process>),
}

impl Form {
    /// Its filter at some times.
    pub fn whitening(&self, time_s: &[f64]) -> Result<Whitening, Error> {
        let length = time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first);
        match self {
            Form::Law(noise) => Whitening::of(noise, Some(time_s), time_s.len(), OLDEST * length),
            Form::Plateau(process) => Whitening::of_processes(vec![*process], 1.0, time_s),
            Form::Fitted(white, processes) => Whitening::of_processes(processes.clone(), *white, time_s),
        }
        .map_err(|_| Error::Series("whose times are not in order, or that no noise is for"))
    }

    /// ln of its prior odds: what is fitted to the readings is paid for.
    pub fn prior(&self, rows: usize) -> f64 {
        match self {
            Form::Law(_) | Form::Plateau(_) => 0.0,
            Form::Fitted(..) => -0.5 * UNKNOWNS * (rows as f64).ln(),
        }
    }
}

/// Noise, and its filter at the rows of a problem.
#[derive(Clone, Debug)]
pub struct Filter {
    pub form: Form,
    pub whitening: Whitening,
}

impl Filter {
    /// Of some noises.
    pub fn all(forms: Vec<Form>, time_s: &[f64]) -> Result<Vec<Self>, Error> {
        let of = |form: Form| Ok(Self { whitening: form.whitening(time_s)?, form });
        forms.into_iter().map(of).collect()
    }
}

/// Density at 1 Hz (one-sided) of noise f^-α that exceeds white noise of variance one by a ratio at a period
/// of twenty steps.
pub fn power_law(step_s: f64, exponent: f64, ratio: f64) -> f64 {
    ratio * 2.0 * step_s * (AT / step_s).powf(exponent)
}

/// Laws for a white part of one: S(f) = 2 Δt (1 + r (0.05/(f Δt))^α), one-sided, and 2 Δt (1 + r/(1 + (2π f/λ)²)). An
/// exponent of two is a random walk, whose state needs no memory of the time before the first row: a level stands for
/// it. The first is white noise.
pub fn laws(step_s: f64) -> Vec<Form> {
    let white = Noise { white_rms_nt: Some(1.0), ..Noise::default() };
    let with = |exponent: f64, ratio: f64| {
        let amplitude = power_law(step_s, exponent, ratio);
        if exponent == 2.0 {
            // Density r²/(2π²f²).
            let walk = (2.0 * amplitude).sqrt() * PI;
            return Noise { random_walk_nt_per_sqrt_s: Some(walk), ..white.clone() };
        }
        Noise {
            flicker_nt2_per_hz_at_1hz: Some(amplitude),
            flicker_exponent: Some(exponent),
            ..white.clone()
        }
    };
    let red = EXPONENTS.iter().flat_map(|exponent| RATIOS.map(|ratio| with(*exponent, ratio)));
    // An Ornstein–Uhlenbeck process of variance v has 4 v/λ at the longest periods.
    let plateaus = CORNERS.iter().flat_map(|corner| {
        PLATEAUS.map(|ratio| Process { variance_nt2: 0.5 * ratio * corner, rate_per_s: corner / step_s })
    });
    let laws = [white.clone()].into_iter().chain(red).map(Form::Law);
    laws.chain(plateaus.map(Form::Plateau)).collect()
}

/// White noise and Ornstein–Uhlenbeck processes, a corner in each 1.3 octaves, of the greatest Whittle
/// likelihood for a residual at even steps: each weight times Σ I Sₖ/S² over Σ Sₖ/S, I the periodogram and S = Σ
/// wₖ Sₖ, until they stay.
///
/// Source: C. Févotte, N. Bertin and J.-L. Durrieu, Nonnegative matrix factorization with the Itakura–Saito
/// divergence, Neural Computation 21 (2009) 793–830, eq. 2.16.
pub fn fitted(residual: &[f64], step_s: f64) -> Option<Form> {
    let binned = binned(residual)?;
    let lowest = 0.25 / residual.len() as f64;
    let corners: Vec<f64> = std::iter::successors(Some(HIGHEST), |corner| Some(corner / APART))
        .take_while(|corner| *corner > lowest)
        .collect();
    let unit = |corner: &f64| Process { variance_nt2: 1.0, rate_per_s: 2.0 * PI * corner / step_s };
    let processes: Vec<Process> = corners.iter().map(unit).collect();
    // Two-sided densities for steps of one, the white part first.
    let shapes: Vec<Vec<f64>> = std::iter::once(vec![1.0; binned.len()])
        .chain(processes.iter().map(|process| {
            let density =
                |(f, ..): &(f64, f64, f64)| process.sampled_density(f / step_s, step_s) / (2.0 * step_s);
            binned.iter().map(density).collect()
        }))
        .collect();
    let power = binned.iter().map(|(_, power, count)| power * count).sum::<f64>();
    let mean = power / binned.iter().map(|(.., count)| count).sum::<f64>();
    let mut weights: Vec<f64> = shapes
        .iter()
        .map(|shape| mean / (shapes.len() as f64 * shape.iter().sum::<f64>() / shape.len() as f64))
        .collect();
    for _ in 0..ROUNDS {
        let sum: Vec<f64> = (0..binned.len())
            .map(|bin| weights.iter().zip(&shapes).map(|(weight, shape)| weight * shape[bin]).sum())
            .collect();
        for (weight, shape) in weights.iter_mut().zip(&shapes) {
            let (mut above, mut below) = (0.0, 0.0);
            for (bin, (_, power, count)) in binned.iter().enumerate() {
                above += count * power * shape[bin] / (sum[bin] * sum[bin]);
                below += count * shape[bin] / sum[bin];
            }
            *weight *= above / below;
        }
    }
    // Some white noise in any case: without it readings at one time would be known.
    let white = weights[0].max(1e-6 * mean);
    let sum =
        |bin: usize| -> f64 { weights.iter().zip(&shapes).map(|(weight, shape)| weight * shape[bin]).sum() };
    let shows =
        |part: usize| (0..binned.len()).any(|bin| weights[part] * shapes[part][bin] > SHOWS * sum(bin));
    let processes = (1..weights.len())
        .filter(|part| shows(*part))
        .map(|part| Process { variance_nt2: weights[part] / white, ..processes[part - 1] })
        .collect();
    white.is_finite().then_some(Form::Fitted(1.0, processes))
}

/// The filter of a residual's own spectrum; None where it is too short for one.
///
/// Errors: times out of order.
pub fn filter(time_s: &[f64], residual: &[f64], step_s: f64) -> Result<Option<Whitening>, Error> {
    fitted(residual, step_s).map(|form| form.whitening(time_s)).transpose()
}

/// The periodogram in bins of frequency (cycles a step): their frequency, mean, and how many are in them.
fn binned(residual: &[f64]) -> Option<Vec<(f64, f64, f64)>> {
    let n = residual.len();
    if n < 64 {
        return None;
    }
    // The ends are brought to one level: else a drift looks like noise at every frequency.
    let slope = (residual[n - 1] - residual[0]) / (n as f64 - 1.0);
    let level = residual.iter().enumerate().map(|(k, value)| value - slope * k as f64);
    let transform = fourier::forward(level.collect());
    let mut bins: Vec<(f64, f64, f64)> = Vec::new();
    let mut last = usize::MAX;
    for (k, value) in transform.iter().enumerate().skip(1) {
        let bin = ((k as f64).log2() * BINS) as usize;
        let (f, power) = (k as f64 / n as f64, value.norm_sqr() / n as f64);
        match bins.last_mut().filter(|_| bin == last) {
            Some((frequency, sum, count)) => {
                (*frequency, *sum, *count) = (*frequency + f, *sum + power, *count + 1.0);
            }
            None => bins.push((f, power, 1.0)),
        }
        last = bin;
    }
    let mean = |(f, power, count): (f64, f64, f64)| (f / count, power / count, count);
    let bins: Vec<(f64, f64, f64)> = bins.into_iter().map(mean).collect();
    bins.iter().all(|(_, power, _)| power.is_finite() && *power > 0.0).then_some(bins)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spectrum_with_a_corner_is_followed() {
        // A process with a corner at 0.01 cycles a step and white noise of a tenth of its variance.
        let mut stream = noise::Stream::new(5, "corner");
        let kept = (-2.0 * PI * 0.01f64).exp();
        let mut state = 0.0;
        let series: Vec<f64> = (0..20_000)
            .map(|_| {
                state = kept * state + (1.0 - kept * kept).sqrt() * stream.normal();
                state + 0.1f64.sqrt() * stream.normal()
            })
            .collect();
        let Some(Form::Fitted(white, processes)) = fitted(&series, 1.0) else { panic!("no spectrum") };
        let found = |f: f64| white + processes.iter().map(|p| p.sampled_density(f, 1.0) / 2.0).sum::<f64>();
        let corner = Process { variance_nt2: 1.0, rate_per_s: 2.0 * PI * 0.01 };
        let truth = |f: f64| 0.1 + corner.sampled_density(f, 1.0) / 2.0;
        // Its scale is free.
        for f in [0.001, 0.01, 0.03, 0.4] {
            let ratio = found(f) / found(0.1) / (truth(f) / truth(0.1));
            assert!((ratio - 1.0).abs() < 0.25, "{f}: {ratio}");
        }
    }
}
