//! Steps and single readings that are off, in what the best set leaves.
//!
//! C⁻¹ e of a residual e, one pass back over the rows, holds the score of every single reading; its sums from
//! the end hold those of every step.
//!
//! Source: P. de Jong and J. Penzer, Diagnosing shocks in time series, J. Am. Stat. Assoc. 93 (1998) 796–806.

use estimate::{Error, stats};
use faer::Mat;
use noise::Whitening;

use crate::fit::Fit;

/// ln of the odds against an event before the readings are looked at, beside those of the row.
const AGAINST: f64 = 5.0;
/// Rows of a block in which the noise is alike.
const NEAR: usize = 128;
/// What others leave of a step's information, or it cannot be told.
const TELLS: f64 = 1e-3;

/// A residual of one channel, the filter of its noise and the columns that were fitted.
pub struct Left<'a> {
    /// What is left of each row.
    pub residual: &'a [f64],
    /// The columns of the fit.
    pub columns: Vec<&'a [f64]>,
    /// Its noise.
    pub filter: &'a Whitening,
    /// Variance of the whitened residual.
    pub variance: f64,
}

/// Something at one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A level changes from this row on.
    Step(usize),
    /// This reading is off.
    Spike(usize),
}

/// Squares of the scores of a channel, over their variance.
struct Scores {
    spike: Vec<f64>,
    step: Vec<f64>,
}

impl Scores {
    fn of(left: &Left<'_>) -> Result<Self, Error> {
        let rows = left.residual.len();
        let back = |series: &[f64]| left.filter.whiten_transposed(&left.filter.whiten(series));
        let scores = back(left.residual);
        let single: f64 = left.filter.response().iter().map(|value| value * value).sum();
        let spike: Vec<f64> = scores.iter().map(|score| score * score / (single * left.variance)).collect();
        let columns: Vec<Vec<f64>> = left.columns.iter().map(|column| back(column)).collect();
        let gram = Mat::from_fn(columns.len(), columns.len(), |i, j| {
            columns[i].iter().zip(left.columns[j]).map(|(a, b)| a * b).sum()
        });
        let known = Fit::of(&gram, 0, &(0..columns.len()).collect::<Vec<_>>());
        let response = steps(left.filter, rows);
        let (mut sum, mut along) = (0.0, vec![0.0; columns.len()]);
        let mut step = vec![0.0; rows];
        for row in (1..rows).rev() {
            sum += scores[row];
            along.iter_mut().zip(&columns).for_each(|(sum, column)| *sum += column[row]);
            let all = response[rows - row];
            let others: f64 = (0..known.columns.len())
                .flat_map(|i| (0..known.columns.len()).map(move |j| (i, j)))
                .map(|(i, j)| along[known.columns[i]] * known.inverse[(i, j)] * along[known.columns[j]])
                .sum();
            let information = all - others;
            if information > TELLS * all {
                step[row] = sum * sum / (information * left.variance);
            }
        }
        let near = near(&spike);
        let over = |squares: Vec<f64>, whole: f64| -> Vec<f64> {
            squares.iter().zip(&near).map(|(square, near)| square / near.max(whole)).collect()
        };
        let whole = wider(step.get(1..).unwrap_or_default());
        Ok(Self { spike: over(spike, 1.0), step: over(step, whole) })
    }
}

/// How many times as large as of noise of the fitted form squares of scores are, by their median: what a step or
/// a spike is held against is what the same series does elsewhere.
fn wider(squares: &[f64]) -> f64 {
    let mut known: Vec<f64> = squares.iter().copied().filter(|square| *square > 0.0).collect();
    // The median of the square of a normal number.
    if known.is_empty() { 1.0 } else { (stats::median_of(&mut known) / 0.455).max(1.0) }
}

/// The same around each row: in its block of rows and those beside it.
fn near(squares: &[f64]) -> Vec<f64> {
    let blocks: Vec<f64> = squares.chunks(NEAR).map(wider).collect();
    let largest = |block: usize| {
        let beside = block.saturating_sub(1)..(block + 2).min(blocks.len());
        blocks[beside].iter().copied().fold(1.0, f64::max)
    };
    (0..squares.len()).map(|row| largest(row / NEAR)).collect()
}

/// The information of a step by the number of rows after it.
fn steps(filter: &Whitening, rows: usize) -> Vec<f64> {
    let middle = rows / 2;
    let series: Vec<f64> = (0..rows).map(|row| f64::from(u8::from(row >= middle))).collect();
    let white = filter.whiten(&series).split_off(middle);
    let last = white.last().copied().unwrap_or(0.0);
    let mut sum = 0.0;
    let squares = (0..rows).map(|row| {
        sum += white.get(row).copied().unwrap_or(last).powi(2);
        sum
    });
    [0.0].into_iter().chain(squares).collect()
}

/// The clearest step of all channels together, or all readings that are off by themselves where one of these is
/// clearer; nothing where neither is clear.
///
/// # Errors
///
/// Columns that follow from each other.
pub fn clearest(all: &[Left<'_>]) -> Result<Vec<Event>, Error> {
    let scores: Vec<Scores> = all.iter().map(Scores::of).collect::<Result<_, _>>()?;
    let rows = all.first().map_or(0, |left| left.residual.len());
    let worth = |of: &dyn Fn(&Scores) -> f64| worth(scores.iter().map(of), rows);
    let mut best = (0.0, None);
    let mut off = Vec::new();
    for row in 0..rows {
        let step = worth(&|scores| scores.step[row]);
        let spike = worth(&|scores| scores.spike[row]);
        if spike > 0.0 {
            off.push(row);
        }
        for (worth, event) in [(step, Event::Step(row)), (spike, Event::Spike(row))] {
            if worth > best.0 {
                best = (worth, Some(event));
            }
        }
    }
    Ok(match best.1 {
        Some(Event::Spike(_)) => {
            peaks(&off, |row| scores.iter().map(|scores| scores.spike[row]).fold(0.0, f64::max))
        }
        Some(step) => vec![step],
        None => Vec::new(),
    })
}

/// ln of the odds of an event by the squares of its sizes over their uncertainties: ½ ln n for the size in each
/// channel that shows it, ln n for the row, and the choice of channels.
pub fn worth(squares: impl Iterator<Item = f64>, rows: usize) -> f64 {
    let n = rows as f64;
    let net: Vec<f64> = squares.map(|square| 0.5 * (square - n.ln())).collect();
    let shown: f64 = net.iter().filter(|net| **net > 0.0).sum();
    shown - AGAINST - n.ln() - (net.len() as f64).ln()
}

/// Of neighbouring readings the one that is off most: it makes its neighbours look off.
fn peaks(off: &[usize], size: impl Fn(usize) -> f64) -> Vec<Event> {
    let neighbour = |row: usize| off.binary_search(&row).is_ok();
    let peak = |row: &&usize| {
        let beside = [(**row).wrapping_sub(1), **row + 1].into_iter().filter(|other| neighbour(*other));
        beside.map(&size).all(|other| other <= size(**row))
    };
    off.iter().filter(peak).map(|row| Event::Spike(*row)).collect()
}
