//! Singular value decomposition and what is read off it (Lanczos; NASA eq. 45 to 52).

use faer::linalg::solvers::SvdError;
use faer::{Mat, MatRef};

use crate::Error;

/// Parts of null directions smaller than this are rounding.
const UNSEEN: f64 = 1e-4;

/// A D⁻¹ = U diag(σ) Vᵀ for an m×n matrix, σ falling, with D = the lengths of A's columns: unknowns of unlike
/// units (rad beside nT) and priors of unlike sharpness then weigh the same in the rank. The decomposition is
/// faer's; that Σσ² = ‖A D⁻¹‖² holds is checked at every call.
#[derive(Clone, Debug)]
pub struct Svd {
    u: Mat<f64>,
    sigma: Vec<f64>,
    v: Mat<f64>,
    lengths: Vec<f64>,
    rank: usize,
}

impl Svd {
    /// Decomposes `a`; singular values below `tolerance` times the largest count as zero.
    pub fn of(a: MatRef<'_, f64>, tolerance: f64) -> Result<Self, Error> {
        let failed = |reason: String| Error::Decomposition { rows: a.nrows(), columns: a.ncols(), reason };
        let lengths: Vec<f64> = (0..a.ncols())
            .map(|j| a.col(j).norm_l2())
            .map(|length| if length == 0.0 { 1.0 } else { length })
            .collect();
        if let Some(column) = lengths.iter().position(|length| !length.is_finite()) {
            return Err(failed(format!("the length of column {column} is {}", lengths[column])));
        }
        // Rows of zeros below a wide matrix give V all n columns, the null directions among them.
        let (m, n) = (a.nrows(), a.ncols());
        let tall = Mat::from_fn(m.max(n), n, |i, j| if i < m { a[(i, j)] / lengths[j] } else { 0.0 });
        let norm_squared = tall.squared_norm_l2();
        let (svd, v) = decompose(&tall).map_err(|error| failed(format!("{error:?}")))?;
        let sigma: Vec<f64> = svd.S().column_vector().iter().copied().collect();
        let sum: f64 = sigma.iter().map(|s| s * s).sum();
        if (sum - norm_squared).abs() > 1e-9 * norm_squared {
            return Err(failed(format!(
                "the squared singular values add to {sum}, the squared norm is {norm_squared}"
            )));
        }
        let cutoff = tolerance * sigma.first().copied().unwrap_or(0.0);
        let rank = sigma.iter().filter(|s| **s > cutoff).count();
        Ok(Svd { u: svd.U().subrows(0, m).to_owned(), sigma, v, lengths, rank })
    }

    /// Number of singular values that count.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// The singular values of the matrix with columns of unit length, largest first.
    pub fn sigma(&self) -> &[f64] {
        &self.sigma
    }

    /// D: the lengths of A's columns, one for a column of zeros.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// V: the directions of the unknowns that go with the singular values that count.
    pub fn directions(&self) -> MatRef<'_, f64> {
        self.v.get(.., ..self.rank)
    }

    /// Uᵀ b over the values that count.
    pub fn projections(&self, b: &[f64]) -> impl Iterator<Item = f64> {
        (0..self.rank).map(move |k| self.u.col_as_slice(k).iter().zip(b).map(|(u, b)| u * b).sum())
    }

    /// x = D⁻¹ V σ⁻¹ Uᵀ b over the values that count: the solution of least norm in units of 1/D.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.v.nrows()];
        for (k, projection) in self.projections(b).enumerate() {
            let projection = projection / self.sigma[k];
            for (x, v) in x.iter_mut().zip(self.v.col_as_slice(k)) {
                *x += projection * v;
            }
        }
        x.iter_mut().zip(&self.lengths).for_each(|(x, length)| *x /= length);
        x
    }

    /// D⁻¹ V σ⁻² Vᵀ D⁻¹: the covariance of the solution for rows of unit variance.
    pub fn covariance(&self) -> Mat<f64> {
        let scaled = Mat::from_fn(self.v.nrows(), self.rank, |i, k| {
            self.v[(i, k)] / (self.sigma[k] * self.lengths[i])
        });
        &scaled * scaled.transpose()
    }

    /// Directions of the unknowns that A does not see, as far as they show within `subset`: one (over all
    /// unknowns, zero outside the subset) for each way in which the subset may move unseen.
    pub fn unseen(&self, subset: &[usize]) -> Vec<Vec<f64>> {
        let null = self.v.ncols() - self.rank;
        if null == 0 || subset.is_empty() {
            return Vec::new();
        }
        let part = Mat::from_fn(subset.len(), null, |i, k| self.v[(subset[i], self.rank + k)]);
        let Ok(svd) = part.thin_svd() else { return Vec::new() };
        let sigma = svd.S().column_vector();
        (0..sigma.nrows())
            .filter(|k| sigma[*k] > UNSEEN)
            .map(|k| {
                let mut direction = vec![0.0; self.v.nrows()];
                for (i, &unknown) in subset.iter().enumerate() {
                    direction[unknown] = svd.U()[(i, k)] / self.lengths[unknown];
                }
                let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
                direction.iter_mut().for_each(|d| *d /= norm);
                direction
            })
            .collect()
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

/// The decomposition, and V. faer's iteration gives up on a few matrices in a million that have nothing wrong
/// with them; with the columns in another order it goes another way, and V's rows are put back.
fn decompose(a: &Mat<f64>) -> Result<(faer::linalg::solvers::Svd<f64>, Mat<f64>), SvdError> {
    let n = a.ncols();
    let mut last = SvdError::NoConvergence;
    for shift in 0..n.max(1) {
        let place = |j: usize| (j + shift) % n;
        let turned = Mat::from_fn(a.nrows(), n, |i, j| a[(i, place(j))]);
        match turned.thin_svd() {
            Ok(svd) => {
                let mut v = Mat::zeros(n, n);
                for j in 0..n {
                    (0..n).for_each(|k| v[(place(j), k)] = svd.V()[(j, k)]);
                }
                return Ok((svd, v));
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use noise::Stream;
    use proptest::prelude::*;

    #[test]
    fn not_finite_is_refused() {
        let a = Mat::from_fn(3, 2, |i, _| if i == 1 { f64::NAN } else { 1.0 });
        assert!(Svd::of(a.as_ref(), 1e-12).is_err());
    }

    proptest! {
        #[test]
        fn null_directions_are_unseen(rows in 1usize..9, columns in 1usize..9, rank in 1usize..5, seed in 0u64..1000) {
            let rank = rank.min(rows).min(columns);
            let mut stream = Stream::new(seed, "svd");
            let left = Mat::from_fn(rows, rank, |_, _| stream.normal());
            let right = Mat::from_fn(rank, columns, |_, _| stream.normal());
            let a = &left * &right;
            let svd = Svd::of(a.as_ref(), 1e-9).expect("finite");
            prop_assert!(svd.rank() <= rank);
            let null = svd.unseen(&(0..columns).collect::<Vec<_>>());
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
