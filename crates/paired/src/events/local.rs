//! The noise around a row against the noise of the whole series.

use estimate::stats::median_of;

/// Rows on one side of a row whose noise is that of the row, and the rows from one such window to the next.
const WINDOW: usize = 128;
const STRIDE: usize = 16;
/// What is farther than the first and nearer than the second tells how wide the scores of steps are spread: a
/// step at a row is in the scores of the rows around it.
const OWN: usize = 256;
const FAR: usize = 1024;
/// Of these every so many rows count, for blocks of so many rows.
const SPARSE: usize = 4;
const BLOCK: usize = 64;
/// Fewer ratios than these tell nothing.
const LEAST: usize = 64;
/// The least spread: series of which nearly all differences are zero.
const NONE: f64 = 1e-3;
/// Median, and the size that a twentieth exceeds, of |z| for a standard normal z.
const MEDIAN_ABSOLUTE_NORMAL: f64 = 0.674_489_75;
const TWENTIETH_NORMAL: f64 = 1.959_964;

/// The standard deviation of which absolute values speak: by their median, or by what a twentieth exceeds
/// where that is more.
pub fn spread(sizes: &mut [f64]) -> f64 {
    let middle = median_of(sizes) / MEDIAN_ABSOLUTE_NORMAL;
    let at = (sizes.len() * 19) / 20;
    // Their median is in its place: what a twentieth exceeds is not before it.
    let above = sizes.len() / 2;
    let (_, high, _) = sizes[above..].select_nth_unstable_by(at - above, f64::total_cmp);
    middle.max(*high / TWENTIETH_NORMAL)
}

/// How wide ratios of sizes and uncertainties are spread around each row: the larger of what the rows before
/// and those after it say, so that noise that rises suddenly counts from its first row on. Rows that are out,
/// and those without a ratio (0), do not count.
pub struct Near {
    all: f64,
    /// Of the windows that begin at every so many rows.
    windows: Vec<Option<f64>>,
}

impl Near {
    pub fn of(ratios: &[f64], out: &[bool]) -> Self {
        let rows = ratios.len();
        let known = RatioSizes::of(ratios, out, 1);
        let mut sizes = Vec::new();
        let mut of = |from: usize, to: usize| {
            sizes.clear();
            sizes.extend_from_slice(known.between(from, to));
            (sizes.len() >= LEAST).then(|| spread(&mut sizes))
        };
        let starts = (0..rows.div_ceil(STRIDE)).map(|at| at * STRIDE);
        let windows = starts.map(|from| of(from, (from + WINDOW).min(rows))).collect();
        Self { windows, all: of(0, rows).unwrap_or(1.0).max(NONE) }
    }

    pub fn at(&self, row: usize) -> f64 {
        let after = self.windows[row.div_ceil(STRIDE).min(self.windows.len() - 1)];
        let before = row.checked_sub(WINDOW).and_then(|from| self.windows[from / STRIDE]);
        before.into_iter().chain(after).reduce(f64::max).unwrap_or(self.all).max(NONE)
    }
}

/// The same of what is a few hundred rows away on both sides.
pub struct Far {
    blocks: Vec<f64>,
}

impl Far {
    pub fn of(ratios: &[f64], out: &[bool]) -> Self {
        let rows = ratios.len();
        let mut all = RatioSizes::of(ratios, out, 1).sizes;
        let all = if all.len() >= LEAST { spread(&mut all).max(NONE) } else { 1.0 };
        let known = RatioSizes::of(ratios, out, SPARSE);
        let mut sizes = Vec::new();
        let mut of = |row: usize| {
            sizes.clear();
            sizes.extend_from_slice(known.between(row.saturating_sub(FAR), row.saturating_sub(OWN)));
            sizes.extend_from_slice(known.between((row + OWN).min(rows), (row + FAR).min(rows)));
            if sizes.len() < LEAST { all } else { (median_of(&mut sizes) / MEDIAN_ABSOLUTE_NORMAL).max(NONE) }
        };
        Self { blocks: (0..rows.div_ceil(BLOCK)).map(|at| of(BLOCK * at)).collect() }
    }

    pub fn at(&self, row: usize) -> f64 {
        self.blocks[row / BLOCK]
    }
}

/// The sizes of ratios in every `stride`th row that is not out and has one.
struct RatioSizes {
    stride: usize,
    sizes: Vec<f64>,
    /// How many are before each of these rows, and how many there are.
    before: Vec<usize>,
}

impl RatioSizes {
    fn of(ratios: &[f64], out: &[bool], stride: usize) -> Self {
        let (mut sizes, mut before) = (Vec::new(), vec![0]);
        for (ratio, out) in ratios.iter().zip(out).step_by(stride) {
            if !out && *ratio != 0.0 {
                sizes.push(ratio.abs());
            }
            before.push(sizes.len());
        }
        Self { stride, sizes, before }
    }

    fn between(&self, from: usize, to: usize) -> &[f64] {
        let [from, to] = [from, to].map(|row| self.before[row.div_ceil(self.stride)]);
        &self.sizes[from..to.max(from)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratios() -> Vec<f64> {
        let mut stream = noise::Stream::new(7, "ratios");
        (0..4000).map(|row| stream.normal() * if (1000..1400).contains(&row) { 8.0 } else { 1.0 }).collect()
    }

    #[test]
    fn noise_that_rises_counts_from_its_first_row() {
        let near = Near::of(&ratios(), &[false; 4000]);
        assert!(near.at(1000) > 5.0 && near.at(1200) > 6.0 && near.at(1399) > 5.0);
        assert!((0.7..1.6).contains(&near.at(500)) && (0.7..1.6).contains(&near.at(3000)));
    }

    #[test]
    fn what_is_far_does_not_know_of_the_row() {
        let mut ratios = ratios();
        ratios[2800..3200].iter_mut().for_each(|z| *z += 50.0);
        assert!((0.8..1.3).contains(&Far::of(&ratios, &[false; 4000]).at(3000)));
    }
}
