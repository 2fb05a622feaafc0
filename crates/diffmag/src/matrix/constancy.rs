//! Whether several estimates of one axis's column of η are one.

use common::{Axis, ChiSquared, OneMatrix};
use estimate::{linear, stats};
use faer::{ColRef, Mat, MatRef, Scale, Side};

use crate::Error;

/// One estimate: η of three elements, or Z of six with the imaginary parts behind the real ones.
#[derive(Clone)]
pub struct Estimate {
    pub value: Vec<f64>,
    pub covariance: Mat<f64>,
    /// What they would be off if all of the difference were noise of the reference: errors in variables.
    pub bias: Vec<f64>,
    /// Degrees of freedom of the noise that the covariance was scaled by; infinite where it is known.
    pub freedom: f64,
}

/// Unknowns fitted to all estimates together.
pub struct Fitted {
    pub unknowns: Vec<f64>,
    pub covariance: Mat<f64>,
    /// Share κ of the difference that is noise of the reference, 0 to 1.
    pub share: f64,
    /// χ² that each estimate has left.
    pub each: Vec<f64>,
    /// Degrees of freedom of their sum.
    pub freedom: f64,
}

impl Fitted {
    /// Probability of estimates so far apart, if `common` of the degrees of freedom went into unknowns that
    /// are taken off.
    pub fn chi_squared(&self, common: f64) -> ChiSquared {
        chi_squared(self.each.iter().sum(), self.freedom - common)
    }

    /// Their probability if unknowns `from` … are zero.
    pub fn without(&self, from: usize) -> Result<ChiSquared, Error> {
        let values = &self.unknowns[from..];
        let count = values.len();
        let covariance = self.covariance.submatrix(from, from, count, count);
        let white = whitened(covariance, ColRef::from_slice(values).as_mat())?;
        Ok(chi_squared(white.squared_norm_l2(), count as f64))
    }
}

fn chi_squared(chi_squared: f64, freedom: f64) -> ChiSquared {
    ChiSquared { chi_squared, freedom, p: stats::chi_squared_p(chi_squared, freedom) }
}

/// Fits value_i = D_i u + κ bias_i to all estimates, D_i = `design(i)` with `unknowns` columns, under their
/// covariances.
///
/// κ lies between none and all: where the fit wants it outside, it is held at the end, and counts no degree
/// of freedom. What an estimate leaves, Q with m elements, counts as (ν + m/2 − 1) ln(1 + Q/ν) where its
/// covariance was scaled by noise with ν degrees of freedom: Bartlett's form of the likelihood ratio, about
/// χ²(m) as Q/m is F(m, ν). In weighing such an estimate its covariance is ν/(ν − 2) times as large, which is
/// its variance by Student's t.
pub fn fit(
    estimates: &[Estimate],
    unknowns: usize,
    design: impl Fn(usize) -> Mat<f64>,
) -> Result<Fitted, Error> {
    let (mut rows, mut right) = (Vec::new(), Vec::new());
    for (i, estimate) in estimates.iter().enumerate() {
        let block = design(i);
        let all = Mat::from_fn(block.nrows(), unknowns + 2, |k, j| match j.checked_sub(unknowns) {
            None => block[(k, j)],
            Some(0) => estimate.bias[k],
            Some(_) => estimate.value[k],
        });
        let weight = if estimate.freedom.is_finite() { 1.0 - 2.0 / estimate.freedom } else { 1.0 };
        let white = whitened(estimate.covariance.as_ref(), all.as_ref())? * Scale(weight.sqrt());
        for row in white.row_iter() {
            rows.push(row.iter().take(unknowns + 1).copied().collect::<Vec<f64>>());
            right.push(row[unknowns + 1]);
        }
    }
    let solve = |columns: usize, share: Option<f64>| {
        let matrix = Mat::from_fn(rows.len(), columns, |i, j| rows[i][j]);
        let less: Vec<f64> =
            right.iter().zip(&rows).map(|(y, row)| y - share.unwrap_or(0.0) * row[unknowns]).collect();
        linear::fit(matrix.as_ref(), &less, None)
    };
    let mut found = solve(unknowns + 1, None)?;
    let mut share = found.coefficients[unknowns];
    if !(0.0..=1.0).contains(&share) {
        share = share.clamp(0.0, 1.0);
        found = solve(unknowns, Some(share))?;
    }
    let mut left = found.residuals.iter();
    let each = estimates.iter().map(|estimate| {
        let (m, freedom) = (estimate.value.len(), estimate.freedom);
        let squares: f64 = left.by_ref().take(m).map(|r| r * r).sum();
        if freedom.is_infinite() {
            return squares;
        }
        let squares = squares / (1.0 - 2.0 / freedom);
        (freedom + 0.5 * m as f64 - 1.0) * (squares / freedom).ln_1p()
    });
    Ok(Fitted {
        each: each.collect(),
        unknowns: found.coefficients[..unknowns].to_vec(),
        covariance: Mat::from_fn(unknowns, unknowns, |i, j| found.covariance[(i, j)]),
        share,
        freedom: found.freedom,
    })
}

/// L⁻¹ v of each column v, L Lᵀ = C.
fn whitened(covariance: MatRef<'_, f64>, columns: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let n = covariance.nrows();
    let scale: Vec<f64> = (0..n).map(|i| covariance[(i, i)].sqrt()).collect();
    let scaled = Mat::from_fn(n, n, |i, j| covariance[(i, j)] / (scale[i] * scale[j]));
    let factor = scaled.as_ref().llt(Side::Lower).map_err(|error| estimate::Error::Decomposition {
        rows: n,
        columns: n,
        reason: format!("{error:?}"),
    })?;
    let mut white = Mat::from_fn(n, columns.ncols(), |i, j| columns[(i, j)] / scale[i]);
    factor.L().solve_lower_triangular_in_place(white.as_mut());
    Ok(white)
}

/// The axes' tests as one, S = Σ χ²_i, where the axes' noise correlates with ρ_ij: Cov(χ²_i, χ²_j) = 2 √(ν_i
/// ν_j) ρ_ij², so that S/c is about χ² with E(S)/c degrees of freedom, c = Var(S)/(2 E(S)).
///
/// Source: M. B. Brown, A method for combining non-independent, one-sided tests of significance, Biometrics
/// 31 (1975) 987–992.
pub fn together(axes: [ChiSquared; 3], correlation_squared: &[[f64; 3]; 3]) -> OneMatrix {
    let mean: f64 = axes.iter().map(|axis| axis.freedom).sum();
    let mut variance = 0.0;
    for (a, squares) in axes.iter().zip(correlation_squared) {
        for (b, square) in axes.iter().zip(squares) {
            variance += 2.0 * (a.freedom * b.freedom).sqrt() * square;
        }
    }
    let scale = variance / (2.0 * mean);
    let sum: f64 = axes.iter().map(|axis| axis.chi_squared).sum();
    let mut test = OneMatrix { p: stats::chi_squared_p(sum / scale, mean / scale), ..OneMatrix::default() };
    for (axis, chi_squared) in Axis::ALL.into_iter().zip(axes) {
        *test.axes.entry(axis) = Some(chi_squared);
    }
    test
}
