//! What a careful person's fits predict of readings that are left out: plain least squares on nine tenths of the
//! rows predict the rest, in ten contiguous blocks.

use faer::Mat;
use rayon::prelude::*;

use crate::fit::Fit;
use crate::predicted::BLOCKS;
use crate::products::Product;
use crate::stack::Stack;
use crate::sweep::Sweep;

/// Most terms of a stepwise regression.
const MOST: usize = 12;

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
            let count = stack.columns.len();
            let part = Mat::from_fn(to - from, count, |row, column| stack.columns[column][from + row]);
            part.transpose() * &part
        };
        let each: Vec<Mat<f64>> = (0..BLOCKS).into_par_iter().map(block).collect();
        let mut whole = Mat::zeros(stack.columns.len(), stack.columns.len());
        each.iter().for_each(|block| whole += block);
        Self { each, whole, rows }
    }

    /// Rms of what is predicted of `y` in all blocks, each by columns chosen on the others.
    fn rms(&self, y: usize, columns: &dyn Fn(&Mat<f64>, usize) -> Vec<usize>) -> f64 {
        let squares = self.each.iter().map(|block| {
            let others = &self.whole - block;
            let fit = Fit::of(&others, y, &columns(&others, self.rows - self.rows / BLOCKS));
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
            block[(y, y)] - 2.0 * along + own
        });
        (squares.sum::<f64>().max(0.0) / self.rows.max(1) as f64).sqrt()
    }
}

/// The columns that a regression of a channel chooses from the products of so many rows.
type Choice<'a> = dyn Fn(usize, &Mat<f64>, usize) -> Vec<usize> + 'a;

/// Of the candidates of a stack; what the names predict is not among it.
pub fn held_out(stack: &Stack) -> HeldOut {
    let blocks = Blocks::of(stack);
    let of = |channel: usize, candidates: &[usize]| -> Vec<usize> {
        let own = candidates.iter().flat_map(|one| stack.candidates[*one].columns[channel].clone());
        stack.plain.iter().copied().chain(own).collect()
    };
    let rms = |columns: &Choice<'_>| -> Vec<f64> {
        (0..stack.y.len())
            .map(|channel| {
                let y = stack.y[channel];
                let own = |gram: &Mat<f64>, rows: usize| columns(channel, gram, rows);
                blocks.rms(y, &own) * stack.scale[y]
            })
            .collect()
    };
    let plain = |candidate: &usize| {
        let form = stack.candidates[*candidate].form;
        !stack.candidates[*candidate].tied && form == crate::form::Form::default()
    };
    let straight: Vec<usize> = (0..stack.candidates.len()).filter(plain).collect();
    let chosen = |channel: usize, gram: &Mat<f64>, rows: usize| stepwise(stack, gram, rows, channel);
    let mut terms: Vec<usize> =
        (0..stack.y.len()).flat_map(|channel| chosen(channel, &blocks.whole, blocks.rows)).collect();
    terms.sort_unstable();
    terms.dedup();
    let rivals = vec![
        Plain {
            name: "stepwise regression",
            rms: rms(&|channel, gram, rows| of(channel, &chosen(channel, gram, rows))),
            terms,
        },
        Plain {
            name: "least squares with every column",
            rms: rms(&|channel, _, _| of(channel, &straight)),
            terms: straight.clone(),
        },
    ];
    HeldOut { base: rms(&|_, _, _| stack.plain.clone()), named: Vec::new(), rivals }
}

/// Candidates added to one channel one at a time while n ln RSS + k ln n falls.
fn stepwise(stack: &Stack, gram: &Mat<f64>, rows: usize, channel: usize) -> Vec<usize> {
    let product = [Product { gram: gram.clone(), log_determinant: 0.0, log_prior: 0.0 }];
    let n = rows as f64;
    let mut columns: Vec<usize> = Vec::new();
    let mut terms: Vec<usize> = Vec::new();
    while terms.len() < MOST {
        let sweep = Sweep::of(&product, rows, stack.y[channel], &stack.plain, &columns);
        let left = sweep.left()[0];
        let tried = (0..stack.candidates.len()).filter(|one| !terms.contains(one)).map(|one| {
            let (gain, rank) = sweep.gain(&stack.candidates[one].columns[channel]);
            (one, n * (1.0 - gain / left).max(f64::MIN_POSITIVE).ln() + rank as f64 * n.ln())
        });
        let Some((one, _)) = tried.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, change)| *change < 0.0)
        else {
            break;
        };
        terms.push(one);
        columns.extend(&stack.candidates[one].columns[channel]);
    }
    terms
}
