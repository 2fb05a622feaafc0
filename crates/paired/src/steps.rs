//! Steps in what is left of a pair.

use estimate::Error;
use explain::{Fit, Problem};

use crate::courses::Acting;
use crate::left::Left;

/// A level lasts for so many rows at least, and for this share of them.
const LEAST: usize = 8;
const SHARE: f64 = 0.02;

/// Steps of which each is the strongest beside those before it, at most so many, with the number of moments at which one
/// was looked for; only by odds with which the engine may name it.
///
/// With the columns X of the base, s of a step and r of what is left under noise of covariance C, a step lowers r C⁻¹ r by
/// (s C⁻¹ r̃)²/(s C⁻¹ s − s C⁻¹ X (X C⁻¹ X)⁻¹ X C⁻¹ s), r̃ = r less its fit by X: for all moments by sums from the last row on.
///
/// # Errors
///
/// Times out of order.
pub fn steps(problem: &Problem, all: &[Left<'_>], most: usize) -> Result<Vec<(Acting, f64)>, Error> {
    let rows = problem.rows();
    let lasts = LEAST.max((SHARE * rows as f64) as usize);
    let mut known: Vec<usize> = problem.steps.clone();
    let mut base = problem.base_columns();
    let norms: Vec<Vec<f64>> = all.iter().map(norms).collect();
    let mut found = Vec::new();
    for _ in 0..most {
        let gains: Vec<Vec<f64>> =
            all.iter().zip(&norms).map(|(of, norms)| gains(of, norms, &base)).collect();
        let is_free =
            |row: &usize| known.iter().chain([&0, &rows]).all(|other| row.abs_diff(*other) >= lasts);
        let sum = |row: usize| gains.iter().map(|of| of[row]).sum::<f64>();
        let best = (1..rows).filter(is_free).max_by(|a, b| sum(*a).total_cmp(&sum(*b)));
        let Some(row) = best else { break };
        let own: Vec<f64> = gains.iter().map(|of| of[row]).collect();
        let looks = rows as f64;
        if explain::odds(&own, 1, rows, problem.causes().len()) <= looks.ln() {
            break;
        }
        known.push(row);
        base.push((0..rows).map(|other| f64::from(u8::from(other >= row))).collect());
        found.push((Acting::Step(problem.time_s[row]), looks));
    }
    Ok(found)
}

/// s C⁻¹ s of a step at each row, as the filter in its middle answers to one.
fn norms(of: &Left<'_>) -> Vec<f64> {
    let rows = of.filter.rows();
    let mut level = 0.0;
    let mut squares = of.filter.response().into_iter().map(|answer| {
        level += answer;
        level * level
    });
    let (mut sum, mut last) = (0.0, 0.0);
    let mut all: Vec<f64> = (0..rows)
        .map(|_| {
            last = squares.next().unwrap_or(last);
            sum += last;
            sum
        })
        .collect();
    all.reverse();
    all
}

/// By how much a step at each row lowers the sum of squares of what is left, beside the base.
fn gains(of: &Left<'_>, norms: &[f64], base: &[Vec<f64>]) -> Vec<f64> {
    let mut columns: Vec<Vec<f64>> = base.to_vec();
    of.filter.whiten_all(&mut columns);
    columns.push(of.white.clone());
    let y = base.len();
    let fit = Fit::of(&estimate::gram_of(&columns), y, &(0..y).collect::<Vec<_>>());
    columns[y] = fit.rest(&columns, &of.white);
    of.filter.whiten_transposed_all(&mut columns);
    let mut sums = vec![0.0; columns.len()];
    let mut gains = vec![0.0; norms.len()];
    for row in (0..norms.len()).rev() {
        sums.iter_mut().zip(&columns).for_each(|(sum, column)| *sum += column[row]);
        let mut follows = 0.0;
        for (i, a) in fit.columns.iter().enumerate() {
            for (j, b) in fit.columns.iter().enumerate() {
                follows += sums[*a] * fit.inverse[(i, j)] * sums[*b];
            }
        }
        // What follows from the base nearly is no step.
        let own = norms[row] - follows;
        gains[row] = if own > SHARE * norms[row] { sums[y] * sums[y] / own } else { 0.0 };
    }
    gains
}
