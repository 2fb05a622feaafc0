//! Steps in what is left of a pair.

use explain::Problem;

use crate::courses::Acting;
use crate::left::{Left, basis, without};

/// A level lasts for so many rows at least, and for this share of them.
const LEAST: usize = 8;
const SHARE: f64 = 0.02;
/// A step of which the base leaves less than this share of the square is none.
const INDEPENDENT: f64 = 0.02;

/// Steps of which each is the strongest beside those before it, at most so many, with the number of moments at which one
/// was looked for; only by odds with which the engine may name it.
///
/// Under noise of covariance C a step s lowers rᵀ C⁻¹ r by (sᵀ C⁻¹ r)²/(sᵀ C⁻¹ s − |Qᵀ L⁻¹ s|²): L Lᵀ = C, Q is an
/// orthonormal basis of the whitened columns of base and causes, and r is what is left without its part along them. For
/// all moments these are sums from the last row on.
pub fn steps(problem: &Problem, all: &[Left<'_>], most: usize) -> Vec<(Acting, f64)> {
    let rows = problem.rows();
    let lasts = LEAST.max((SHARE * rows as f64) as usize);
    let mut known: Vec<usize> = Vec::new();
    let mut base = problem.base_columns();
    let norms: Vec<Vec<f64>> = all.iter().map(|of| of.filter.step_norms()).collect();
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
    found
}

/// By how much a step at each row lowers the sum of squares of what is left.
fn gains(of: &Left<'_>, norms: &[f64], base: &[Vec<f64>]) -> Vec<f64> {
    let parts = of.parts.iter().map(|part| part.to_vec());
    let mut columns: Vec<Vec<f64>> = base.iter().cloned().chain(parts).collect();
    of.filter.whiten_all(&mut columns);
    let mut columns = basis(columns);
    let mut rest = of.white.clone();
    columns.iter().for_each(|column| without(&mut rest, column));
    columns.push(rest);
    of.filter.whiten_transposed_all(&mut columns);
    let mut sums = vec![0.0; columns.len()];
    let mut gains = vec![0.0; norms.len()];
    for row in (0..norms.len()).rev() {
        sums.iter_mut().zip(&columns).for_each(|(sum, column)| *sum += column[row]);
        let [follow @ .., along] = &sums[..] else { continue };
        let own = norms[row] - follow.iter().map(|sum| sum * sum).sum::<f64>();
        gains[row] = if own > INDEPENDENT * norms[row] { along * along / own } else { 0.0 };
    }
    gains
}
