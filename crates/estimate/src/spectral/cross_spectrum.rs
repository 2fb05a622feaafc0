//! Spectra and cross-spectra of several even series together: a Hermitian matrix at each frequency.

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
    /// complex Wishart with ν/2 degrees of freedom, where the densities change little over the width of an
    /// estimate.
    pub freedom: Vec<f64>,
}

impl CrossSpectra {
    /// The spectral matrices of series `step_s` apart, averaged over segments and sine tapers.
    ///
    /// Segments of n = `segment_samples` start every n − ⌊n/2⌋ samples; what is left at the end is not used.
    /// From each its mean is taken off. With the tapers w_t(m) = √(2/(n + 1)) sin(π t (m + 1)/(n + 1)), t = 1
    /// … `tapers`, which are orthonormal,
    ///
    /// S_ij(f_k) = 2 Δt ⟨X_i* X_j⟩, X = Σ w_t(m) (x_m − x̄) e^(−2πi k m/n), f_k = k/(n Δt), k = 1 … below
    /// n/2,
    ///
    /// the mean over segments and tapers. An estimate is (`tapers` + 1)/((n + 1) Δt) wide, so that neighbours
    /// have a part in common, and the lowest lack the mean that was taken off. Degrees of freedom: ν = 2
    /// N²/Σ_ab |⟨w_a, w_b⟩|² over the N tapers of all segments, each at its place.
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
        let mut sums = Sums::new(channels.len(), n.div_ceil(2) - 1);
        let mut transform = Transform::new(n);
        for start in &starts {
            for window in &windows {
                let transforms: Vec<Vec<c64>> =
                    channels.iter().map(|x| transform.of(&x[*start..start + n], Some(window))).collect();
                sums.add(&transforms, |order| Some(order - 1));
            }
        }
        let averaged = (starts.len() * tapers) as f64;
        let freedom = freedom(&windows, hop, starts.len());
        Ok(Self {
            frequency_hz: (1..=sums.0.len()).map(|k| k as f64 / (n as f64 * step_s)).collect(),
            freedom: vec![freedom; sums.0.len()],
            matrices: sums.scaled(|_| 2.0 * step_s / averaged),
        })
    }

    /// The spectral matrices of the whole series without a taper, averaged over neighbouring Fourier
    /// frequencies k/(N Δt): single ones at low k, then bins no wider than `widest` times their frequency.
    /// The ordinates of a Gaussian series whose density changes little over 1/(N Δt) are independent, so that
    /// each bin has two degrees of freedom for each.
    ///
    /// Errors: as [`CrossSpectra::of`].
    pub fn of_whole(channels: &[&[f64]], step_s: f64, widest: f64) -> Result<Self, Error> {
        let n = rows(channels)?;
        if n < LEAST_SAMPLES {
            return Err(Error::TooFew { found: n, unknowns: LEAST_SAMPLES });
        }
        let mut transform = Transform::new(n);
        let transforms: Vec<Vec<c64>> = channels.iter().map(|x| transform.of(x, None)).collect();
        let (mut bin_of, mut bins) = (vec![None; n.div_ceil(2)], Vec::new());
        let mut from = 1;
        while from < bin_of.len() {
            let to = (from + ((widest * from as f64) as usize).max(1)).min(bin_of.len());
            bin_of[from..to].fill(Some(bins.len()));
            bins.push((0.5 * (from + to - 1) as f64, (to - from) as f64));
            from = to;
        }
        let mut sums = Sums::new(channels.len(), bins.len());
        sums.add(&transforms, |order| bin_of.get(order).copied().flatten());
        Ok(Self {
            frequency_hz: bins.iter().map(|(order, _)| order / (n as f64 * step_s)).collect(),
            freedom: bins.iter().map(|(_, count)| 2.0 * count).collect(),
            matrices: sums.scaled(|bin| 2.0 * step_s / (n as f64 * bins[bin].1)),
        })
    }
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

/// 2 N²/Σ |⟨w_a, w_b⟩|² over the tapers of all segments, which have the length one; segments two apart have
/// nothing in common.
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

/// Transforms of one length.
pub(crate) struct Transform {
    plan: fourier::Forward,
    input: Vec<f64>,
    scratch: Vec<c64>,
}

impl Transform {
    pub fn new(n: usize) -> Self {
        let plan = fourier::forward(n);
        Self { input: plan.make_input_vec(), scratch: plan.make_scratch_vec(), plan }
    }

    /// Of the samples less their mean.
    pub fn of(&mut self, samples: &[f64], window: Option<&Vec<f64>>) -> Vec<c64> {
        let middle = mean(samples);
        for (m, (input, x)) in self.input.iter_mut().zip(samples).enumerate() {
            *input = (x - middle) * window.map_or(1.0, |window| window[m]);
        }
        let mut output = self.plan.make_output_vec();
        self.plan
            .process_with_scratch(&mut self.input, &mut output, &mut self.scratch)
            .expect("buffers of the plan's lengths");
        output
    }
}

/// Sums of X_i* X_j for each estimate.
struct Sums(Vec<Mat<c64>>);

impl Sums {
    fn new(channels: usize, estimates: usize) -> Self {
        Self(vec![Mat::zeros(channels, channels); estimates])
    }

    /// Adds each ordinate, from the first below the Nyquist frequency on, to its estimate.
    fn add(&mut self, transforms: &[Vec<c64>], estimate: impl Fn(usize) -> Option<usize>) {
        let ordinates = transforms.first().map_or(0, Vec::len);
        for order in 1..ordinates {
            let Some(sum) = estimate(order).and_then(|at| self.0.get_mut(at)) else { continue };
            for (i, x) in transforms.iter().enumerate() {
                for (j, y) in transforms.iter().enumerate() {
                    sum[(i, j)] += x[order].conj() * y[order];
                }
            }
        }
    }

    fn scaled(self, factor: impl Fn(usize) -> f64) -> Vec<Mat<c64>> {
        let scale = |(at, sum): (usize, Mat<c64>)| {
            Mat::from_fn(sum.nrows(), sum.ncols(), |i, j| sum[(i, j)] * factor(at))
        };
        self.0.into_iter().enumerate().map(scale).collect()
    }
}
