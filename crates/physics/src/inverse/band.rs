//! The slope of the chain near its diagonal, inverted: what a pass of the solver multiplies with.

use nalgebra::Vector3;

/// Parts of a field that change the readings by less than this share are not determined.
pub(super) const UNSEEN: f64 = 1e-6;
/// A value is not determined where more than this share of it is still unseen after [`LOOKS`] passes.
const LOST_SHARE: f64 = 1e-12;
/// Passes after which that is judged.
const LOOKS: usize = 4;

/// ∂F/∂B of the rows within `reach` of each other, A, and the Cholesky factor of AᵀA + λ²: so that a system
/// whose last rows are unseen, and its first ones told twice, has its solution.
pub struct Band {
    rows: usize,
    reach: usize,
    /// A row by row: entries of each from 3 (row − reach) on.
    slope: Vec<f64>,
    /// L row by row, the entry of the diagonal last.
    factor: Vec<f64>,
}

impl Band {
    /// `slope(row, component, other, of)` is the derivative of a reading, in nT, by a component of the field
    /// in another row, which is no further away than `reach`.
    pub fn new(rows: usize, reach: usize, slope: impl Fn(usize, usize, usize, usize) -> f64) -> Self {
        let reach = reach.min(rows.saturating_sub(1));
        let width = 3 * (2 * reach + 1);
        let mut entries = vec![0.0; 3 * rows * width];
        for row in 0..rows {
            for other in row.saturating_sub(reach)..(row + reach + 1).min(rows) {
                for (component, of) in (0..9).map(|k| (k / 3, k % 3)) {
                    let place = 3 * (other + reach - row) + of;
                    entries[(3 * row + component) * width + place] = slope(row, component, other, of);
                }
            }
        }
        let mut band = Self { rows, reach, slope: entries, factor: Vec::new() };
        band.factorise();
        band
    }

    /// Rows over which it reaches.
    pub fn reach(&self) -> usize {
        self.reach
    }

    /// How far the entries of AᵀA are from its diagonal.
    fn half(&self) -> usize {
        6 * self.reach + 2
    }

    /// Entries of a row of A that belong to unknowns: the first unknown and their slice.
    fn line(&self, equation: usize) -> (usize, &[f64]) {
        let width = 3 * (2 * self.reach + 1);
        let row = equation / 3;
        let first = row.saturating_sub(self.reach);
        let end = (row + self.reach + 1).min(self.rows);
        let from = equation * width + 3 * (first + self.reach - row);
        (3 * first, &self.slope[from..from + 3 * (end - first)])
    }

    fn factorise(&mut self) {
        let (half, unknowns) = (self.half(), 3 * self.rows);
        let stride = half + 1;
        let mut factor = vec![0.0; unknowns * stride];
        for equation in 0..unknowns {
            let (first, line) = self.line(equation);
            for (i, a) in line.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                for (j, b) in line[..=i].iter().enumerate() {
                    factor[(first + i) * stride + half - (i - j)] += a * b;
                }
            }
        }
        for i in 0..unknowns {
            factor[i * stride + half] += UNSEEN * UNSEEN;
            for j in i.saturating_sub(half)..=i {
                // L_ij = (M_ij − Σ_k L_ik L_jk) / L_jj over the columns that both rows have.
                let from = i.saturating_sub(half).max(j.saturating_sub(half));
                let (of_i, of_j) = (i * stride + half - i, j * stride + half - j);
                let sum: f64 = factor[of_i + from..of_i + j]
                    .iter()
                    .zip(&factor[of_j + from..of_j + j])
                    .map(|(a, b)| a * b)
                    .sum();
                let left = factor[of_i + j] - sum;
                factor[of_i + j] =
                    if i == j { left.max(UNSEEN * UNSEEN * 1e-3).sqrt() } else { left / factor[of_j + j] };
            }
        }
        self.factor = factor;
    }

    /// (AᵀA + λ²)⁻¹ Aᵀ y.
    pub fn solve(&self, difference: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let x = self.divided(self.transposed(difference));
        x.chunks_exact(3).map(Vector3::from_column_slice).collect()
    }

    /// Aᵀ y.
    fn transposed(&self, difference: &[Vector3<f64>]) -> Vec<f64> {
        let mut sums = vec![0.0; 3 * self.rows];
        for equation in 0..3 * self.rows {
            let value = difference[equation / 3][equation % 3];
            let (first, line) = self.line(equation);
            sums[first..].iter_mut().zip(line).for_each(|(sum, a)| *sum += a * value);
        }
        sums
    }

    /// (L Lᵀ)⁻¹ x.
    fn divided(&self, mut x: Vec<f64>) -> Vec<f64> {
        let (half, stride) = (self.half(), self.half() + 1);
        for i in 0..x.len() {
            let from = i.saturating_sub(half);
            let row = &self.factor[i * stride + half + from - i..=i * stride + half];
            let sum: f64 = row.iter().zip(&x[from..i]).map(|(l, x)| l * x).sum();
            x[i] = (x[i] - sum) / row[row.len() - 1];
        }
        for i in (0..x.len()).rev() {
            let from = i.saturating_sub(half);
            let row = &self.factor[i * stride + half + from - i..=i * stride + half];
            x[i] /= row[row.len() - 1];
            let value = x[i];
            x[from..i].iter_mut().zip(row).for_each(|(x, l)| *x -= l * value);
        }
        x
    }

    /// The rows of which the readings say nothing: of any field a pass leaves λ² (AᵀA + λ²)⁻¹ unseen.
    pub fn unseen(&self) -> Vec<bool> {
        let mut unseen = vec![false; self.rows];
        // Patterns of signs that differ between neighbours in every way.
        for pattern in 0..8_usize {
            let sign = |k: usize| if (k & pattern).count_ones() % 2 == 1 { -1.0 } else { 1.0 };
            let mut left: Vec<f64> = (0..3 * self.rows).map(sign).collect();
            for _ in 0..LOOKS {
                left.iter_mut().for_each(|value| *value *= UNSEEN * UNSEEN);
                left = self.divided(left);
            }
            for (unseen, left) in unseen.iter_mut().zip(left.chunks_exact(3)) {
                *unseen |= left.iter().any(|value| value.abs() > LOST_SHARE);
            }
        }
        unseen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn any(seed: usize) -> f64 {
        ((seed * 7919 + 13) % 1000) as f64 / 1000.0 - 0.5
    }

    #[test]
    fn a_band_is_inverted() {
        let (rows, reach) = (20, 2);
        let slope = |r: usize, c: usize, o: usize, of: usize| {
            f64::from(u8::from(r == o && c == of)) + 0.2 * any(r * 81 + c * 27 + o * 9 + of)
        };
        let band = Band::new(rows, reach, slope);
        let field: Vec<Vector3<f64>> = (0..rows).map(|r| Vector3::from_fn(|c, _| any(3 * r + c))).collect();
        let reading: Vec<Vector3<f64>> = (0..rows)
            .map(|r| {
                Vector3::from_fn(|c, _| {
                    let near = r.saturating_sub(reach)..(r + reach + 1).min(rows);
                    near.map(|o| (0..3).map(|of| slope(r, c, o, of) * field[o][of]).sum::<f64>()).sum()
                })
            })
            .collect();
        let found = band.solve(&reading);
        assert!(found.iter().zip(&field).all(|(a, b)| (a - b).amax() < 1e-9));
        assert!(band.unseen().iter().all(|unseen| !unseen));
    }

    #[test]
    fn what_is_shifted_out_is_unseen() {
        // Each reading is the field of three rows ago; the first ones repeat the first field.
        let band = Band::new(12, 4, |r, c, o, of| f64::from(u8::from(c == of && o == r.saturating_sub(3))));
        assert_eq!(band.unseen(), (0..12).map(|row| row > 8).collect::<Vec<_>>());
        let reading: Vec<Vector3<f64>> =
            (0..12_usize).map(|r| Vector3::repeat(1.0 + r.saturating_sub(3) as f64)).collect();
        let found = band.solve(&reading);
        assert!((0..9).all(|r| (found[r][1] - 1.0 - r as f64).abs() < 1e-9), "{found:?}");
    }
}
