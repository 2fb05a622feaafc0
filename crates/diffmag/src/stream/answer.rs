use estimate::positive::Positive;
use estimate::stats;
use faer::Mat;
use serde::Serialize;

use super::check;
use super::fit::FittedNoise;
use super::grid::Grid;
use super::noise::Problem;
use super::octaves::{COLUMNS, Differences, Octave, OctaveFit, UNKNOWNS};
use super::partial::Partial;
use super::pyramid::Pyramid;
use super::slow::Slow;
use crate::Error;

/// Fewer samples than these do not tell noise from drift.
const LEAST: u64 = 128;
/// The standard normal distribution is below these with 95 % and 99 %.
const ONE_SIDED_95: f64 = 1.644_854;
const ONE_SIDED_99: f64 = 2.326_348;
const DAY_S: f64 = 86_400.0;

/// A value with its standard uncertainty and the degrees of freedom which that has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard uncertainty.
    pub std: f64,
    /// Degrees of freedom of the standard uncertainty, for Student's t.
    pub freedom: f64,
}

/// White noise and A f^-α.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseFit {
    /// White noise of one reading, nT; 0 where it is not significant (1 %), with the one-sided 95 % bound
    /// over 1.645 beside it.
    pub white_rms_nt: Estimate,
    /// A of A f^-α, nT²/Hz at 1 Hz; 0 where flicker is not significant (1 %).
    pub flicker_nt2_per_hz_at_1hz: Estimate,
    /// Standard uncertainty of ln A.
    pub flicker_log_std: f64,
    /// α.
    pub flicker_exponent: Estimate,
}

/// One axis of the test instrument: T = R η + d.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisFit {
    /// η from the reference's x, y, z by least squares, with the source's uncertainty: errors taken as
    /// independent, N − 4 degrees of freedom.
    pub least_squares: [Estimate; 3],
    /// The standard uncertainty of the same under the fitted noise.
    pub least_squares_std_noise: [f64; 3],
    /// η by generalised least squares under the fitted noise, a straight drift beside it.
    pub weighted: [Estimate; 3],
    /// Its covariance.
    pub weighted_covariance: [[f64; 3]; 3],
    /// Mean of d with η as weighted, at the field 0 and in the middle of the samples, nT. The noise's own
    /// mean counts as far as it is faster than one over the length.
    pub offset_nt: Estimate,
    /// Straight drift of d under the fitted noise, nT a day.
    pub drift_nt_per_day: Estimate,
    /// Rms of d about its mean, η by least squares, N − 4 degrees of freedom, nT.
    pub rms_nt: f64,
    /// 95 % interval of its standard deviation by χ² with N − 4 degrees of freedom, as the source has it, nT.
    pub rms_interval_independent_nt: [f64; 2],
    /// Noise of d.
    pub noise: NoiseFit,
    /// By octave, from single samples on.
    pub octaves: Vec<Octave>,
}

/// How two magnetometers agree over all that was taken.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StreamFit {
    /// Where the samples stand.
    pub grid: Grid,
    /// Whole samples.
    pub samples: u64,
    /// Rows that lack a reading.
    pub missing: u64,
    /// Places without a row.
    pub absent: u64,
    /// Runs of such places.
    pub gaps: u64,
    /// Times of the first and the last place, s.
    pub span_s: [f64; 2],
    /// The test's x, y, z.
    pub axes: [AxisFit; 3],
}

/// What the sums say.
///
/// Least squares comes from the triangular factor. For the rest the differences of an octave weigh as if they
/// were independent of one another and of other octaves, with the variance of white noise and a power law
/// there ([`estimate::haar`]); what is slower than the profile's blocks has its full covariance, and says the
/// drift. Noise, η and drift have the greatest restricted likelihood together, for each axis. Uncertainties
/// count that the differences do covary: noise and field along, the covariances of both following from their
/// variances by octave. Left out, they would make the uncertainty of η under flicker noise a fifth too small.
///
/// Sources: G. W. Wornell, A. V. Oppenheim, Estimation of fractal signals from noisy measurements using
/// wavelets, IEEE Trans. Signal Process. 40 (1992) 611–623; H. D. Patterson, R. Thompson, Recovery of
/// inter-block information when block sizes are unequal, Biometrika 58 (1971) 545–554.
///
/// [`Error::Unanswerable`] for fewer than 128 samples, [`Error::Fit`] where the reference's axes do not
/// vary or depend on each other.
pub fn answer(partial: &Partial) -> Result<StreamFit, Error> {
    let span = partial.grid.zip(partial.span_s()).filter(|_| partial.samples >= LEAST);
    let (grid, span_s) = span.ok_or_else(|| {
        let found = partial.samples;
        Error::Unanswerable(format!("{found} whole samples; a series of statistics needs at least {LEAST}"))
    })?;
    let partial = &partial.closed();
    check::columns(&partial.factor)?;
    let plain = partial.factor.regress(&check::REFERENCE, &check::TEST)?;
    let profile = partial.whole_profile();
    let slow = Slow::of(&profile);
    let axis = |axis: usize| -> Result<AxisFit, Error> {
        // Rounded, so that the last digits of the factor do not reach the noise.
        let provisional = std::array::from_fn(|i| f64::from(plain.coefficients[axis][i] as f32));
        let steps = Mat::from_fn(slow.steps.nrows(), COLUMNS, |i, j| match j {
            0..3 => slow.steps[(i, j + 1)],
            3 => slow.steps[(i, 0)],
            _ => {
                let explained: f64 = (0..3).map(|k| provisional[k] * slow.steps[(i, k + 1)]).sum();
                slow.steps[(i, axis + 4)] - explained
            }
        });
        let levels = partial.pyramid.levels.iter().enumerate();
        let differences = |drift: f64| -> Vec<Differences> {
            let of = |(number, level)| Differences::of(number, level, axis, provisional, drift);
            levels.clone().map(of).collect()
        };
        let inside = partial.pyramid.levels.len().min(usize::from(profile.level));
        let first = differences(0.0);
        let first = Problem { octaves: &first[..inside], slow: &slow, steps: steps.clone() }.fit()?;
        let all = differences(first.solution.coefficients[3]);
        let problem = Problem { octaves: &all[..inside], slow: &slow, steps };
        let found = problem.fit()?;
        let (gram, noisy) = problem.sandwich(&found.solution, &found.noise);
        let inverse = Positive::of(&gram)?.inverse;
        let sandwich = &inverse * &noisy * &inverse;
        let variance = plain.squares[axis] / plain.freedom;
        let covariance = &found.coefficients;
        let coefficient = |i: usize, known: f64| Estimate {
            value: known + found.solution.coefficients[i],
            std: covariance[(i, i)].sqrt(),
            freedom: found.freedom[i],
        };
        let weighted: [Estimate; 3] = std::array::from_fn(|i| coefficient(i, provisional[i]));
        let per_day = DAY_S / grid.step_s;
        let drift = coefficient(3, 0.0);
        let bound = |p: f64| (plain.squares[axis] / stats::chi_squared_quantile(p, plain.freedom)).sqrt();
        Ok(AxisFit {
            least_squares: std::array::from_fn(|i| Estimate {
                value: plain.coefficients[axis][i],
                std: (variance * plain.inverse[(i, i)]).sqrt(),
                freedom: plain.freedom,
            }),
            least_squares_std_noise: std::array::from_fn(|i| sandwich[(i, i)].sqrt()),
            weighted,
            weighted_covariance: std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)])),
            offset_nt: offset(partial, axis, &weighted, &found),
            drift_nt_per_day: Estimate { value: drift.value * per_day, std: drift.std * per_day, ..drift },
            rms_nt: variance.sqrt(),
            rms_interval_independent_nt: [bound(0.975), bound(0.025)],
            octaves: octaves((&partial.pyramid, grid.step_s), &all, axis, provisional, &found),
            noise: noise_of(&found, grid.step_s),
        })
    };
    Ok(StreamFit {
        grid,
        samples: partial.samples,
        missing: partial.missing,
        absent: partial.absent,
        gaps: partial.gaps,
        span_s,
        axes: [axis(0)?, axis(1)?, axis(2)?],
    })
}

/// Constant of T = c + R η + drift in the middle of the samples.
fn offset(partial: &Partial, axis: usize, weighted: &[Estimate; 3], found: &FittedNoise) -> Estimate {
    let means: [f64; 3] = std::array::from_fn(|i| partial.factor.mean(i + 1));
    let explained: f64 = (0..3).map(|i| weighted[i].value * means[i]).sum();
    let covariance = &found.coefficients;
    let of_eta: f64 = (0..3)
        .flat_map(|i| (0..3).map(move |j| (i, j)))
        .map(|(i, j)| means[i] * means[j] * covariance[(i, j)])
        .sum();
    let (noise, count) = (&found.noise, partial.samples as f64);
    // A f^-α at one over the length, times one over the length.
    let slow = noise.amplitude * count.powf(noise.exponent - 1.0);
    Estimate {
        value: partial.factor.mean(axis + 4) - explained,
        std: (of_eta + noise.white / count + slow).sqrt(),
        freedom: found.freedom[0],
    }
}

fn noise_of(found: &FittedNoise, step_s: f64) -> NoiseFit {
    let (noise, covariance) = (&found.noise, &found.covariance);
    let estimate = |value: f64, std: f64| Estimate { value, std, freedom: f64::INFINITY };
    let flicker_nt2 = noise.amplitude * step_s.powf(1.0 - noise.exponent);
    let log = step_s.ln();
    let variance = covariance[(0, 0)] - 2.0 * log * covariance[(0, 1)] + log * log * covariance[(1, 1)];
    let flicker_log_std = variance.max(0.0).sqrt();
    let rms = noise.white.sqrt();
    let white_rms_nt = if found.white_log_std * ONE_SIDED_99 < 1.0 {
        estimate(rms, 0.5 * rms * found.white_log_std)
    } else {
        let bound = noise.white * (1.0 + ONE_SIDED_95 * found.white_log_std);
        estimate(0.0, bound.sqrt() / ONE_SIDED_95)
    };
    NoiseFit {
        white_rms_nt,
        flicker_nt2_per_hz_at_1hz: estimate(flicker_nt2, flicker_nt2 * flicker_log_std),
        flicker_log_std,
        flicker_exponent: estimate(noise.exponent, covariance[(1, 1)].sqrt()),
    }
}

fn octaves(
    (pyramid, step_s): (&Pyramid, f64),
    all: &[Differences],
    axis: usize,
    provisional: [f64; 3],
    found: &FittedNoise,
) -> Vec<Octave> {
    let variances = found.noise.variances(all.len());
    let one = |number: usize| {
        let (differences, level) = (&all[number], &pyramid.levels[number]);
        let taken: f64 = (0..UNKNOWNS)
            .flat_map(|i| (0..UNKNOWNS).map(move |j| (i, j)))
            .map(|(i, j)| found.solution.covariance[(i, j)] * differences.products[j][i])
            .sum();
        let coefficients = &found.solution.coefficients;
        let fit = OctaveFit { coefficients, provisional, axis, taken: taken / variances[number] };
        Octave::of(differences, level, step_s, &fit)
    };
    (0..all.len()).filter(|number| all[*number].count > 0.0).map(one).collect()
}
