//! Local level of a periodogram, by medians, and how improbable an ordinate is.

use std::f64::consts::LN_2;
use std::ops::Range;

use faer::Mat;

use crate::Svd;

/// Fewest ordinates of a block.
const LEAST_BLOCK: usize = 10;
/// Last ordinate over the first of a longer block.
const BLOCK_RATIO: f64 = 1.3;
/// A block of fewer ordinates is steep; its level is found again about its own slope.
const STEEP_BLOCK: usize = 100;
/// Rounds of that.
const ROUNDS: usize = 2;
/// The level bends by about so much: d² ln P/d(ln f)². A corner of white noise with f^-α has α²/4.
const BEND: f64 = 0.5;
/// Singular values below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-12;
/// Relative standard deviation of the median of m exponential variables, times √m.
const MEDIAN_STD: f64 = 1.0 / LN_2;
/// Neighbours on either side to which an ordinate is compared: a fifth of its own number, within these.
const NEIGHBOURS: Range<usize> = 24..200;
/// Neighbours so near are left out: what is between two ordinates shows in both.
const TOO_NEAR: usize = 2;
/// Fewer neighbours say nothing.
const LEAST_NEIGHBOURS: usize = 10;

/// Expected power: straight lines in ln power over ln k between smoothed medians of blocks.
pub(super) struct Level {
    blocks: Vec<Range<usize>>,
    /// ln k and ln power.
    nodes: Vec<(f64, f64)>,
}

impl Level {
    /// The level of powers |X_k|², k = 0, 1, …; the one at zero and those left out are not seen.
    pub fn of(power: &[f64], left_out: &[bool]) -> Self {
        let kept = |block: &Range<usize>| block.clone().filter(|k| !left_out[*k]);
        let blocks = blocks(power.len());
        let seen: Vec<(&Range<usize>, f64)> = blocks
            .iter()
            .map(|block| (block, kept(block).count() as f64))
            .filter(|(_, count)| *count >= 0.5 * LEAST_BLOCK as f64)
            .collect();
        let mut level = Level { blocks: blocks.clone(), nodes: Vec::new() };
        let mut buffer = Vec::new();
        let mut ln_level = |block: &Range<usize>, level: &dyn Fn(usize) -> f64| {
            buffer.clear();
            buffer.extend(kept(block).map(|k| power[k] / level(k)));
            let (median, expected) = median(&mut buffer);
            (median / expected).max(f64::MIN_POSITIVE).ln()
        };
        let middle = |block: &Range<usize>| 0.5 * ((block.start as f64).ln() + (block.end as f64).ln());
        let mut medians: Vec<(f64, f64)> =
            seen.iter().map(|(block, _)| (middle(block), ln_level(block, &|_| 1.0))).collect();
        let std: Vec<f64> = seen.iter().map(|(_, count)| MEDIAN_STD / count.sqrt()).collect();
        level.nodes = smoothed(&medians, &std);
        for _ in 0..ROUNDS {
            for ((block, _), median) in seen.iter().zip(&mut medians) {
                if block.len() < STEEP_BLOCK {
                    median.1 = level.at_ln(median.0) + ln_level(block, &|k| level.at(k));
                }
            }
            level.nodes = smoothed(&medians, &std);
        }
        level
    }

    /// Expected power at ordinate `k` ≥ 1.
    pub fn at(&self, k: usize) -> f64 {
        self.at_ln((k as f64).ln()).exp()
    }

    /// Its logarithm, at ln k.
    fn at_ln(&self, x: f64) -> f64 {
        match self.nodes.as_slice() {
            [] => 0.0,
            [only] => only.1,
            nodes => {
                let right = nodes.partition_point(|node| node.0 < x).clamp(1, nodes.len() - 1);
                let ((x0, y0), (x1, y1)) = (nodes[right - 1], nodes[right]);
                y0 + (y1 - y0) * (x - x0) / (x1 - x0)
            }
        }
    }

    /// Ordinates from `first` on that are above `factor` times the level, the highest above it first.
    pub fn above(&self, power: &[f64], left_out: &[bool], first: usize, factor: f64) -> Vec<usize> {
        let mut found = Vec::new();
        for block in &self.blocks {
            // The level is monotone from the middle node to either end: it is lowest at one of these.
            let middle = ((block.start * block.end) as f64).sqrt() as usize;
            let ends = [block.start, middle, middle + 1, block.end - 1];
            let least = ends.iter().map(|k| self.at(*k)).fold(f64::INFINITY, f64::min) * factor;
            let high = block.clone().filter(|&k| power[k] > least && k >= first && !left_out[k]);
            found.extend(high.map(|k| (k, power[k] / self.at(k))).filter(|(_, ratio)| *ratio > factor));
        }
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.into_iter().map(|(k, _)| k).collect()
    }

    /// ln of the probability that noise alone brings ordinate `k` as high above the median of its neighbours.
    ///
    /// For independent exponential variables of equal mean, M neighbours and the one compared to them, the
    /// chance of a ratio above r to the m-th smallest neighbour is Π (M − i + 1)/(M − i + 1 + r), i = 1 … m:
    /// the scatter of the median is in it. The slope of the level is divided out first.
    ///
    /// Source: A. Rényi, On the theory of order statistics, Acta Math. Acad. Sci. Hung. 4 (1953) 191–231: the
    /// m-th smallest of M is Σ E_i/(M − i + 1) with E_i exponential and independent.
    pub fn ln_p(&self, power: &[f64], left_out: &[bool], k: usize) -> f64 {
        let side = (k / 5).clamp(NEIGHBOURS.start, NEIGHBOURS.end);
        let window = k.saturating_sub(side).max(1)..(k + side + 1).min(power.len());
        let near = |j: usize| j.abs_diff(k) <= TOO_NEAR;
        let mut ratios: Vec<f64> =
            window.filter(|&j| !near(j) && !left_out[j]).map(|j| power[j] / self.at(j)).collect();
        let count = ratios.len();
        if count < LEAST_NEIGHBOURS {
            return 0.0;
        }
        let ratio = power[k] / self.at(k) / median(&mut ratios).0;
        -(0..count.div_ceil(2)).map(|i| (ratio / (count - i) as f64).ln_1p()).sum::<f64>()
    }
}

/// Blocks of ordinates 1 … `end` − 1.
fn blocks(end: usize) -> Vec<Range<usize>> {
    let mut blocks = Vec::new();
    let mut from = 1;
    while from < end {
        let mut to = (from + LEAST_BLOCK).max((BLOCK_RATIO * from as f64) as usize);
        if to + LEAST_BLOCK > end {
            to = end;
        }
        blocks.push(from..to);
        from = to;
    }
    blocks
}

/// The points of least squares that are near to the given ones and bend little: over three neighbours 2 Δ
/// apart the second derivative has the standard deviation BEND/√Δ, whatever the spacing.
fn smoothed(points: &[(f64, f64)], std: &[f64]) -> Vec<(f64, f64)> {
    let n = points.len();
    if n < 3 {
        return points.to_vec();
    }
    let x = |i: usize| points[i].0;
    let mut design = Mat::zeros(2 * n - 2, n);
    let mut right = vec![0.0; 2 * n - 2];
    for i in 0..n {
        (design[(i, i)], right[i]) = (1.0 / std[i], points[i].1 / std[i]);
    }
    for i in 1..n - 1 {
        let (left, after, half) = (x(i) - x(i - 1), x(i + 1) - x(i), 0.5 * (x(i + 1) - x(i - 1)));
        let weight = half.sqrt() / (BEND * half);
        design[(n + i - 1, i - 1)] = weight / left;
        design[(n + i - 1, i)] = -weight * (1.0 / left + 1.0 / after);
        design[(n + i - 1, i + 1)] = weight / after;
    }
    match Svd::of(design.as_ref(), RANK_TOLERANCE) {
        Ok(svd) => points.iter().zip(svd.solve(&right)).map(|(point, y)| (point.0, y)).collect(),
        Err(_) => points.to_vec(),
    }
}

/// The (lower) middle one, and its expectation for exponential variables of mean one; reorders.
fn median(values: &mut [f64]) -> (f64, f64) {
    let middle = values.len().div_ceil(2);
    let expected = (0..middle).map(|i| 1.0 / (values.len() - i) as f64).sum();
    (*values.select_nth_unstable_by(middle - 1, f64::total_cmp).1, expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_has_its_level() {
        // Ordinates at the median of the law, so that the level is the power law itself.
        for exponent in [0.0, 1.0, 2.0] {
            let power: Vec<f64> =
                (0..2000).map(|k| 5.0 * LN_2 * f64::from(k.max(1)).powf(-exponent)).collect();
            let level = Level::of(&power, &vec![false; 2000]);
            for k in [1_u32, 7, 30, 400, 1999] {
                let ratio = level.at(k as usize) / (5.0 * f64::from(k).powf(-exponent));
                assert!((ratio - 1.0).abs() < 0.12, "{exponent}, {k}: {ratio}");
            }
        }
    }

    #[test]
    fn blocks_hold_every_ordinate_once() {
        for end in [2, 15, 45, 61, 5000] {
            let joined: Vec<usize> = blocks(end).into_iter().flatten().collect();
            assert_eq!(joined, (1..end).collect::<Vec<_>>());
        }
    }
}
