//! What is predicted of readings that are left out, in ten contiguous blocks, each from the others: by a fit and its
//! noise, and by what a careful person's fits are, plain least squares.

use estimate::Error;
use estimate::screen::{Column, Screen};
use faer::Mat;
use rayon::prelude::*;

use crate::amplitude::Fitted;
use crate::fit::Fit;
use crate::problem::Problem;
use crate::stack::Stack;

/// Blocks of rows that are left out in turn.
const BLOCKS: usize = 10;

/// Rms of readings that were left out.
#[derive(Clone, Debug)]
pub struct HeldOut {
    /// Of each channel, by plain least squares on the base alone.
    pub base: Vec<f64>,
    /// By the base, the named causes and the most likely noise.
    pub named: Vec<f64>,
    /// By the rivals.
    pub rivals: Vec<Plain>,
}

/// A plain regression.
#[derive(Clone, Debug)]
pub struct Plain {
    /// Its name.
    pub name: &'static str,
    /// Rms of each channel's readings that were left out.
    pub rms: Vec<f64>,
    /// The candidates in it, fitted to all rows.
    pub terms: Vec<usize>,
}

/// Products of the columns in each block.
struct Blocks {
    each: Vec<Mat<f64>>,
    whole: Mat<f64>,
    rows: usize,
}

impl Blocks {
    fn of(stack: &Stack) -> Self {
        let rows = stack.rows();
        let block = |number: usize| {
            let (from, to) = (number * rows / BLOCKS, (number + 1) * rows / BLOCKS);
            let part: Vec<&[f64]> = stack.columns.iter().map(|column| &column[from..to]).collect();
            estimate::gram_of(&part)
        };
        let each: Vec<Mat<f64>> = (0..BLOCKS).into_par_iter().map(block).collect();
        let mut whole = Mat::zeros(stack.columns.len(), stack.columns.len());
        each.iter().for_each(|block| whole += block);
        Self { each, whole, rows }
    }

    /// Rms of what is predicted of a channel in all blocks, each by columns chosen on the others.
    fn rms(&self, stack: &Stack, channel: usize, columns: &Choice<'_>) -> Result<f64, Error> {
        let y = stack.y[channel];
        let mut squares = 0.0;
        for block in &self.each {
            let others = &self.whole - block;
            let fit = Fit::of(&others, y, &columns(channel, &others, self.rows - self.rows / BLOCKS)?);
            // (y − Xβ)ᵀ(y − Xβ) of the block.
            let terms = || fit.columns.iter().zip(&fit.coefficients);
            let along: f64 = terms().map(|(i, b)| b * block[(*i, y)]).sum();
            let pairs = terms().flat_map(|(i, a)| terms().map(move |(j, b)| a * b * block[(*i, *j)]));
            let own: f64 = pairs.sum();
            squares += block[(y, y)] - 2.0 * along + own;
        }
        Ok((squares.max(0.0) / self.rows.max(1) as f64).sqrt() * stack.scale[y])
    }
}

/// The columns that a regression of a channel chooses from the products of so many rows.
type Choice<'a> = dyn Fn(usize, &Mat<f64>, usize) -> Result<Vec<usize>, Error> + 'a;

/// Of the candidates of a stack, beside what the names predict.
pub fn held_out(stack: &Stack, named: Vec<f64>) -> Result<HeldOut, Error> {
    let blocks = Blocks::of(stack);
    let channels = 0..stack.y.len();
    let of = |channel: usize, candidates: &[usize]| -> Vec<usize> {
        let own = candidates.iter().flat_map(|one| stack.candidates[*one].columns[channel].clone());
        stack.plain.iter().copied().chain(own).collect()
    };
    let rms = |columns: &Choice<'_>| -> Result<Vec<f64>, Error> {
        channels.clone().map(|channel| blocks.rms(stack, channel, columns)).collect()
    };
    let plain = |candidate: &usize| {
        let form = stack.candidates[*candidate].form;
        !stack.candidates[*candidate].tied && form == crate::form::Form::default()
    };
    let straight: Vec<usize> = (0..stack.candidates.len()).filter(plain).collect();
    let chosen = |channel: usize, gram: &Mat<f64>, rows: usize| stepwise(stack, gram, rows, channel);
    let mut terms = Vec::new();
    for channel in channels.clone() {
        terms.extend(chosen(channel, &blocks.whole, blocks.rows)?);
    }
    terms.sort_unstable();
    terms.dedup();
    let rivals = vec![
        Plain {
            name: "stepwise regression",
            rms: rms(&|channel, gram, rows| Ok(of(channel, &chosen(channel, gram, rows)?)))?,
            terms,
        },
        Plain {
            name: "least squares with every column",
            rms: rms(&|channel, _, _| Ok(of(channel, &straight)))?,
            terms: straight.clone(),
        },
    ];
    Ok(HeldOut { base: rms(&|_, _, _| Ok(stack.plain.clone()))?, named, rivals })
}

/// The candidates that a stepwise regression of a channel chooses.
fn stepwise(stack: &Stack, gram: &Mat<f64>, rows: usize, channel: usize) -> Result<Vec<usize>, Error> {
    let y = stack.y[channel];
    let mut screen = Screen::empty(gram[(y, y)], rows, 0);
    for i in 0..gram.ncols() {
        let left = (0..=i).map(|j| gram[(i, j)]).collect();
        screen.push(Column { first: 0, left, along: gram[(i, y)], whole: gram[(i, i)] });
    }
    let groups: Vec<&[usize]> = stack.candidates.iter().map(|one| one.columns[channel].as_slice()).collect();
    let rest = screen.given(&stack.plain)?;
    rest.stepwise(&groups, |chosen| {
        rest.given(&chosen.iter().flat_map(|one| groups[*one]).copied().collect::<Vec<_>>())
    })
}

/// Rms of each channel's readings that are left out, for each entry of `without`: by all causes but that one, or by
/// all for `None`. A prediction is what the columns give and the most likely noise, given the readings before and
/// after; the coefficients are those under the noise, or of plain least squares where these predict better.
pub fn predicted(
    problem: &Problem,
    fitted: &Fitted,
    without: &[Option<usize>],
) -> Result<Vec<Vec<f64>>, Error> {
    let of_channel = |channel: usize| -> Result<Vec<f64>, Error> {
        let sets: Vec<Vec<usize>> = without.iter().map(|cause| fitted.without(channel, *cause)).collect();
        // Without a cause that does not show in the channel the columns are the same.
        let mut distinct = sets.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let blocks: Vec<Vec<[f64; 2]>> = (0..BLOCKS)
            .into_par_iter()
            .map(|block| missed(problem, fitted, channel, block, &distinct))
            .collect::<Result<_, _>>()?;
        let rms = |set: &Vec<usize>| {
            let place = distinct.partition_point(|other| other < set);
            let squares = |by: usize| blocks.iter().map(|missed| missed[place][by]).sum::<f64>();
            (squares(0).min(squares(1)) / problem.rows().max(1) as f64).sqrt()
        };
        Ok(sets.iter().map(rms).collect())
    };
    let of_channels: Vec<Vec<f64>> =
        (0..fitted.noise.len()).into_par_iter().map(of_channel).collect::<Result<_, _>>()?;
    Ok((0..without.len()).map(|set| of_channels.iter().map(|rms| rms[set]).collect()).collect())
}

/// Sums of the squares by which a block is missed with each set of columns, with coefficients under the noise and of
/// plain least squares.
fn missed(
    problem: &Problem,
    fitted: &Fitted,
    channel: usize,
    block: usize,
    sets: &[Vec<usize>],
) -> Result<Vec<[f64; 2]>, Error> {
    let (columns, known) = fitted.columns_of(channel);
    let y = &problem.channels[channel];
    let rows = problem.rows();
    let (from, to) = (block * rows / BLOCKS, (block + 1) * rows / BLOCKS);
    let others =
        |column: &[f64]| -> Vec<f64> { column[..from].iter().chain(&column[to..]).copied().collect() };
    let times = others(&problem.time_s);
    let filter = fitted.noise[channel].whitening(&times)?;
    let mean = estimate::stats::mean(y);
    let centred: Vec<f64> = others(y).iter().map(|value| value - mean).collect();
    let own: Vec<Vec<f64>> = columns.iter().map(|column| others(column)).chain([centred]).collect();
    let products = |columns: &[Vec<f64>]| {
        let mut gram = estimate::gram_of(columns);
        known.iter().enumerate().for_each(|(column, known)| gram[(column, column)] += known);
        gram
    };
    let plain = products(&own);
    let mut white = own;
    filter.whiten_all(&mut white);
    let under_noise = products(&white);
    // Each set under the noise, then by plain least squares.
    let grams = [&under_noise, &plain];
    let fits: Vec<Fit> =
        sets.iter().flat_map(|set| grams.map(|gram| Fit::of(gram, columns.len(), set))).collect();
    let likely = if filter.is_white() {
        vec![vec![0.0; to - from]; fits.len()]
    } else {
        let mut rests: Vec<Vec<f64>> =
            fits.iter().map(|fit| fit.rest(&white, &white[columns.len()])).collect();
        filter.whiten_transposed_all(&mut rests);
        filter.most_likely(&times, &rests, &problem.time_s[from..to])
    };
    let missed = |(fit, likely): (&Fit, Vec<f64>)| -> f64 {
        let named = |row: usize| -> f64 {
            fit.columns.iter().zip(&fit.coefficients).map(|(column, size)| size * columns[*column][row]).sum()
        };
        (from..to).zip(likely).map(|(row, likely)| (y[row] - mean - named(row) - likely).powi(2)).sum()
    };
    let squares: Vec<f64> = fits.iter().zip(likely).map(missed).collect();
    Ok(squares.as_chunks().0.to_vec())
}
