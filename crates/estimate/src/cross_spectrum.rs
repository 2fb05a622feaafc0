//! Spectra and cross-spectra of several even series together: a Hermitian matrix at each frequency.

use std::ops::Range;

use faer::{Mat, c64};

use crate::Error;
use crate::stats::mean;

/// Fewer samples than these have no spectrum worth the name.
pub(crate) const LEAST_SAMPLES: usize = 8;

/// One-sided spectral matrices: S_ij is the density of ⟨x_i* x_j⟩, S_ii the power density of series i.
#[derive(Clone, Debug)]
pub struct CrossSpectra {
    /// Frequencies, rising, zero and the Nyquist frequency left out (Hz).
    pub frequency_hz: Vec<f64>,
    /// S at each frequency, Hermitian (product of the series' units, per Hz).
    pub matrices: Vec<Mat<c64>>,
    /// Equivalent degrees of freedom ν of each: ν Ŝ/S of one series is about χ²(ν), and ν/2 Ŝ is about
    /// complex Wishart with ν/2 degrees of freedom, where the densities change little.
    pub freedom: Vec<f64>,
}

impl CrossSpectra {
    /// The spectral matrices of series `step_s` apart, averaged over segments and sine tapers.
    ///
    /// Segments of n = `segment_samples`, less their means, start every n − ⌊n/2⌋ samples; what is left at the
    /// end is not used. With the orthonormal tapers w_t(m) = √(2/(n + 1)) sin(π t (m + 1)/(n + 1)), t = 1 …
    /// `tapers`,
    ///
    /// S_ij(f_k) = 2 Δt ⟨X_i* X_j⟩, X = Σ w_t(m) (x_m − x̄) e^(−2πi k m/n), f_k = k/(n Δt), k = 1 … below
    /// n/2,
    ///
    /// the mean over segments and tapers. An estimate is (`tapers` + 1)/((n + 1) Δt) wide, and the lowest lack
    /// the mean that was taken off. Degrees of freedom: ν = 2 N²/Σ_ab |⟨w_a, w_b⟩|² over the N tapers of all
    /// segments, each at its place.
    ///
    /// More samples for a segment than there are in the series: one segment, the whole series.
    ///
    /// Sources: K. S. Riedel and A. Sidorenko, Minimum bias multiple taper spectral estimation, IEEE Trans.
    /// Signal Process. 43 (1995) 188–195; P. D. Welch, IEEE Trans. Audio Electroacoust. AU-15 (1967) 70–73.
    ///
    /// Errors: [`Error::TooFew`] for fewer than 8 samples in a segment, and without a taper;
    /// [`Error::Series`] for series of different lengths or with samples that are not finite.
    pub fn of(
        channels: &[&[f64]],
        step_s: f64,
        segment_samples: usize,
        tapers: usize,
    ) -> Result<Self, Error> {
        let rows = rows(channels)?;
        let n = segment_samples.min(rows);
        if n < LEAST_SAMPLES || tapers == 0 {
            return Err(Error::TooFew { found: n.min(tapers), unknowns: LEAST_SAMPLES });
        }
        let hop = n - n / 2;
        let starts: Vec<usize> = (0..=rows - n).step_by(hop).collect();
        let windows: Vec<Vec<f64>> = (1..=tapers).map(|order| sine_taper(n, order)).collect();
        let mut sums = Sums::of(channels.len(), (n, step_s), 0.0);
        for start in &starts {
            for window in &windows {
                sums.add(channels.iter().map(|x| transform(&x[*start..start + n], Some(window))));
            }
        }
        let averaged = (starts.len() * tapers) as f64;
        let freedom = freedom(&windows, hop, starts.len());
        Ok(sums.spectra(|_| (2.0 * step_s / averaged, freedom)))
    }

    /// The spectral matrices of the whole series without a taper, averaged over neighbouring Fourier
    /// frequencies k/(N Δt): single ones at low k, then bins no wider than `widest` times their frequency.
    /// Ordinates are independent where the density changes little: two degrees of freedom for each.
    ///
    /// Errors: as [`CrossSpectra::of`].
    pub fn of_whole(channels: &[&[f64]], step_s: f64, widest: f64) -> Result<Self, Error> {
        let n = rows(channels)?;
        if n < LEAST_SAMPLES {
            return Err(Error::TooFew { found: n, unknowns: LEAST_SAMPLES });
        }
        let mut sums = Sums::of(channels.len(), (n, step_s), widest);
        sums.add(channels.iter().map(|x| transform(x, None)));
        Ok(sums.spectra(|count| (2.0 * step_s / (n as f64 * count), 2.0 * count)))
    }
}

/// Widest bin of a periodogram, as a share of its lowest frequency.
pub(crate) const WIDEST_BIN: f64 = 0.02;

/// Places of k = 1 … `count` in bins; the first is that of k = 1.
pub(crate) fn bins(count: usize, widest: f64) -> impl Iterator<Item = Range<usize>> {
    let next = move |from: usize| from + ((widest * (from + 1) as f64) as usize).max(1);
    let starts = std::iter::successors(Some(0), move |from| Some(next(*from)));
    starts.take_while(move |from| *from < count).map(move |from| from..next(from).min(count))
}

/// Samples of every series.
fn rows(channels: &[&[f64]]) -> Result<usize, Error> {
    let rows = channels.first().map_or(0, |first| first.len());
    if channels.iter().any(|x| x.len() != rows) {
        return Err(Error::Series("beside one of another length"));
    }
    if channels.iter().any(|x| x.iter().any(|value| !value.is_finite())) {
        return Err(Error::Series("with samples that are not finite"));
    }
    Ok(rows)
}

/// √(2/(n + 1)) sin(π t (m + 1)/(n + 1)).
fn sine_taper(samples: usize, order: usize) -> Vec<f64> {
    let width = samples as f64 + 1.0;
    let phase = std::f64::consts::PI * order as f64 / width;
    (1..=samples).map(|m| (2.0 / width).sqrt() * (phase * m as f64).sin()).collect()
}

/// 2 N²/Σ |⟨w_a, w_b⟩|² over the tapers, of length one, of all segments; those two apart share nothing.
pub(crate) fn freedom(windows: &[Vec<f64>], hop: usize, segments: usize) -> f64 {
    let (count, mut common) = (segments as f64, 0.0);
    for a in windows {
        for b in windows {
            let square = |lag: usize| a[lag..].iter().zip(b).map(|(a, b)| a * b).sum::<f64>().powi(2);
            common += count * square(0) + 2.0 * (count - 1.0) * square(hop);
        }
    }
    2.0 * (count * windows.len() as f64).powi(2) / common
}

/// The transform of samples less their mean.
pub(crate) fn transform(samples: &[f64], window: Option<&Vec<f64>>) -> Vec<c64> {
    let middle = mean(samples);
    let mut input: Vec<f64> = samples.iter().map(|x| x - middle).collect();
    if let Some(window) = window {
        input.iter_mut().zip(window).for_each(|(x, weight)| *x *= weight);
    }
    fourier::forward(input)
}

/// Sums of X_i* X_j over the ordinates of each bin.
struct Sums {
    bins: Vec<Range<usize>>,
    length_s: f64,
    sums: Vec<Mat<c64>>,
}

impl Sums {
    /// Of nothing yet: n samples, bins no wider than that share of their frequency.
    fn of(channels: usize, (n, step_s): (usize, f64), widest: f64) -> Self {
        let bins: Vec<Range<usize>> = bins(n.div_ceil(2) - 1, widest).collect();
        Self { sums: vec![Mat::zeros(channels, channels); bins.len()], bins, length_s: n as f64 * step_s }
    }

    fn add(&mut self, transforms: impl Iterator<Item = Vec<c64>>) {
        let transforms: Vec<Vec<c64>> = transforms.collect();
        for (sum, bin) in self.sums.iter_mut().zip(&self.bins) {
            for order in bin.start + 1..=bin.end {
                for (i, x) in transforms.iter().enumerate() {
                    for (j, y) in transforms.iter().enumerate() {
                        sum[(i, j)] += x[order].conj() * y[order];
                    }
                }
            }
        }
    }

    /// The spectra; `by` gives the factor of a sum and its degrees of freedom from its number of ordinates.
    fn spectra(self, by: impl Fn(f64) -> (f64, f64)) -> CrossSpectra {
        let of = |(bin, sum): (Range<usize>, Mat<c64>)| {
            let (factor, freedom) = by(bin.len() as f64);
            let middle = 0.5 * (bin.start + 1 + bin.end) as f64;
            let matrix = Mat::from_fn(sum.nrows(), sum.ncols(), |i, j| sum[(i, j)] * factor);
            (middle / self.length_s, (matrix, freedom))
        };
        let (frequency_hz, (matrices, freedom)) = self.bins.into_iter().zip(self.sums).map(of).unzip();
        CrossSpectra { frequency_hz, matrices, freedom }
    }
}
