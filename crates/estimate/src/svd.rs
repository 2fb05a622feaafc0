//! Singular value decomposition and what is read off it: rank, null directions, the minimum-norm
//! solution, covariance and leverage (Lanczos; NASA eq. 45 to 52).

use faer::{Mat, MatRef};

use crate::Error;

/// A = U diag(σ) Vᵀ for an m×n matrix, σ falling. The decomposition is faer's; that
/// Σσ² = ‖A‖² holds is checked at every call.
#[derive(Clone, Debug)]
pub struct Svd {
    u: Mat<f64>,
    sigma: Vec<f64>,
    v: Mat<f64>,
    rank: usize,
}

impl Svd {
    /// Decomposes `a`; singular values below `tolerance` times the largest count as zero.
    pub fn of(a: MatRef<'_, f64>, tolerance: f64) -> Result<Self, Error> {
        let failed = |reason: String| Error::Decomposition { rows: a.nrows(), columns: a.ncols(), reason };
        let norm_squared = a.squared_norm_l2();
        if !norm_squared.is_finite() {
            return Err(failed(format!("its squared norm is {norm_squared}")));
        }
        // A wide matrix is decomposed with rows of zeros below, so that V has all n columns and the
        // null directions come with it.
        let (m, n) = (a.nrows(), a.ncols());
        let tall =
            if m < n { Mat::from_fn(n, n, |i, j| if i < m { a[(i, j)] } else { 0.0 }) } else { a.to_owned() };
        let svd = tall.thin_svd().map_err(|error| failed(format!("{error:?}")))?;
        let sigma: Vec<f64> = svd.S().column_vector().iter().copied().collect();
        let sum: f64 = sigma.iter().map(|s| s * s).sum();
        if (sum - norm_squared).abs() > 1e-9 * norm_squared {
            return Err(failed(format!(
                "the squared singular values add to {sum}, the squared norm is {norm_squared}"
            )));
        }
        let cutoff = tolerance * sigma.first().copied().unwrap_or(0.0);
        let rank = sigma.iter().filter(|s| **s > cutoff).count();
        Ok(Svd { u: svd.U().subrows(0, m).to_owned(), sigma, v: svd.V().to_owned(), rank })
    }

    /// Number of singular values that count.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The singular values, largest first.
    pub fn sigma(&self) -> &[f64] {
        &self.sigma
    }

    /// Minimum-norm least-squares solution of A x = b: x = V σ⁻¹ Uᵀ b over the values that count.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.v.nrows()];
        for k in 0..self.rank {
            let u = self.u.col_as_slice(k);
            let projection: f64 = u.iter().zip(b).map(|(u, b)| u * b).sum::<f64>() / self.sigma[k];
            for (x, v) in x.iter_mut().zip(self.v.col_as_slice(k)) {
                *x += projection * v;
            }
        }
        x
    }

    /// (AᵀA)⁺ = V σ⁻² Vᵀ: the covariance of the solution for rows of unit variance.
    pub fn covariance(&self) -> Mat<f64> {
        let scaled = Mat::from_fn(self.v.nrows(), self.rank, |i, k| self.v[(i, k)] / self.sigma[k]);
        &scaled * scaled.transpose()
    }

    /// Unit vectors of the unknowns that A does not see.
    pub fn null_directions(&self) -> Vec<Vec<f64>> {
        (self.rank..self.v.ncols()).map(|k| self.v.col_as_slice(k).to_vec()).collect()
    }

    /// Leverage of each row: the diagonal of A A⁺, the share of its own prediction that it decides.
    pub fn leverage(&self) -> Vec<f64> {
        let mut leverage = vec![0.0; self.u.nrows()];
        for k in 0..self.rank {
            for (h, u) in leverage.iter_mut().zip(self.u.col_as_slice(k)) {
                *h += u * u;
            }
        }
        leverage
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn hand_worked_line() {
        // y = 1 + 2 t at t = 0, 1, 2 with residuals (1, -2, 1)/6 put on top: they are orthogonal to the line.
        let a = Mat::from_fn(3, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
        let svd = Svd::of(a.as_ref(), 1e-12).expect("finite");
        let x = svd.solve(&[1.0 + 1.0 / 6.0, 3.0 - 2.0 / 6.0, 5.0 + 1.0 / 6.0]);
        assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 2.0).abs() < 1e-14);
        // (AᵀA)⁻¹ = [[5, -3], [-3, 3]]/6, leverages 5/6, 1/3, 5/6.
        let covariance = svd.covariance();
        assert!((covariance[(0, 0)] - 5.0 / 6.0).abs() < 1e-14);
        assert!((covariance[(0, 1)] + 0.5).abs() < 1e-14);
        let leverage = svd.leverage();
        assert!((leverage[0] - 5.0 / 6.0).abs() < 1e-14 && (leverage[1] - 1.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn not_finite_is_refused() {
        let a = Mat::from_fn(3, 2, |i, _| if i == 1 { f64::NAN } else { 1.0 });
        assert!(Svd::of(a.as_ref(), 1e-12).is_err());
    }

    proptest! {
        #[test]
        fn null_directions_are_unseen(rows in 1usize..9, columns in 1usize..9, rank in 1usize..5, seed in 0u64..1000) {
            let rank = rank.min(rows).min(columns);
            let mut state = seed.wrapping_mul(2862933555777941757).wrapping_add(3037000493);
            let mut random = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
            };
            let left = Mat::from_fn(rows, rank, |_, _| random());
            let right = Mat::from_fn(rank, columns, |_, _| random());
            let a = &left * &right;
            let svd = Svd::of(a.as_ref(), 1e-9).expect("finite");
            prop_assert!(svd.rank() <= rank);
            let null = svd.null_directions();
            prop_assert_eq!(null.len(), columns - svd.rank());
            for direction in null {
                for i in 0..rows {
                    let seen: f64 = (0..columns).map(|j| a[(i, j)] * direction[j]).sum();
                    prop_assert!(seen.abs() < 1e-8);
                }
            }
            let trace: f64 = svd.leverage().iter().sum();
            prop_assert!((trace - svd.rank() as f64).abs() < 1e-9);
        }
    }
}
