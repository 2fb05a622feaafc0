//! The test instrument in the axes of the reference: T η⁻¹ = R + v.

use std::ops::Range;

use estimate::cross_spectrum::CrossSpectra;
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4};

use crate::Error;
use crate::regression::AxisFit;
use joined::Pair;
use paired::noise::Noise;
use paired::residual::centred;

/// Widest bin of the spectra, as a share of its frequency.
const WIDEST: f64 = 0.02;
/// Rounds of correcting the matrix, the first of them in which the weights are found anew, and the change
/// below which the last one is reached.
const ROUNDS: usize = 30;
const WEIGHED: usize = 3;
const SETTLED: f64 = 1e-9;
/// Channels of the spectra: the reference's three, the time, v along its three axes, and a third instrument's
/// three.
const REFERENCE: [usize; 4] = [0, 1, 2, 3];
const REST: usize = 4;
const THIRD: [usize; 4] = [7, 8, 9, 3];

/// A matrix and the drift, and what they leave in the axes of the reference.
pub struct Frame {
    pub eta: Matrix3<f64>,
    /// Drift along the axes of the reference, nT a day.
    drift: Vector3<f64>,
    /// v, nT.
    pub rest: [Vec<f64>; 3],
    pub spectra: CrossSpectra,
    /// P of v along each axis, at the frequencies of the spectra, nT²/Hz.
    pub density: [Vec<f64>; 3],
}

impl Frame {
    /// η and drift by least squares, all frequencies weighed alike. Weights from what a pulled matrix leaves
    /// would be wrong: field is in it, and where the field is strong they would be low, which pulls the more.
    pub fn start(pair: &Pair, fits: &[AxisFit; 3]) -> Result<Self, Error> {
        let eta = Matrix3::from_fn(|i, j| fits[j].fit.least_squares[i]);
        let drift = Vector3::from_fn(|j, _| fits[j].fit.least_squares[3]);
        let drift = invert(&eta)?.transpose() * drift;
        let mut frame = Self::of(pair, eta, drift, Some(Default::default()))?;
        for (density, rest) in frame.density.iter_mut().zip(&frame.rest) {
            let square = centred(rest).iter().map(|v| v.powi(2)).sum::<f64>() / rest.len() as f64;
            *density = vec![2.0 * square * pair.step_s; frame.spectra.frequency_hz.len()];
        }
        Ok(frame)
    }

    /// With the densities as told, or as fitted to v.
    fn of(
        pair: &Pair,
        eta: Matrix3<f64>,
        drift: Vector3<f64>,
        told: Option<[Vec<f64>; 3]>,
    ) -> Result<Self, Error> {
        let (inverse, days) = (invert(&eta)?, pair.days());
        let rest = |i: usize, row: usize| {
            let turned: f64 = (0..3).map(|j| pair.test[j][row] * inverse[(j, i)]).sum();
            turned - pair.reference[i][row] - drift[i] * days[row]
        };
        let rest: [Vec<f64>; 3] = std::array::from_fn(|i| (0..days.len()).map(|row| rest(i, row)).collect());
        let mut channels: Vec<&[f64]> = pair.reference.iter().map(AsRef::as_ref).collect();
        channels.push(&days);
        channels.extend(rest.iter().map(Vec::as_slice));
        channels.extend(pair.third.iter().flatten().map(AsRef::as_ref));
        let spectra = CrossSpectra::of_whole(&channels, pair.step_s, WIDEST)?;
        let fitted = |rest: &Vec<f64>| -> Result<Vec<f64>, Error> {
            let noise = Noise::seen(&centred(rest), pair)?;
            Ok(spectra.frequency_hz.iter().map(|frequency| noise.density(*frequency)).collect())
        };
        let density = match told {
            Some(density) => density,
            None => [fitted(&rest[0])?, fitted(&rest[1])?, fitted(&rest[2])?],
        };
        Ok(Self { eta, drift, rest, spectra, density })
    }

    /// d = v η of one axis of the test instrument less its mean, nT.
    pub fn difference(&self, test: usize) -> Vec<f64> {
        let all: Vec<f64> = (0..self.rest[0].len())
            .map(|row| (0..3).map(|i| self.rest[i][row] * self.eta[(i, test)]).sum())
            .collect();
        centred(&all)
    }

    pub fn bins(&self) -> Range<usize> {
        0..self.spectra.frequency_hz.len()
    }

    /// Σ ν of each bin × a weight × the density ⟨a* b⟩.
    fn sum(&self, bins: Range<usize>, (a, b): (usize, usize), weight: impl Fn(usize) -> f64) -> f64 {
        let term =
            |bin: usize| self.spectra.freedom[bin] * weight(bin) * self.spectra.matrices[bin][(a, b)].re;
        bins.map(term).sum()
    }

    fn matrix(
        &self,
        bins: Range<usize>,
        rows: [usize; 4],
        columns: [usize; 4],
        weight: impl Fn(usize) -> f64,
    ) -> Matrix4<f64> {
        Matrix4::from_fn(|a, b| self.sum(bins.clone(), (rows[a], columns[b]), &weight))
    }

    /// Σ ν S_RR/P_i over the bins, the time as a fourth.
    pub fn held(&self, axis: usize, bins: Range<usize>) -> Matrix4<f64> {
        self.matrix(bins, REFERENCE, REFERENCE, |bin| 1.0 / self.density[axis][bin])
    }

    /// Σ ν S_Rv/P_i over the bins.
    pub fn left(&self, axis: usize, bins: Range<usize>) -> Vector4<f64> {
        Vector4::from_fn(|a, _| {
            self.sum(bins.clone(), (REFERENCE[a], REST + axis), |bin| 1.0 / self.density[axis][bin])
        })
    }

    /// Σ ν S_vv/P_i over the bins: about their degrees of freedom.
    pub fn power(&self, axis: usize, bins: Range<usize>) -> f64 {
        self.sum(bins, (REST + axis, REST + axis), |bin| 1.0 / self.density[axis][bin])
    }

    /// The same as `held` and `left` with the third instrument in place of the reference: Σ ν S_CR/P_i and Σ
    /// ν S_Cv/P_i.
    pub fn by_third(&self, axis: usize) -> (Matrix4<f64>, Vector4<f64>) {
        let weight = |bin: usize| 1.0 / self.density[axis][bin];
        let left = Vector4::from_fn(|a, _| self.sum(self.bins(), (THIRD[a], REST + axis), weight));
        (self.matrix(self.bins(), THIRD, REFERENCE, weight), left)
    }

    /// Σ ν S/√(P_i P_l), of the reference or of the third instrument, times how far v_i and v_l go together.
    pub fn scatter(&self, i: usize, l: usize, third: bool) -> Matrix4<f64> {
        let channels = if third { THIRD } else { REFERENCE };
        let root = |bin: usize| 1.0 / (self.density[i][bin] * self.density[l][bin]).sqrt();
        let coherence = if i == l {
            1.0
        } else {
            let own = |axis: usize| self.power(axis, self.bins());
            self.sum(self.bins(), (REST + i, REST + l), root) / (own(i) * own(l)).sqrt()
        };
        self.matrix(self.bins(), channels, channels, root) * coherence
    }

    /// Covariance of η, column by column, from that of δ_i and δ_l, which are columns of δ in (1 + δ) η with the
    /// time as a fourth row.
    pub fn of_matrix(&self, block: impl Fn(usize, usize) -> Matrix4<f64>) -> SMatrix<f64, 9, 9> {
        let blocks: [[_; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|l| block(i, l)));
        SMatrix::from_fn(|row, column| {
            let ((j, a), (m, b)) = ((row / 3, row % 3), (column / 3, column % 3));
            let mut sum = 0.0;
            for (i, of) in blocks.iter().enumerate() {
                for (l, block) in of.iter().enumerate() {
                    sum += block[(a, b)] * self.eta[(i, j)] * self.eta[(l, m)];
                }
            }
            sum
        })
    }
}

/// Repeats a correction δ of each axis, (1 + δ) η and the drift beside it, until there is nothing left to correct.
pub fn settle(
    pair: &Pair,
    start: &Frame,
    correction: impl Fn(&Frame, usize) -> Result<Vector4<f64>, Error>,
) -> Result<Frame, Error> {
    let all = |frame: &Frame| -> Result<[Vector4<f64>; 3], Error> {
        Ok([correction(frame, 0)?, correction(frame, 1)?, correction(frame, 2)?])
    };
    let mut delta = all(start)?;
    let (mut eta, mut drift, mut density) = (start.eta, start.drift, start.density.clone());
    for round in 0..ROUNDS {
        eta = (Matrix3::identity() + Matrix3::from_fn(|a, i| delta[i][a])) * eta;
        drift += Vector3::from_fn(|i, _| delta[i][3]);
        let frame = Frame::of(pair, eta, drift, (round >= WEIGHED).then(|| density.clone()))?;
        delta = all(&frame)?;
        let largest = delta.iter().flat_map(|d| d.iter().take(3)).fold(0.0_f64, |most, d| most.max(d.abs()));
        if largest < SETTLED {
            return Ok(frame);
        }
        density = frame.density;
    }
    let last_shift = delta.iter().map(|d| d.norm()).fold(0.0, f64::max);
    Err(estimate::Error::NotConverged { iterations: ROUNDS, last_shift }.into())
}

/// The inverse of a matrix whose axes are three.
pub fn invert(eta: &Matrix3<f64>) -> Result<Matrix3<f64>, Error> {
    eta.try_inverse().ok_or_else(|| {
        Error::Unanswerable(
            "the matrix between the instruments has no inverse: two axes of the test instrument read the same; compare its \
             connections"
                .into(),
        )
    })
}

/// The inverse of an information, or why there is none.
pub fn inverse4(information: &Matrix4<f64>) -> Result<Matrix4<f64>, Error> {
    information.try_inverse().filter(|inverse| inverse.iter().all(|value| value.is_finite())).ok_or_else(|| {
        Error::Unanswerable(
            "the field varied too little to tell the axes apart; record longer, or on more disturbed days".into(),
        )
    })
}
