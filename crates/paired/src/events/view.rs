//! The differences through their matched filters, each row against the noise around it.

use estimate::events::{Search, Shape};
use estimate::positive::Positive;
use faer::Mat;

use super::local::{Far, Near};
use crate::noise::Noise;
use crate::{Error, axes};

/// Where the differences exceed a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    pub shape: Shape,
    pub row: usize,
    /// Size over the uncertainty under the noise of the whole series: shapes and rows are compared by it.
    pub z: f64,
}

/// The filters of the differences.
pub struct View {
    searches: Vec<Search>,
    wider: Vec<Wider>,
}

/// How wide the ratios of a difference are spread around each row.
struct Wider {
    near: Near,
    far: Far,
}

impl Wider {
    fn of(search: &Search, out: &[bool]) -> Self {
        let ratios = |shape| -> Vec<f64> { (0..search.rows()).map(|row| search.ratio(shape, row)).collect() };
        Self { near: Near::of(&ratios(Shape::Spike), out), far: Far::of(&ratios(Shape::Step), out) }
    }

    fn at(&self, shape: Shape, row: usize) -> f64 {
        let near = self.near.at(row);
        if shape == Shape::Step { near.max(self.far.at(row)) } else { near }
    }
}

impl View {
    /// Of differences under these noises; rows that are out say nothing of the noise around them.
    pub fn of(series: &[Vec<f64>], step_s: f64, noise: &[Noise], out: &[bool]) -> Result<Self, Error> {
        Self::with(series.len(), out, |axis| Search::new(&series[axis], step_s, &|f| noise[axis].density(f)))
    }

    /// Of other differences under the same noises.
    pub fn again(&self, series: &[Vec<f64>], out: &[bool]) -> Result<Self, Error> {
        Self::with(series.len(), out, |axis| self.searches[axis].again(&series[axis]))
    }

    fn with(
        count: usize,
        out: &[bool],
        search: impl Fn(usize) -> Result<Search, estimate::Error> + Sync + Send,
    ) -> Result<Self, Error> {
        let found = axes::try_each(count, |axis| {
            let search = search(axis)?;
            let wider = Wider::of(&search, out);
            Ok::<_, estimate::Error>((search, wider))
        })?;
        let (searches, wider) = found.into_iter().unzip();
        Ok(Self { searches, wider })
    }

    /// Rows, and shapes, in which a difference exceeds `least` of its uncertainties under the noise around
    /// it; the larger one of a row and its axes.
    pub fn peaks(&self, least: f64) -> Vec<Peak> {
        let rows = self.searches[0].rows();
        let mut peaks = Vec::new();
        for row in 0..rows {
            let mut peak = Peak { shape: Shape::Step, row, z: 0.0 };
            for (search, wider) in self.searches.iter().zip(&self.wider) {
                for shape in [Shape::Step, Shape::Spike] {
                    let z = search.ratio(shape, row).abs();
                    if z > peak.z && z >= least * wider.at(shape, row) {
                        peak = Peak { shape, z, ..peak };
                    }
                }
            }
            if peak.z > 0.0 {
                peaks.push(peak);
            }
        }
        peaks
    }

    /// Sizes of a shape at a row and their uncertainties under the noise around it.
    pub fn sizes_at(&self, shape: Shape, row: usize) -> Vec<(f64, f64)> {
        let of = |(search, wider): (&Search, &Wider)| {
            let (size, std) = search.size(shape, row);
            (size, std * wider.at(shape, row))
        };
        self.searches.iter().zip(&self.wider).map(of).collect()
    }

    /// What each of some steps (rows, and parts in the differences) is to grow by, all together, and its standard
    /// uncertainty; None where they cannot be told apart.
    pub fn sizes(&self, steps: &[(usize, Vec<f64>)]) -> Option<Vec<(f64, f64)>> {
        let count = steps.len();
        let product = |i: usize, j: usize| -> f64 {
            let ((a, a_parts), (b, b_parts)) = (&steps[i], &steps[j]);
            let parts = a_parts.iter().zip(b_parts).zip(&self.searches);
            parts.map(|((a_part, b_part), search)| a_part * b_part * search.products(*a, *b)).sum()
        };
        let inverse = Positive::of(&Mat::from_fn(count, count, product)).ok()?.inverse;
        let along = |(row, parts): &(usize, Vec<f64>)| -> f64 {
            let parts = parts.iter().zip(&self.searches);
            parts.map(|(part, search)| part * search.score(Shape::Step, *row)).sum()
        };
        let along: Vec<f64> = steps.iter().map(along).collect();
        let size = |i: usize| -> f64 { (0..count).map(|j| inverse[(i, j)] * along[j]).sum() };
        let wider = |(row, parts): &(usize, Vec<f64>)| {
            let shown = parts.iter().zip(&self.wider).filter(|(part, _)| **part != 0.0);
            shown.map(|(_, wider)| wider.at(Shape::Step, *row)).fold(0.0, f64::max)
        };
        Some((0..count).map(|i| (size(i), inverse[(i, i)].sqrt() * wider(&steps[i]))).collect())
    }
}
