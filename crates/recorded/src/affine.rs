//! T = R η + d by hand: the difference of two instruments, and least squares on columns, without any code of
//! the stages.

use nalgebra::{DMatrix, DVector};
use serde_json::Value;

use super::series::{Series, mean, rms};

/// How the test instrument's readings follow from the reference's.
#[derive(Clone, Debug, PartialEq)]
pub struct Affine {
    /// η: element [i][j] is what the reference's axis i gives to the test's axis j.
    pub matrix: [[f64; 3]; 3],
    /// d, nT.
    pub offset_nt: [f64; 3],
}

impl Affine {
    /// As diffmag wrote it.
    pub fn found(document: &Value) -> Option<Self> {
        let differential = document.pointer("/calibration/differential")?;
        let element = |i: usize, j: usize| differential["matrix"][i][j].as_f64();
        let mut affine = Affine { matrix: [[0.0; 3]; 3], offset_nt: [0.0; 3] };
        for (j, axis) in ["x", "y", "z"].into_iter().enumerate() {
            for i in 0..3 {
                affine.matrix[i][j] = element(i, j)?;
            }
            let offset = &differential["offset_nt"][axis];
            affine.offset_nt[j] = offset.as_f64().or_else(|| offset["value"].as_f64())?;
        }
        Some(affine)
    }

    /// Axes and scales alike, and the levels of a series: what is known before anything is fitted.
    pub fn level(series: &Series) -> Self {
        let mut matrix = [[0.0; 3]; 3];
        (0..3).for_each(|k| matrix[k][k] = 1.0);
        let alike = Affine { matrix, offset_nt: [0.0; 3] };
        let differences = alike.differences(series);
        Affine { offset_nt: [0, 1, 2].map(|k| mean(differences.iter().map(|d| d[k]))), ..alike }
    }

    /// T − R η − d of each row of `reference_*_nt` and `test_*_nt`, nT.
    pub fn differences(&self, series: &Series) -> Vec<[f64; 3]> {
        let predicted =
            |r: [f64; 3], j: usize| self.offset_nt[j] + (0..3).map(|i| r[i] * self.matrix[i][j]).sum::<f64>();
        let pairs = series.vectors("reference").into_iter().zip(series.vectors("test"));
        pairs.map(|(r, t)| [0, 1, 2].map(|j| t[j] - predicted(r, j))).collect()
    }
}

/// rms of each component.
pub fn rms_of_each(vectors: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|k| rms(vectors.iter().map(|vector| vector[k])))
}

/// Standard deviation of each component, about its own mean.
pub fn scatter_of_each(vectors: &[[f64; 3]]) -> [f64; 3] {
    let level = mean_of_each(vectors);
    [0, 1, 2].map(|k| rms(vectors.iter().map(|vector| vector[k] - level[k])))
}

/// Mean of each component.
pub fn mean_of_each(vectors: &[[f64; 3]]) -> [f64; 3] {
    [0, 1, 2].map(|k| mean(vectors.iter().map(|vector| vector[k])))
}

/// Least squares: the coefficients c of y = Σ c_k column_k. None where the columns are not independent (rank
/// by SVD, 10⁻¹² of the greatest singular value, columns of unit length).
pub fn least_squares(columns: &[Vec<f64>], y: &[f64]) -> Option<Vec<f64>> {
    let lengths: Vec<f64> = columns.iter().map(|c| c.iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
    let design = DMatrix::from_fn(y.len(), columns.len(), |row, k| columns[k][row] / lengths[k]);
    let svd = design.svd(true, true);
    let independent = 1e-12 * svd.singular_values.max();
    if !svd.singular_values.iter().all(|value| *value > independent) {
        return None;
    }
    let solved = svd.solve(&DVector::from_column_slice(y), 0.0).ok()?;
    Some(solved.iter().zip(&lengths).map(|(c, length)| c / length).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn series(reference: &[[f64; 3]], test: &[[f64; 3]]) -> Series {
        Series::default().with_vectors("reference", reference).with_vectors("test", test)
    }

    #[test]
    fn a_matrix_acts_from_the_right() {
        let document = json!({"calibration": {"differential": {
            "matrix": [[1.0, 0.1, 0.0], [0.0, 1.0, 0.0], [0.0, 0.2, 1.0]],
            "offset_nt": {"x": {"value": 5.0, "std": 1.0}, "y": 0.0, "z": -1.0}}}});
        let affine = Affine::found(&document).expect("a matrix");
        // x' = x + 5, y' = 0.1 x + y + 0.2 z, z' = z − 1.
        let pair = series(&[[10.0, 20.0, 30.0]], &[[15.0, 27.0, 29.0]]);
        assert_eq!(affine.differences(&pair), [[0.0, 0.0, 0.0]]);
        assert_eq!(Affine::level(&pair).offset_nt, [5.0, 7.0, -1.0]);
        assert_eq!(rms_of_each(&Affine::level(&pair).differences(&pair)), [0.0; 3]);
        let apart = [[1.0, 0.0, 5.0], [3.0, 0.0, 5.0]];
        assert_eq!((scatter_of_each(&apart), mean_of_each(&apart)), ([1.0, 0.0, 0.0], [2.0, 0.0, 5.0]));
    }

    #[test]
    fn lines_come_back_and_dependent_columns_do_not() {
        let x: Vec<f64> = (0..20).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| 3.0 + 0.5 * x).collect();
        let found = least_squares(&[vec![1.0; 20], x.clone()], &y).expect("a line");
        assert!((found[0] - 3.0).abs() < 1e-12 && (found[1] - 0.5).abs() < 1e-12, "{found:?}");
        assert_eq!(least_squares(&[x.clone(), x.iter().map(|x| 2.0 * x).collect()], &y), None);
    }
}
