//! Clocks that differ by many samples: what such a difference adds is not in proportion to the field's slope.

use estimate::{Error as Estimate, lag, stats};
use joined::Pair;

use super::{Look, Shift};
use crate::Error;
use crate::noise::Noise;
use crate::residual::scatter;

/// Largest offset that is searched, as a share of the recording's length.
const REACH: f64 = 0.1;
/// Changes from row to row that are so many times their median count as much: a spike of one instrument has
/// no lag.
const LARGEST_CHANGE: f64 = 8.0;
/// Least gain in χ² of a lag over none.
const GAIN: f64 = 50.0;
/// Largest ratio of the variances after and before.
const MORE: f64 = 1.1;
/// The fastest rate that is tried at once, s/s.
const FASTEST: f64 = 1e-3;
/// Blocks in which the offset of a clock with a rate is taken to stay; a rate by which it changes by fewer samples than
/// the least of them needs no search.
const BLOCKS: usize = 16;
const LEAST_BLOCKS: usize = 4;
/// Offsets and rates tried to either side.
const TRIED: usize = 128;

/// The readings in which a lag is looked for.
struct Limited {
    reference: [Vec<f64>; 3],
    test: Vec<(Vec<f64>, Noise)>,
    step_s: f64,
}

impl Limited {
    fn of(look: &Look, pair: &Pair) -> Result<Self, Error> {
        // One limit for all: a change of the field that is cut at another height in the other instrument
        // would seem to come at another time.
        let columns = pair.reference.iter().chain(&pair.test);
        let most = columns.map(|column| usual(column, &pair.whole)).fold(0.0, f64::max);
        let reference = pair.reference.each_ref().map(|column| limited(column, &pair.whole, most));
        // A sudden change at the wrong time would be most of the noise.
        let axes = pair.test.iter().zip(limited_left(look, pair, &pair.whole));
        let axes = axes.map(|(test, left)| -> Result<_, Error> {
            Ok((limited(test, &pair.whole, most), Noise::seen(&left, pair)?))
        });
        let test = axes.collect::<Result<_, _>>()?;
        Ok(Self { reference, test, step_s: pair.step_s })
    }

    /// How much the reference explains of all axes in some rows when it is later by −reach to reach samples; nothing
    /// where it does not change.
    fn explained(&self, rows: std::ops::Range<usize>, reach: usize) -> Result<Vec<f64>, Error> {
        let mut gains = vec![0.0; 2 * reach + 1];
        let reference = self.reference.each_ref().map(|column| column[rows.clone()].to_vec());
        for (test, noise) in &self.test {
            let density = |f: f64| noise.density(f);
            match lag::explained(&reference, &test[rows.clone()], self.step_s, &density, reach) {
                Ok(of_axis) => gains.iter_mut().zip(of_axis).for_each(|(sum, gain)| *sum += gain),
                Err(Estimate::Decomposition { .. }) => {}
                Err(other) => return Err(other.into()),
            }
        }
        Ok(gains)
    }
}

impl Look {
    /// Whether another fit leaves less of the same rows moved in time: far less in χ² under this fit's noise, in which what
    /// is slow does not count, and hardly more in all. Here only what is left is limited: a sudden change of the field
    /// that was limited in both instruments may seem to lag where it does not.
    pub fn is_beaten(&self, pair: &Pair, moved: &Look, moved_pair: &Pair) -> Result<bool, Error> {
        let whole: Vec<bool> = pair.whole.iter().zip(&moved_pair.whole).map(|(a, b)| *a && *b).collect();
        let (mut gain, mut before, mut after) = (0.0, 0.0, 0.0);
        let here = limited_left(self, pair, &whole);
        for (here, there) in here.into_iter().zip(limited_left(moved, moved_pair, &whole)) {
            before += scatter(&here, &whole).powi(2);
            after += scatter(&there, &whole).powi(2);
            let noise = Noise::seen(&here, pair)?;
            let [here, there] = [here, there].map(|left| {
                // It explains all of itself.
                lag::explained(std::slice::from_ref(&left), &left, pair.step_s, &|f| noise.density(f), 0)
            });
            gain += here?[0] - there?[0];
        }
        Ok(gain > GAIN && after <= MORE * before)
    }

    /// Candidates with which the two instruments' changes match far better: the most likely offset of at least one sample,
    /// and the most likely offset with a rate.
    pub fn coarse(&self, pair: &Pair) -> Result<Vec<Shift>, Error> {
        let limited = Limited::of(self, pair)?;
        let rows = pair.whole.len();
        let reach = (REACH * rows as f64) as usize;
        let gains = limited.explained(0..rows, reach)?;
        let best =
            (0..gains.len()).fold(reach, |best, lag| if gains[lag] > gains[best] { lag } else { best });
        let offset_s = (best as f64 - reach as f64) * pair.step_s;
        let offset = (gains[best] - gains[reach] > GAIN).then_some(Shift { offset_s, rate: 0.0 });
        Ok(offset.into_iter().chain(with_rate(&limited, pair)?).collect())
    }
}

/// The same with a rate: the sum of what the offsets that follow from it explain of each block.
fn with_rate(limited: &Limited, pair: &Pair) -> Result<Option<Shift>, Error> {
    let rows = pair.whole.len();
    // Samples by which the offset changes from the first row to the last.
    let most = (FASTEST * rows as f64) as usize;
    let blocks = most.min(BLOCKS);
    if blocks < LEAST_BLOCKS {
        return Ok(None);
    }
    let reach = 2 * most;
    let of_block = |block: usize| -> Result<(f64, Vec<f64>), Error> {
        let (from, to) = (block * rows / blocks, (block + 1) * rows / blocks);
        let from_middle = pair.since_middle_of_segment_s((from + to) / 2) / pair.step_s;
        Ok((from_middle / rows as f64, limited.explained(from..to, reach)?))
    };
    let blocks: Vec<(f64, Vec<f64>)> = (0..blocks).map(of_block).collect::<Result<_, _>>()?;
    let explained = |offset: i64, change: i64| -> f64 {
        let at = |from_middle: f64| reach as i64 + offset + (from_middle * change as f64).round() as i64;
        blocks.iter().map(|(from_middle, gains)| gains[at(*from_middle) as usize]).sum()
    };
    let tried = || (-(most as i64)..=most as i64).step_by(most.div_ceil(TRIED));
    let none = explained(0, 0);
    let best = tried()
        .flat_map(|change| tried().map(move |offset| (offset, change)))
        .map(|(offset, change)| (explained(offset, change) - none, offset, change))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let found = best.filter(|(gain, ..)| *gain > GAIN).map(|(_, offset, change)| Shift {
        offset_s: offset as f64 * pair.step_s,
        rate: change as f64 / rows as f64,
    });
    Ok(found)
}

/// What is left of each axis, limited.
fn limited_left(look: &Look, pair: &Pair, whole: &[bool]) -> Vec<Vec<f64>> {
    let limited = |left: Vec<f64>| limited(&left, whole, usual(&left, whole));
    look.left(pair, pair).into_iter().map(limited).collect()
}

/// How much a series may change from row to row and be taken as it is.
fn usual(values: &[f64], whole: &[bool]) -> f64 {
    let known = (1..values.len()).filter(|row| whole[row - 1] && whole[*row]);
    LARGEST_CHANGE
        * stats::median(&known.map(|row| (values[row] - values[row - 1]).abs()).collect::<Vec<_>>())
}

/// A series whose changes are limited: spikes and steps are still in it when a lag is looked for. Beside rows
/// that are not whole it does not change.
fn limited(values: &[f64], whole: &[bool], most: f64) -> Vec<f64> {
    if most == 0.0 {
        return values.to_vec();
    }
    let mut level = 0.0;
    let sums = (1..values.len()).map(|row| {
        if whole[row - 1] && whole[row] {
            level += (values[row] - values[row - 1]).clamp(-most, most);
        }
        level
    });
    std::iter::once(0.0).chain(sums).collect()
}
