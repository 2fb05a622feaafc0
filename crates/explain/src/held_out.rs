//! What a careful person's fits predict of readings that are left out: plain least squares on nine tenths of the
//! rows predict the rest, in ten contiguous blocks.

use estimate::Error;
use estimate::screen::{Column, Screen};
use faer::Mat;
use rayon::prelude::*;

use crate::fit::Fit;
use crate::predicted::BLOCKS;
use crate::stack::Stack;

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
        let rows = stack.columns.first().map_or(0, Vec::len);
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
            let along: f64 = fit.columns.iter().zip(&fit.coefficients).map(|(i, b)| b * block[(*i, y)]).sum();
            let own: f64 = fit
                .columns
                .iter()
                .zip(&fit.coefficients)
                .flat_map(|(i, a)| {
                    fit.columns.iter().zip(&fit.coefficients).map(move |(j, b)| a * b * block[(*i, *j)])
                })
                .sum();
            squares += block[(y, y)] - 2.0 * along + own;
        }
        Ok((squares.max(0.0) / self.rows.max(1) as f64).sqrt() * stack.scale[y])
    }
}

/// The columns that a regression of a channel chooses from the products of so many rows.
type Choice<'a> = dyn Fn(usize, &Mat<f64>, usize) -> Result<Vec<usize>, Error> + 'a;

/// Of the candidates of a stack; what the names predict is not among it.
///
/// # Errors
///
/// Products that are not finite.
pub fn held_out(stack: &Stack) -> Result<HeldOut, Error> {
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
    Ok(HeldOut { base: rms(&|_, _, _| Ok(stack.plain.clone()))?, named: Vec::new(), rivals })
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
