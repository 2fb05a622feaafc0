//! The lag at which one series follows several others.

use faer::Mat;
use faer::linalg::solvers::Solve;
use fourier::Complex;

use crate::Error;
use crate::positive::cholesky;

/// What is slower than so many samples does not count: over it the ends of the series weigh too much.
const MEMORY: usize = 256;

/// A column of which the others leave less than this share follows from them.
const DEPENDENT: f64 = 1e-12;

/// How much of y, in χ² under noise of the one-sided density `density`, a regression on all of the columns
/// explains when these are later by l samples: element l + reach, l from −reach to reach.
///
/// With the differences of all series, their transforms x̃ and ỹ and the variance S_k of a difference of the
/// noise there,
///
/// χ²(l) = b_lᵀ G⁻¹ b_l, b_l = Σ x̃_k* ỹ_k e^(2πi k l/n)/S_k, G = Σ x̃_k* x̃_kᵀ/S_k.
///
/// Its maximum is the lag of greatest likelihood. Series are taken as periodic: l should be well below their length.
///
/// Source: C. H. Knapp and G. C. Carter, The generalized correlation method for estimation of time delay,
/// IEEE Trans. ASSP 24 (1976) 320–327.
///
/// Errors: [`Error::TooFew`] for fewer samples than twice the reach, [`Error::Decomposition`] where the
/// columns depend on each other.
pub fn explained(
    columns: &[Vec<f64>],
    y: &[f64],
    step_s: f64,
    density: &dyn Fn(f64) -> f64,
    reach: usize,
) -> Result<Vec<f64>, Error> {
    let n = y.len();
    if n < 2 * reach + 2 {
        return Err(Error::TooFew { found: n, unknowns: 2 * reach + 2 });
    }
    let transform = |values: &[f64]| -> Vec<Complex<f64>> {
        fourier::forward((0..n).map(|m| if m == 0 { 0.0 } else { values[m] - values[m - 1] }).collect())
    };
    let x: Vec<Vec<Complex<f64>>> = columns.iter().map(|column| transform(column)).collect();
    let y = transform(y);
    let from = (n / MEMORY).max(1);
    // The jump between the ends is left out: all transforms lack its noise, at every frequency alike.
    let length_s = n as f64 * step_s;
    let jump: f64 = 2.0 * (1..y.len()).map(|k| density(k as f64 / length_s) / length_s).sum::<f64>();
    let weight = |k: usize| {
        let rise = (std::f64::consts::PI * k as f64 / n as f64).sin();
        let variance = n as f64 * density(k as f64 / length_s) * 2.0 * rise * rise / step_s + jump;
        if k < from { 0.0 } else { 1.0 / variance }
    };
    let weight: Vec<f64> = (0..y.len()).map(weight).collect();
    let unknowns = columns.len();
    // Every frequency but the highest of an even length stands twice in a sum over the circle.
    let twice = |k: usize| if 2 * k == n { 1.0 } else { 2.0 };
    let information = Mat::from_fn(unknowns, unknowns, |i, j| {
        (from..y.len()).map(|k| twice(k) * (x[i][k].conj() * x[j][k]).re * weight[k]).sum::<f64>()
    });
    let product = |column: &Vec<Complex<f64>>| {
        let product = column.iter().zip(&y).zip(&weight).map(|((x, y), w)| x.conj() * y * w);
        fourier::inverse(product.collect(), n)
    };
    let products: Vec<Vec<f64>> = x.iter().map(product).collect();
    let factor = cholesky(information.as_ref())?;
    if (0..unknowns).any(|i| factor.L()[(i, i)].powi(2) <= DEPENDENT * information[(i, i)]) {
        let reason = "a column that follows from the others".into();
        return Err(Error::Decomposition { rows: unknowns, columns: unknowns, reason });
    }
    let at = |lag: usize| (n + lag - reach) % n;
    let right = Mat::from_fn(unknowns, 2 * reach + 1, |i, lag| products[i][at(lag)]);
    let solved = factor.solve(&right);
    Ok((0..=2 * reach).map(|lag| (0..unknowns).map(|i| right[(i, lag)] * solved[(i, lag)]).sum()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use noise::{Stream, random_walk};

    #[test]
    fn the_lag_is_found_and_its_gain_is_a_chi_squared() {
        let n = 2000;
        let mut stream = Stream::new(5, "lag");
        let time: Vec<f64> = (0..n + 40).map(|m| m as f64).collect();
        let x = [(); 2].map(|()| random_walk(&mut stream, &time, 1.0));
        let y: Vec<f64> =
            (0..n).map(|m| 0.8 * x[0][m + 7] - 0.3 * x[1][m + 7] + 0.3 * stream.normal()).collect();
        let columns: Vec<Vec<f64>> = x.iter().map(|x| x[20..n + 20].to_vec()).collect();
        let density = |_: f64| 2.0 * 0.09;
        let gains = explained(&columns, &y, 1.0, &density, 100).expect("gains");
        let best = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b])).expect("a maximum");
        assert_eq!(best as i64 - 100, 13, "y has now what the columns had 13 samples ago");
        // Of noise alone two columns explain a χ² of two.
        let by_chance: Vec<f64> = (0..30)
            .flat_map(|_| {
                let noise: Vec<f64> = (0..n).map(|_| 0.3 * stream.normal()).collect();
                explained(&columns, &noise, 1.0, &density, 100).expect("gains")
            })
            .collect();
        let mean = by_chance.iter().sum::<f64>() / by_chance.len() as f64;
        assert!((mean - 2.0).abs() < 0.3, "{mean}");
        assert!(by_chance.iter().all(|gain| gains[best] > 1000.0 * gain));
        assert!(explained(&columns, &y[..100], 1.0, &density, 100).is_err());
        assert!(explained(&[columns[0].clone(), columns[0].clone()], &y, 1.0, &density, 9).is_err());
    }
}
