//! The delay that one axis shows over all rows, in parts of them and in bands of period.

use std::ops::Range;

use common::DelayBand;
use estimate::periodogram::periodogram;
use estimate::spectral::{Transform, weighted};
use estimate::spectrum::{Spectrum, welch};
use rayon::prelude::*;

use super::offset::Offset;
use crate::Error;
use crate::look::Look;
use crate::noise::Noise;
use crate::residual::{centred, rest};
use joined::Pair;

/// Where the coefficient follows by less than this share, no delay is seen.
const FOLLOWS: f64 = 0.1;
/// A band with less of the response is heard of one instrument alone.
const HEARD: f64 = 0.5;
/// Share of the rows over which each end is tapered: else the ends' mismatch would be most of what is fitted
/// at short periods.
const TAPERED: f64 = 0.1;

/// Bands in which the reference's changes are seen in the test instrument.
#[derive(Default)]
pub struct Heard(Option<Vec<Range<f64>>>);

impl Heard {
    /// Those of half the response or more; where there is none, all.
    pub fn of<'a>(bands: impl Iterator<Item = &'a DelayBand>) -> Self {
        let heard: Vec<Range<f64>> = bands
            .filter(|band| band.gain.value() >= HEARD)
            .map(|band| 1.0 / band.longest_s..1.0 / band.shortest_s)
            .collect();
        Self((!heard.is_empty()).then_some(heard))
    }

    /// The density of noise for weights: infinite elsewhere.
    fn density(&self, noise: &Noise, f: f64) -> f64 {
        let within = self.0.as_ref().is_none_or(|bands| bands.iter().any(|band| band.contains(&f)));
        if within { noise.density(f) } else { f64::INFINITY }
    }
}

/// One axis with the reference moved aside, where it is, and to the other side. What it shows is made anew
/// for each question: it is many times as large as the readings.
pub struct OfAxis<'a> {
    pub pairs: &'a [Pair; 3],
    pub look: &'a Look,
    pub axis: usize,
    pub aside_s: f64,
}

/// What one axis says of a delay.
pub struct Seen {
    /// Coefficient of −dB/dt, and by how much it follows the reference.
    pub late: Offset,
    pub follows: f64,
    gain: Offset,
    /// What the columns leave.
    left: Vec<f64>,
}

/// One axis over some rows, its ends tapered; the reference before, where it is, and after.
struct Tapered {
    /// Of −dB/dt, the field and what the test instrument reads beside it.
    transforms: [[Transform; 3]; 3],
    /// −dB/dt and the field where the reference is, and what the test instrument reads beside it.
    columns: [Vec<f64>; 2],
    left: Vec<f64>,
    /// How many times as wide as without a taper uncertainties are.
    wider: f64,
    aside_s: f64,
    step_s: f64,
}

impl Tapered {
    fn seen(&self, density: &(dyn Fn(f64) -> f64 + Sync)) -> Result<Seen, Error> {
        let weights = self.transforms[1][2].weights(self.step_s, density);
        let fit = |at: usize| {
            let [late, turned, left] = &self.transforms[at];
            weighted(&[late, turned], left, &weights)
        };
        let (before, (here, after)) = rayon::join(|| fit(0), || rayon::join(|| fit(1), || fit(2)));
        let (before, here, after) = (before?, here?, after?);
        let follows = (before.coefficients[0] - after.coefficients[0]) / (2.0 * self.aside_s);
        let of = |i: usize| self.wider * here.covariance[(i, i)].sqrt();
        Ok(Seen {
            late: Offset { s: here.coefficients[0], std: of(0) },
            follows,
            gain: Offset { s: 1.0 + here.coefficients[1], std: of(1) },
            left: rest(&self.columns, &self.left, &here.coefficients),
        })
    }
}

/// What an axis says in one octave of period.
pub struct OfBand {
    /// None where none is seen.
    pub delay: Option<Offset>,
    pub gain: Offset,
}

impl OfAxis<'_> {
    fn noise(&self) -> &Noise {
        &self.look.axes[self.axis].noise
    }

    fn step_s(&self) -> f64 {
        self.pairs[1].step_s
    }

    fn parts(&self, at: usize) -> [Vec<f64>; 3] {
        self.look.parts(&self.pairs[at], self.axis)
    }

    fn all(&self) -> Tapered {
        let rows = 0..self.pairs[1].whole.len();
        self.tapered(&rows, |at| self.parts(at))
    }

    /// Some rows, of which `cut` gives −dB/dt, the field and what is left at each place of the reference.
    fn tapered(&self, rows: &Range<usize>, cut: impl Fn(usize) -> [Vec<f64>; 3]) -> Tapered {
        let (taper, wider) = taper(rows.len());
        let mut here = <[Vec<f64>; 3]>::default();
        // One after the other, and of the series only those where the reference is are kept.
        let transforms = std::array::from_fn(|at| {
            let mut series = cut(at).map(|values| centred(&values));
            series.iter_mut().for_each(|of| of.iter_mut().zip(&taper).for_each(|(value, w)| *value *= w));
            let transforms = series.each_ref().map(|values| Transform::of(values));
            if at == 1 {
                here = series;
            }
            transforms
        });
        let [late, turned, left] = here;
        let (aside_s, step_s) = (self.aside_s, self.step_s());
        Tapered { transforms, columns: [late, turned], left, wider, aside_s, step_s }
    }

    /// What is left of the offset over all rows.
    pub fn whole(&self, heard: &Heard) -> Result<Seen, Error> {
        self.all().seen(&|f| heard.density(self.noise(), f))
    }

    /// What is left of the offset in each of some parts of the rows, under their own noise: a disturbed part
    /// knows less.
    pub fn in_parts(&self, parts: &[Range<usize>], heard: &Heard) -> Result<Vec<Option<Offset>>, Error> {
        let whole: [[Vec<f64>; 3]; 3] = std::array::from_fn(|at| self.parts(at));
        let of_part = |rows: &Range<usize>| {
            let cut = |at: usize| whole[at].each_ref().map(|values| values[rows.clone()].to_vec());
            let tapered = self.tapered(rows, cut);
            let first = tapered.seen(&|f| heard.density(self.noise(), f))?;
            let noise = Noise::seen(&first.left, &self.pairs[1].part(rows.clone()))?;
            Ok(tapered.seen(&|f| heard.density(&noise, f))?.delay(1.0))
        };
        parts.iter().map(of_part).collect()
    }

    /// What is left of the offset, and the gain, in each of some bands of frequency, and the spectrum of the
    /// field along the axis.
    pub fn bands(&self, octaves: &[Range<f64>]) -> Result<(Vec<OfBand>, Spectrum), Error> {
        let pair = &self.pairs[1];
        let rows = pair.whole.len();
        let field = welch(&self.look.turned(pair, self.axis), self.step_s(), (rows / 4).max(16))?;
        let share = pair.samples() as f64 / rows as f64;
        let tapered = self.all();
        let of_band = |within: &Range<f64>| {
            let density = |f: f64| if within.contains(&f) { self.noise().density(f) } else { f64::INFINITY };
            let seen = tapered.seen(&density)?;
            let ratios: Vec<f64> = periodogram(&seen.left, self.step_s())?
                .bins
                .iter()
                .filter(|bin| within.contains(&bin.frequency_hz))
                .map(|bin| bin.density / (share * self.noise().density(bin.frequency_hz)))
                .collect();
            let wider = (ratios.iter().sum::<f64>() / ratios.len().max(1) as f64).max(1.0).sqrt();
            let gain = Offset { s: seen.gain.s, std: wider * seen.gain.std };
            Ok(OfBand { delay: seen.delay(wider), gain })
        };
        Ok((octaves.par_iter().map(of_band).collect::<Result<_, Error>>()?, field))
    }
}

impl Seen {
    /// The delay and its uncertainty; None where none is seen.
    pub fn delay(&self, wider: f64) -> Option<Offset> {
        let of = Offset { s: self.late.s / self.follows, std: wider * self.late.std / self.follows };
        (self.follows > FOLLOWS && of.s.is_finite() && of.std.is_finite()).then_some(of)
    }
}

/// A taper of mean square one, and how many times as wide as without it uncertainties are.
fn taper(rows: usize) -> (Vec<f64>, f64) {
    let reach = (TAPERED * rows as f64).max(1.0);
    let of = |row: usize| {
        let end = (row.min(rows - 1 - row) as f64 + 0.5) / reach;
        if end < 1.0 { (0.5 * std::f64::consts::PI * end).sin().powi(2) } else { 1.0 }
    };
    let mut weights: Vec<f64> = (0..rows).map(of).collect();
    let power = |n: i32| weights.iter().map(|w| w.powi(n)).sum::<f64>() / rows as f64;
    let (squares, fourths) = (power(2), power(4));
    weights.iter_mut().for_each(|w| *w /= squares.sqrt());
    (weights, (fourths / squares.powi(2)).sqrt())
}
