//! The three corrections.

use estimate::stats;
use nalgebra::{Matrix4, SMatrix, SVector, Vector4};

use super::frame::{Frame, inverse4, settle};
use crate::Error;
use joined::Pair;

/// Ordinates of the lowest band of the spectrum; each further band has as many as all below it.
const BAND: f64 = 8.0;
/// Bands needed.
const LEAST_BANDS: usize = 3;

/// Noise of the reference along its axes.
#[derive(Clone)]
pub struct KnownDensity {
    /// Its density at the frequencies of the frame's spectra, nT²/Hz.
    pub density: [Vec<f64>; 3],
    /// Relative standard uncertainty of each density.
    pub relative_std: [f64; 3],
    /// Whether the three are wrong by the same factor, as one declaration for all.
    pub together: bool,
}

impl KnownDensity {
    /// Covariance of the relative errors of two of the densities.
    fn covariance(&self, i: usize, l: usize) -> f64 {
        if self.together || i == l { self.relative_std[i] * self.relative_std[l] } else { 0.0 }
    }
}

pub struct Corrected {
    pub frame: Frame,
    /// Its covariance, column by column.
    pub covariance: SMatrix<f64, 9, 9>,
}

/// What two instruments say about the noise of the reference.
pub struct Spectrum {
    /// Shares ρ of the power of v that are the reference's, and their standard uncertainties.
    pub share: [(f64, f64); 3],
    /// Σ of squares of what one matrix and one share leave in the bands, and its degrees of freedom.
    pub chi_squared: (f64, f64),
    pub corrected: Corrected,
}

/// With the noise P_e of the reference given: (M − N) δ = Σ ν S_Rv/P + N, N = Σ ν P_e/P, diagonal. None where
/// N is more than half of M: the field is then hardly seen.
///
/// Covariance of δ_i: A⁻¹ (M + q e_i e_iᵀ) A⁻¹ with A = M − N, q = Σ ν P_e²/P², and a relative error r of P_e
/// adds (A⁻¹ N e_i r)².
///
/// Source: W. A. Fuller, Measurement Error Models, Wiley 1987, section 2.2, here by frequency.
pub fn by_known(pair: &Pair, start: &Frame, known: &KnownDensity) -> Result<Option<Corrected>, Error> {
    let noise = |frame: &Frame, axis: usize| -> Matrix4<f64> {
        let term = |k: usize, bin: usize| {
            frame.spectra.freedom[bin] * known.density[k][bin] / frame.density[axis][bin]
        };
        let of = |k: usize| if k < 3 { frame.bins().map(|bin| term(k, bin)).sum() } else { 0.0 };
        Matrix4::from_diagonal(&Vector4::from_fn(|k, _| of(k)))
    };
    let too_much =
        |axis: usize| (start.held(axis, start.bins()) - 2.0 * noise(start, axis)).cholesky().is_none();
    if (0..3).any(too_much) {
        return Ok(None);
    }
    let (frame, breads) = settled(pair, start, |frame, i| {
        let noise = noise(frame, i);
        (frame.held(i, frame.bins()) - noise, frame.left(i, frame.bins()) + noise.column(i))
    })?;
    let pulled: [Vector4<f64>; 3] = std::array::from_fn(|i| breads[i] * noise(&frame, i).column(i));
    let covariance = frame.of_matrix(|i, l| {
        let mut middle = frame.scatter(i, l, false);
        if i == l {
            let share = |bin: usize| known.density[i][bin] / frame.density[i][bin];
            let squares = frame.bins().map(|bin| frame.spectra.freedom[bin] * share(bin).powi(2));
            middle[(i, i)] += squares.sum::<f64>();
        }
        let random = breads[i] * middle * breads[l].transpose();
        random + pulled[i] * pulled[l].transpose() * known.covariance(i, l)
    });
    Ok(Some(Corrected { covariance, frame }))
}

/// With a third instrument C, whose errors are those of neither: Σ ν S_CR/P δ = Σ ν S_Cv/P. No noise needs to
/// be known.
///
/// Source: W. A. Fuller, Measurement Error Models, Wiley 1987, section 1.4 (instrumental variables).
pub fn by_third(pair: &Pair, start: &Frame) -> Result<Corrected, Error> {
    let (frame, breads) = settled(pair, start, Frame::by_third)?;
    let covariance = frame.of_matrix(|i, l| breads[i] * frame.scatter(i, l, true) * breads[l].transpose());
    Ok(Corrected { covariance, frame })
}

/// The frame in which the equations A δ = b of each axis have nothing left to correct, and A⁻¹ there.
fn settled(
    pair: &Pair,
    start: &Frame,
    equations: impl Fn(&Frame, usize) -> (Matrix4<f64>, Vector4<f64>),
) -> Result<(Frame, [Matrix4<f64>; 3]), Error> {
    let frame = settle(pair, start, |frame, i| {
        let (a, b) = equations(frame, i);
        Ok(inverse4(&a)? * b)
    })?;
    let bread = |i: usize| inverse4(&equations(&frame, i).0);
    let breads = [bread(0)?, bread(1)?, bread(2)?];
    Ok((frame, breads))
}

/// From two instruments alone: in a band b of frequencies Σ_b ν S_Rv/P = M_b δ − ρ e_i Σ_b ν S_vv/P, with one
/// δ for all bands and the share ρ of the reference in the power of v. Where the field is strong M_b gives δ,
/// where it is weak ρ is left. Generalised least squares over the bands: R + ρ v e_i has nothing in common
/// with v, so that a band's covariance is Σ ν S/P of that. None with too few bands.
///
/// The noise of the reference is taken to have the spectrum of v.
pub fn by_spectrum(pair: &Pair, start: &Frame) -> Result<Option<Spectrum>, Error> {
    if bands(start).len() < LEAST_BANDS {
        return Ok(None);
    }
    let frame =
        settle(pair, start, |frame, i| Ok(Banded::of(frame, i)?.found.fixed_rows::<4>(0).into_owned()))?;
    let found = [Banded::of(&frame, 0)?, Banded::of(&frame, 1)?, Banded::of(&frame, 2)?];
    let covariance = frame.of_matrix(|i, l| {
        let own = found[i].covariance.fixed_view::<4, 4>(0, 0).into_owned();
        if i == l { own } else { Matrix4::zeros() }
    });
    let sum = |of: fn(&Banded) -> f64| found.iter().map(of).sum::<f64>();
    Ok(Some(Spectrum {
        share: found.each_ref().map(|f| (f.found[4], f.covariance[(4, 4)].sqrt())),
        chi_squared: (sum(|f| f.chi_squared), sum(|f| f.freedom)),
        corrected: Corrected { covariance, frame },
    }))
}

impl Spectrum {
    /// Probability of shares so far above zero by chance: the largest of three.
    pub fn p(&self) -> f64 {
        let z = self.share.iter().map(|(share, std)| share / std).fold(f64::NEG_INFINITY, f64::max);
        let half = 0.5 * stats::two_sided_p(z, f64::INFINITY);
        (3.0 * if z > 0.0 { half } else { 1.0 - half }).min(1.0)
    }

    /// Probability of bands that agree worse.
    pub fn consistency_p(&self) -> f64 {
        stats::chi_squared_p(self.chi_squared.0, self.chi_squared.1)
    }
}

/// δ and ρ of one axis.
struct Banded {
    found: SVector<f64, 5>,
    covariance: SMatrix<f64, 5, 5>,
    chi_squared: f64,
    freedom: f64,
}

impl Banded {
    fn of(frame: &Frame, axis: usize) -> Result<Self, Error> {
        let bands = bands(frame);
        let mut of_band = Vec::new();
        for band in &bands {
            let (held, left) = (frame.held(axis, band.clone()), frame.left(axis, band.clone()));
            let count = frame.power(axis, band.clone());
            let mut design = SMatrix::<f64, 4, 5>::zeros();
            design.fixed_view_mut::<4, 4>(0, 0).copy_from(&held);
            design[(axis, 4)] = -count;
            of_band.push((held, left, count, design));
        }
        let mut banded = Self {
            found: SVector::zeros(),
            covariance: SMatrix::zeros(),
            chi_squared: 0.0,
            freedom: 4.0 * bands.len() as f64 - 5.0,
        };
        // The covariance of a band rests on the share.
        for _ in 0..3 {
            let share = banded.found[4].clamp(0.0, 1.0);
            let (mut information, mut right) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
            let mut weights = Vec::new();
            for (held, left, count, design) in &of_band {
                let mut variance = *held;
                for k in 0..4 {
                    variance[(axis, k)] += share * left[k];
                    variance[(k, axis)] += share * left[k];
                }
                variance[(axis, axis)] += share * share * count;
                let weight = inverse4(&variance)?;
                information += design.transpose() * weight * design;
                right += design.transpose() * weight * left;
                weights.push(weight);
            }
            banded.covariance = information.try_inverse().ok_or_else(|| {
                Error::Unanswerable("the noise of the reference cannot be estimated from the spectrum".into())
            })?;
            banded.found = banded.covariance * right;
            let rests = of_band.iter().map(|(_, left, _, design)| left - design * banded.found);
            let squares =
                rests.zip(&weights).map(|(rest, weight)| (rest.transpose() * weight * rest)[(0, 0)]);
            banded.chi_squared = squares.sum();
        }
        Ok(banded)
    }
}

/// Bands of the frequencies, each twice as high as the one before.
fn bands(frame: &Frame) -> Vec<std::ops::Range<usize>> {
    let (mut bands, mut from, mut count, mut wanted) = (Vec::new(), 0, 0.0, BAND);
    for bin in frame.bins() {
        count += 0.5 * frame.spectra.freedom[bin];
        if count >= wanted {
            bands.push(from..bin + 1);
            (from, wanted, count) = (bin + 1, if bands.len() == 1 { BAND } else { 2.0 * wanted }, 0.0);
        }
    }
    if let Some(last) = bands.last_mut() {
        last.end = frame.bins().end;
    }
    bands
}
