use common::{
    Axis, Calibration, DifferenceAxis, DifferentialCalibration, DifferentialFit, Document, Drift, DriftForm,
    FORMAT_VERSION, MatrixElement, Quantity,
};
use estimate::positive::Positive;
use estimate::stats;
use faer::Mat;

use super::check;
use super::fit::FittedNoise;
use super::noise::Problem;
use super::octaves::{agreement, differences, length};
use super::partial::Partial;
use super::slow::Slow;
use crate::calibration::{OfAxis, assembled};
use crate::drift::LEVEL;
use crate::octave::{COLUMNS, Octave, UNKNOWNS};
use crate::{Error, mutual};

/// Fewer samples than these do not tell noise from drift.
const LEAST: u64 = 128;
/// The standard normal distribution is below these with 95 % and 99 %.
const ONE_SIDED_95: f64 = 1.644_854;
const ONE_SIDED_99: f64 = 2.326_348;
const PROBABILITY: f64 = 0.95;

/// The document of a series of which only the statistics are left; fails as [`answer`] does.
pub fn document(partial: &Partial) -> Result<Document, Error> {
    let mut differential = answer(partial)?;
    differential.fourteen = mutual::parameters(&differential, None)?.map(Box::new);
    let calibration = Calibration { differential: Some(differential), ..Calibration::default() };
    Ok(Document { fluxcal: FORMAT_VERSION, calibration: Some(calibration), ..Document::default() })
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
pub fn answer(partial: &Partial) -> Result<DifferentialCalibration, Error> {
    let span = partial.grid.zip(partial.span_s()).filter(|_| partial.samples >= LEAST);
    let (grid, [from_s, to_s]) = span.ok_or_else(|| {
        let found = partial.samples;
        Error::Unanswerable(format!("{found} whole samples; a series of statistics needs at least {LEAST}"))
    })?;
    let partial = &partial.closed();
    check::columns(&partial.factor)?;
    let plain = partial.factor.regress(&check::REFERENCE, &check::TEST)?;
    let profile = partial.whole_profile();
    let slow = Slow::of(&profile);
    let mut fit = DifferentialFit {
        recordings: vec![format!("from {from_s} s to {to_s} s")],
        samples: partial.samples as usize,
        step_s: grid.step_s,
        missing: (partial.missing + partial.absent) as usize,
        ..DifferentialFit::default()
    };
    let mut one = |axis: usize| -> Result<OfAxis, Error> {
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
        let levels = &partial.pyramid.levels;
        let differences = |drift: f64| -> Vec<Octave> {
            levels.iter().map(|level| differences(level, axis, provisional, drift)).collect()
        };
        let inside = levels.len().min(usize::from(profile.level));
        let first = differences(0.0);
        let first = Problem { octaves: &first[..inside], slow: &slow, steps: steps.clone() }.fit()?;
        let all = differences(first.solution.coefficients[3]);
        let problem = Problem { octaves: &all[..inside], slow: &slow, steps };
        let found = problem.fit()?;
        let (gram, noisy) = problem.sandwich(&found.solution, &found.noise);
        let inverse = Positive::of(&gram)?.inverse;
        let sandwich = &inverse * &noisy * &inverse;
        let variance = plain.squares[axis] / plain.freedom;
        let (corrections, covariance) = (&found.solution.coefficients, &found.coefficients);
        let std = |i: usize| covariance[(i, i)].sqrt();
        let elements: [MatrixElement; 3] = std::array::from_fn(|i| MatrixElement {
            least_squares: plain.coefficients[axis][i],
            std_independent: (variance * plain.inverse[(i, i)]).sqrt(),
            std_newey_west: None,
            std_noise: sandwich[(i, i)].sqrt(),
            weighted: provisional[i] + corrections[i],
            weighted_std: std(i),
            degrees_of_freedom: Some(found.freedom[i]).filter(|freedom| freedom.is_finite()),
        });
        let mut covariances = [[[0.0; 3]; 3]; 3];
        covariances[axis] = std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)]));
        let bound = |p: f64| (plain.squares[axis] / stats::chi_squared_quantile(p, plain.freedom)).sqrt();
        let per_day = joined::DAY_S / grid.step_s;
        let slope = Quantity::new(corrections[3] * per_day, std(3) * per_day);
        let mut described = DifferenceAxis {
            rms_nt: variance.sqrt(),
            rms_interval_independent_nt: [bound(0.975), bound(0.025)],
            drift: drift(slope, found.freedom[3]),
            ..noise_of(&found, grid.step_s)
        };
        // Octaves of d less its drift, by blocks that do not overlap.
        let variances = found.noise.variances(all.len());
        let mut octaves = Vec::new();
        for (number, of) in all.iter().enumerate().filter(|(_, of)| of.count > 0.0) {
            let taken: f64 = (0..UNKNOWNS)
                .flat_map(|i| (0..UNKNOWNS).map(move |j| (i, j)))
                .map(|(i, j)| found.solution.covariance[(i, j)] * of.products[j][i])
                .sum();
            let freedom = (of.count - taken / variances[number]).max(0.5);
            let (low, high) = stats::variance_interval(freedom, PROBABILITY);
            let allan = of.squares(corrections) / (2.0 * of.count);
            let averaging_s = length(number) * grid.step_s;
            described.allan.push(0, averaging_s, allan.sqrt(), [(allan * low).sqrt(), (allan * high).sqrt()]);
            octaves.push(agreement(of, &levels[number], averaging_s, axis, provisional));
        }
        *fit.octaves.get_or_insert_default().entry(Axis::ALL[axis]) = Some(octaves);
        let offset_nt = offset(partial, axis, &elements, &found);
        Ok(OfAxis { elements, covariances, offset_nt, described })
    };
    let axes = [one(0)?, one(1)?, one(2)?];
    Ok(assembled(fit, axes))
}

/// Mean of T − R η in the middle of the samples, at the field 0. The noise's own mean counts as far as it is
/// faster than one over the length.
fn offset(partial: &Partial, axis: usize, eta: &[MatrixElement; 3], found: &FittedNoise) -> Quantity {
    let means: [f64; 3] = std::array::from_fn(|i| partial.factor.mean(i + 1));
    let explained: f64 = (0..3).map(|i| eta[i].weighted * means[i]).sum();
    let of_eta: f64 = (0..9).map(|k| means[k / 3] * means[k % 3] * found.coefficients[(k / 3, k % 3)]).sum();
    let (noise, count) = (&found.noise, partial.samples as f64);
    // A f^-α at one over the length, times one over the length.
    let slow = noise.amplitude * count.powf(noise.exponent - 1.0);
    let variance = of_eta + noise.white / count + slow;
    Quantity::new(partial.factor.mean(axis + 4) - explained, variance.sqrt())
}

/// White noise of one reading is 0 where it is not significant (1 %), with the one-sided 95 % bound over 1.645
/// beside it.
fn noise_of(found: &FittedNoise, step_s: f64) -> DifferenceAxis {
    let (noise, covariance) = (&found.noise, &found.covariance);
    let flicker_nt2 = noise.amplitude * step_s.powf(1.0 - noise.exponent);
    let log = step_s.ln();
    let variance = covariance[(0, 0)] - 2.0 * log * covariance[(0, 1)] + log * log * covariance[(1, 1)];
    let flicker_log_std = variance.max(0.0).sqrt();
    let rms = noise.white.sqrt();
    let white_rms_nt = if found.white_log_std * ONE_SIDED_99 < 1.0 {
        Quantity::new(rms, 0.5 * rms * found.white_log_std)
    } else {
        let bound = noise.white * (1.0 + ONE_SIDED_95 * found.white_log_std);
        Quantity::new(0.0, bound.sqrt() / ONE_SIDED_95)
    };
    let density = flicker_nt2.sqrt();
    DifferenceAxis {
        white_rms_nt,
        flicker_nt2_per_hz_at_1hz: Quantity::new(flicker_nt2, flicker_nt2 * flicker_log_std),
        flicker_exponent: Quantity::new(noise.exponent, covariance[(1, 1)].sqrt()),
        // √A has half the relative uncertainty of A.
        density_at_1hz_nt_per_sqrt_hz: Quantity::new(density, 0.5 * density * flicker_log_std),
        ..DifferenceAxis::default()
    }
}

/// A straight drift is the only one that the statistics show.
fn drift(straight_nt_per_day: Quantity, freedom: f64) -> Drift {
    let std = straight_nt_per_day.std().unwrap_or(f64::INFINITY);
    let straight_p = stats::two_sided_p(straight_nt_per_day.value() / std, freedom);
    let demanded = if straight_p < LEVEL { DriftForm::Straight } else { DriftForm::None };
    Drift { demanded, level: LEVEL, straight_nt_per_day, straight_p, exponential_p: 1.0, ..Drift::default() }
}
