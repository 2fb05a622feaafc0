//! The Whittle likelihood of periodograms under a power law and white noise, and its maximum.

use std::cell::{Ref, RefCell};
use std::f64::consts::PI;

use faer::Mat;

use crate::Error;
use crate::periodogram::Periodogram;
use crate::scoring::{Likelihood, Optimum, Slope, minimise};

/// Least and largest exponent α.
pub(crate) const EXPONENTS: (f64, f64) = (0.2, 2.5);
/// Longest step in the exponent.
pub(crate) const LONGEST: f64 = 0.5;
/// Exponents from which the search starts, and how many of these are followed to the end.
const STARTS: usize = 12;
const FOLLOWED: usize = 2;
/// Neighbours within so much of ln f are one bin while the starts are found.
const WIDE: f64 = 0.25;
/// Multiplicative steps of a start.
const START_STEPS: usize = 10;

/// What the white noise of all series has in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum White {
    /// The rms of a reading, σ.
    PerReading,
    /// The density N, from which a reading of a series has the rms √(N/(2 Δt)).
    Density,
    /// Nothing: each series has its own rms of a reading.
    Each,
}

impl White {
    /// Density of a white variance of one (unit²/Hz) in readings `step_s` apart.
    pub(super) fn density(self, step_s: f64) -> f64 {
        if self == White::Density { 1.0 } else { 2.0 * step_s }
    }
}

/// The bins of all series.
pub(super) struct Data {
    pub bins: Vec<Binned>,
    pub step_s: Vec<f64>,
    /// ln of the lowest frequency (Hz).
    pub lowest: f64,
}

/// A bin of one of the series.
pub(super) struct Binned {
    /// ln of the frequency over the lowest one.
    pub x: f64,
    /// What its flicker lacks is this share times α (2 − α); see [`Periodogram::mirrored`].
    pub lacking: f64,
    pub density: f64,
    pub ln_density: f64,
    pub count: f64,
    pub series: usize,
}

impl Binned {
    /// The mean of both, by their counts.
    fn join(&mut self, other: &Binned) {
        let share = other.count / (self.count + other.count);
        let mean = |a: f64, b: f64| a + share * (b - a);
        self.x = mean(self.x, other.x);
        self.lacking = mean(self.lacking, other.lacking);
        self.density = mean(self.density, other.density);
        self.ln_density = self.density.max(f64::MIN_POSITIVE).ln();
        self.count += other.count;
    }

    /// e^(−αx) (1 − α (2 − α) u), flicker of amplitude one, with two derivatives by α.
    fn flicker(&self, exponent: f64) -> [f64; 3] {
        let (x, u, power) = (self.x, self.lacking, (-exponent * self.x).exp());
        let (seen, slope) = (1.0 - exponent * (2.0 - exponent) * u, 2.0 * (1.0 - exponent) * u);
        [power * seen, -power * (x * seen + slope), power * (x * x * seen + 2.0 * x * slope + 2.0 * u)]
    }
}

impl Data {
    pub fn of(series: &[Periodogram]) -> Result<Self, Error> {
        let all = || series.iter().flat_map(|s| &s.bins);
        if all().any(|bin| !(bin.density.is_finite() && bin.frequency_hz > 0.0 && bin.count > 0.0)) {
            return Err(Error::Series("with ordinates that are not finite"));
        }
        if series.iter().any(|s| s.bins.iter().all(|bin| bin.density <= 0.0)) {
            return Err(Error::Series("that does not vary"));
        }
        let (count, unknowns) = (all().map(|bin| bin.count).sum::<f64>() as usize, 2 + series.len());
        if count <= unknowns || series.is_empty() {
            return Err(Error::TooFew { found: count, unknowns: unknowns + 1 });
        }
        let lowest = all().map(|bin| bin.frequency_hz).fold(f64::INFINITY, f64::min).ln();
        let bins = series.iter().enumerate().flat_map(|(number, s)| {
            s.bins.iter().map(move |bin| Binned {
                x: bin.frequency_hz.ln() - lowest,
                // k = 2 f T.
                lacking: if s.mirrored { 1.0 / (PI * PI * bin.frequency_hz * s.length_s) } else { 0.0 },
                density: bin.density,
                ln_density: bin.density.max(f64::MIN_POSITIVE).ln(),
                count: bin.count,
                series: number,
            })
        });
        Ok(Data { bins: bins.collect(), step_s: series.iter().map(|s| s.step_s).collect(), lowest })
    }

    pub fn series(&self) -> usize {
        self.step_s.len()
    }

    /// The same in wide bins: a likelihood that is much the same, and quick.
    fn wide(&self) -> Data {
        let mut bins: Vec<Binned> = Vec::new();
        let mut begin = 0.0;
        for bin in &self.bins {
            match bins.last_mut().filter(|last| last.series == bin.series && bin.x - begin < WIDE) {
                Some(last) => last.join(bin),
                None => {
                    begin = bin.x;
                    bins.push(Binned { ..*bin });
                }
            }
        }
        Data { bins, step_s: self.step_s.clone(), lowest: self.lowest }
    }
}

/// P = θ₀ (f/f₀)^−θ₁ (1 − θ₁ (2 − θ₁) u) + c θ_(2+g), f₀ the lowest frequency, u what a mirrored series
/// lacks; g the group and c the shape of the white part of a series.
///
/// The amplitude is held at the lowest frequency, where flicker is seen best. A θ₀ or white θ of zero: that
/// part is absent.
pub(super) struct Model<'a> {
    pub data: &'a Data,
    pub white: White,
    /// The flicker of every bin, as [`Binned::flicker`], for the exponent that was asked for last: most
    /// points are looked at twice, and in many searches the exponent is held.
    shapes: RefCell<(f64, Vec<[f64; 3]>)>,
}

impl<'a> Model<'a> {
    pub fn new(data: &'a Data, white: White) -> Self {
        Self { data, white, shapes: RefCell::new((f64::NAN, Vec::new())) }
    }

    fn shapes(&self, exponent: f64) -> Ref<'_, [[f64; 3]]> {
        if self.shapes.borrow().0 != exponent {
            let of_bins = self.data.bins.iter().map(|bin| bin.flicker(exponent)).collect();
            self.shapes.replace((exponent, of_bins));
        }
        Ref::map(self.shapes.borrow(), |(_, shapes)| shapes.as_slice())
    }

    /// Number of white unknowns.
    pub fn groups(&self) -> usize {
        if self.white == White::Each { self.data.series() } else { 1 }
    }

    /// The white unknown of a series.
    pub fn group(&self, series: usize) -> usize {
        if self.white == White::Each { series } else { 0 }
    }

    /// The density of the white part of a series for a white unknown of one.
    pub fn shape(&self, series: usize) -> f64 {
        self.white.density(self.data.step_s[series])
    }

    /// The mean over the ordinates of each group.
    fn pooled(&self, of: impl Fn(&Binned) -> f64) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.groups()];
        for bin in &self.data.bins {
            let sum = &mut sums[self.group(bin.series)];
            *sum = (sum.0 + bin.count * of(bin), sum.1 + bin.count);
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }

    /// The unknowns of another form of white noise as those of each series.
    pub fn spread(&self, other: &Model, theta: &[f64]) -> Vec<f64> {
        let white = |s: usize| theta[2 + other.group(s)] * other.shape(s) / self.shape(s);
        theta[..2].iter().copied().chain((0..self.data.series()).map(white)).collect()
    }

    /// The white noise of greatest likelihood without flicker: the mean ordinate of each group.
    pub fn white_only(&self) -> Vec<f64> {
        let whites = self.pooled(|bin| bin.density / self.shape(bin.series));
        [0.0, 1.0].into_iter().chain(whites).collect()
    }

    /// Every bin with the flicker and the white part of its density.
    pub fn parts(&self, theta: &[f64]) -> impl Iterator<Item = (&'a Binned, f64, f64)> {
        let shapes = self.shapes(theta[1]);
        let whites: Vec<f64> =
            (0..self.data.series()).map(|s| theta[2 + self.group(s)] * self.shape(s)).collect();
        let amplitude = theta[0];
        let part = move |(at, bin): (usize, &'a Binned)| (bin, amplitude * shapes[at][0], whites[bin.series]);
        self.data.bins.iter().enumerate().map(part)
    }
}

impl Likelihood for Model<'_> {
    /// Σ count (I/P − 1 − ln(I/P)), half the deviance.
    fn cost(&self, theta: &[f64]) -> f64 {
        let term = |(bin, flicker, white): (&Binned, f64, f64)| {
            let density = flicker + white;
            bin.count * (bin.density / density - 1.0 + density.ln() - bin.ln_density)
        };
        self.parts(theta).map(term).sum()
    }

    /// Cost and derivatives. With s = ∂P/∂θ / P and q = ∂²P/∂θ² / P the gradient of an ordinate is (1 − I/P)
    /// s, its second derivative (2 I/P − 1) s sᵀ + (1 − I/P) q, and the expectation of that s sᵀ.
    fn slope(&self, theta: &[f64]) -> Slope {
        let unknowns = theta.len();
        let (mut cost, mut gradient) = (0.0, vec![0.0; unknowns]);
        let (mut hessian, mut fisher) = (Mat::zeros(unknowns, unknowns), Mat::zeros(unknowns, unknowns));
        let shapes = self.shapes(theta[1]);
        let bins = self.data.bins.iter().zip(shapes.iter());
        let whites: Vec<(usize, f64)> =
            (0..self.data.series()).map(|s| (2 + self.group(s), self.shape(s))).collect();
        for (series, (own, white_shape)) in whites.into_iter().enumerate() {
            // The elements of θ₀, θ₁ and the white unknown of this series: 00, 01, 11, 0w, 1w, ww.
            let (mut first_derivatives, mut second, mut expected) = ([0.0; 3], [0.0; 6], [0.0; 6]);
            for (bin, [shape, first, bent]) in bins.clone().filter(|(bin, _)| bin.series == series) {
                let density = theta[0] * shape + theta[own] * white_shape;
                let ratio = bin.density / density;
                cost += bin.count * (ratio - 1.0 + density.ln() - bin.ln_density);
                let s = [shape / density, theta[0] * first / density, white_shape / density];
                let (up, information) = (bin.count * (1.0 - ratio), bin.count * (2.0 * ratio - 1.0));
                let products = [s[0] * s[0], s[0] * s[1], s[1] * s[1], s[0] * s[2], s[1] * s[2], s[2] * s[2]];
                (0..3).for_each(|i| first_derivatives[i] += up * s[i]);
                (0..6).for_each(|i| expected[i] += bin.count * products[i]);
                (0..6).for_each(|i| second[i] += information * products[i]);
                second[1] += up / density * first;
                second[2] += up / density * theta[0] * bent;
            }
            let places = [(0, 0), (0, 1), (1, 1), (0, own), (1, own), (own, own)];
            for (matrix, elements) in [(&mut hessian, second), (&mut fisher, expected)] {
                for ((i, j), element) in places.into_iter().zip(elements) {
                    matrix[(i, j)] += element;
                    matrix[(j, i)] = matrix[(i, j)];
                }
            }
            [0, 1, own].into_iter().zip(first_derivatives).for_each(|(i, d)| gradient[i] += d);
        }
        Slope { cost, gradient, hessian, fisher }
    }

    fn limits(&self, theta: &[f64], unknown: usize) -> (f64, f64) {
        match unknown {
            1 => ((EXPONENTS.0 - theta[1]).max(-LONGEST), (EXPONENTS.1 - theta[1]).min(LONGEST)),
            _ => (-theta[unknown], f64::INFINITY),
        }
    }
}

impl Model<'_> {
    /// Least cost with flicker, from starts over all exponents and from those given.
    pub fn best(&self, given: &[Vec<f64>]) -> Result<Optimum, Error> {
        let wide = self.data.wide();
        let rough = Model::new(&wide, self.white);
        let mut starts: Vec<Optimum> = (0..STARTS)
            .filter_map(|i| {
                let share = i as f64 / (STARTS - 1) as f64;
                let start = rough.start(EXPONENTS.0 + (EXPONENTS.1 - EXPONENTS.0) * share);
                minimise(&rough, start, &[1]).ok()
            })
            .collect();
        starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        // With the exponent held first, no step from there loses the flicker.
        let followed = starts.into_iter().filter_map(|start| minimise(self, start.theta, &[1]).ok());
        let followed = followed.take(FOLLOWED).map(|start| start.theta);
        let better = |best: Result<Optimum, Error>, found: Result<Optimum, Error>| match (&best, &found) {
            (Ok(one), Ok(other)) if other.cost < one.cost => found,
            (Ok(_), _) => best,
            _ => found,
        };
        let found = followed.chain(given.iter().cloned()).map(|start| minimise(self, start, &[]));
        found.reduce(better).unwrap_or(Err(Error::NotConverged { iterations: 0, last_shift: f64::NAN }))
    }

    /// A start for one exponent: half the mean ordinate each for flicker and white noise, then multiplicative
    /// steps that each lower the cost.
    ///
    /// Source: C. Févotte and J. Idier, Algorithms for nonnegative matrix factorization with the
    /// β-divergence, Neural Computation 23 (2011) 2421–2456, β = 0.
    fn start(&self, exponent: f64) -> Vec<f64> {
        let mut theta = self.white_only();
        let (sum, count) = self.data.bins.iter().fold((0.0, 0.0), |(sum, count), bin| {
            (sum + bin.count * bin.density * (exponent * bin.x).exp(), count + bin.count)
        });
        (theta[0], theta[1]) = (0.5 * sum / count, exponent);
        theta[2..].iter_mut().for_each(|white| *white *= 0.5);
        for _ in 0..START_STEPS {
            let mut sums = vec![(0.0, 0.0); theta.len()];
            for (bin, flicker, white) in self.parts(&theta) {
                let density = flicker + white;
                for (i, part) in [(0, flicker), (2 + self.group(bin.series), white)] {
                    sums[i].0 += bin.count * part * bin.density / (density * density);
                    sums[i].1 += bin.count * part / density;
                }
            }
            for (theta, (up, down)) in theta.iter_mut().zip(sums).filter(|(_, sums)| sums.0 > 0.0) {
                *theta *= (up / down).sqrt();
            }
        }
        theta
    }
}
