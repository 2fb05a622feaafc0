//! Noise of single instruments, from what they leave against one another.

use common::{Axis, Column, OwnNoise, PerAxis, Quantity, ThreeCornered};
use estimate::cross_spectrum::CrossSpectra;
use estimate::sources::{self, Mixture, Source};
use estimate::stats;
use estimate::whittle::Estimate;
use joined::Pair;
use physics::frames;

use super::correct::{KnownDensity, by_third};
use super::frame::{Frame, invert};
use crate::{Error, regression};

/// Widest bin of the spectra, as a share of its frequency.
const WIDEST: f64 = 0.05;
const PROBABILITY: f64 = 0.95;

/// Noise of the test instrument along its axes, that of the reference taken off: v has the spectrum P_e + η⁻ᵀ
/// P_T η⁻¹.
pub fn of_test(frame: &Frame, step_s: f64, known: &KnownDensity) -> Result<PerAxis<OwnNoise>, Error> {
    let inverse = invert(&frame.eta)?;
    let rest: Vec<&[f64]> = frame.rest.iter().map(Vec::as_slice).collect();
    let spectra = CrossSpectra::of_whole(&rest, step_s, WIDEST)?;
    // The frame has narrower bins: the nearest in frequency.
    let nearest = |frequency: f64| {
        let after = frame.spectra.frequency_hz.partition_point(|f| *f < frequency);
        after.min(frame.spectra.frequency_hz.len() - 1)
    };
    let at: Vec<usize> = spectra.frequency_hz.iter().map(|frequency| nearest(*frequency)).collect();
    let unit = |i: usize| (0..3).map(|k| if k == i { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
    let told = |i: usize| at.iter().map(|bin| known.density[i][*bin]).collect::<Vec<f64>>();
    let group = |axes: &[usize]| sources::KnownNoise {
        columns: axes.iter().map(|i| unit(*i)).collect(),
        densities: axes.iter().map(|i| told(*i)).collect(),
        relative_std: known.relative_std[axes[0]],
    };
    let groups: &[&[usize]] = if known.together { &[&[0, 1, 2]] } else { &[&[0], &[1], &[2]] };
    let mixture = Mixture {
        spectra: &spectra,
        step_s,
        columns: (0..3).map(|j| (0..3).map(|i| inverse[(j, i)]).collect()).collect(),
        known: groups.iter().map(|axes| group(axes)).collect(),
    };
    Ok(of_axes(&sources::fit(&mixture)?.sources))
}

/// Splits the differences T η⁻¹ − R and C ζ⁻¹ − R into the noise of three instruments, `frame` with η as the
/// third instrument corrects it. ζ is found in the same way with the test instrument as the third.
pub fn split(pair: &Pair, third: &[Column; 3], frame: &Frame) -> Result<ThreeCornered, Error> {
    let turned = Pair { test: third.to_vec(), third: pair.test.clone().try_into().ok(), ..pair.clone() };
    let fits = regression::fit(&turned, &[])?;
    let turned = regression::without_exponentials(&turned, &fits);
    let other = by_third(&turned, &Frame::start(&turned, &fits)?)?.frame;
    let inverses = [invert(&frame.eta)?, invert(&other.eta)?];
    let mut columns = vec![vec![0.0; 6]; 9];
    for i in 0..3 {
        for (place, inverse) in inverses.iter().enumerate() {
            columns[i][3 * place + i] = -1.0;
            (0..3).for_each(|j| columns[3 + 3 * place + j][3 * place + i] = inverse[(j, i)]);
        }
    }
    let rest: Vec<&[f64]> = frame.rest.iter().chain(&other.rest).map(Vec::as_slice).collect();
    let spectra = CrossSpectra::of_whole(&rest, pair.step_s, WIDEST)?;
    let mixture = Mixture { spectra: &spectra, step_s: pair.step_s, columns, known: Vec::new() };
    let found = sources::fit(&mixture)?;
    Ok(ThreeCornered {
        reference: of_axes(&found.sources[..3]),
        test: of_axes(&found.sources[3..6]),
        third: of_axes(&found.sources[6..]),
        third_matrix: frames::rows(&other.eta),
        goodness_p: found.goodness,
    })
}

fn of_axes(sources: &[Source]) -> PerAxis<OwnNoise> {
    Axis::ALL.into_iter().zip(sources.iter().map(own)).collect()
}

fn own(source: &Source) -> OwnNoise {
    let quantity = |of: Estimate| Quantity::new(of.value, of.std);
    let [wide, bound] =
        [PROBABILITY, 2.0 * PROBABILITY - 1.0].map(|p| stats::coverage_factor(p, f64::INFINITY));
    // Of what is not seen, the bound leaves out as much as an interval does above; it is one of a variance.
    let unseen = |of: Estimate| [0.0, bound * of.std * (wide / bound).sqrt()];
    // White noise is what a variance leaves when others are taken off: its error is that of the difference.
    let of_variance = |of: Estimate| {
        let half = wide * 2.0 * of.value * of.std;
        let square = of.value * of.value;
        [(square - half).max(0.0).sqrt(), (square + half).sqrt()]
    };
    let of_white = |of: Estimate| if of.value > 0.0 { of_variance(of) } else { unseen(of) };
    let of_flicker =
        |of: Estimate| if of.value > 0.0 { of.log_interval(PROBABILITY).into() } else { unseen(of) };
    let (white, density) = (source.white_rms, source.amplitude.root());
    OwnNoise {
        white_rms_nt: quantity(white),
        white_interval_nt: of_white(white),
        density_at_1hz_nt_per_sqrt_hz: quantity(density),
        density_interval_nt_per_sqrt_hz: of_flicker(density),
        flicker_exponent: quantity(source.exponent),
    }
}
