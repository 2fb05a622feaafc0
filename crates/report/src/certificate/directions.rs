use common::{Axis, Document};
use nalgebra::{Matrix3, Vector3};
use physics::frames::{ARCSEC, matrix};

use super::verdict::normal_std;

/// μ with its covariance, as the document has them.
pub struct Directions {
    /// Columns = unit vectors of the sensors in SEN.
    pub mu: Matrix3<f64>,
    /// Covariance of column i with column j, rad², scaled so that standard uncertainties are normal.
    covariance: [[Matrix3<f64>; 3]; 3],
    /// Degrees of freedom behind it, where they are known.
    pub freedom: Option<f64>,
}

impl Directions {
    /// From `calibration.axes.sensors`: its covariance, or `std_arcsec` as that of a turn in any direction. What is missing
    /// otherwise, in words.
    pub fn of(document: &Document) -> Result<Self, &'static str> {
        let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
        let sensors = axes.and_then(|axes| axes.sensors.as_ref());
        let rows = sensors.and_then(|sensors| sensors.matrix.as_ref());
        let (Some(sensors), Some(rows)) = (sensors, rows) else {
            return Err(
                "the document holds no directions of three sensors; axescal finds them from `axes_orientation`",
            );
        };
        let mut mu = matrix(rows);
        mu.column_iter_mut().for_each(|mut column| {
            column.normalize_mut();
        });
        let fit = axes.and_then(|axes| axes.fit.as_ref());
        let widened = normal_std(1.0, fit.map_or(0.0, |fit| fit.coverage_factor_95)).powi(2);
        let freedom = fit.map(|fit| fit.degrees_of_freedom).filter(|freedom| *freedom > 0.0);
        let mut covariance = [[Matrix3::zeros(); 3]; 3];
        if let (Some(given), Some(order)) = (&sensors.covariance, &sensors.covariance_order) {
            let place = |r: usize, i: usize| order.iter().position(|key| *key == format!("matrix[{r}][{i}]"));
            for (i, j, r, s) in (0..81).map(|k| (k / 27, k / 9 % 3, k / 3 % 3, k % 3)) {
                let entry =
                    place(r, i).zip(place(s, j)).and_then(|(row, column)| given.get(row)?.get(column));
                let Some(entry) = entry else {
                    return Err("the covariance of the directions lacks entries; axescal writes all of them");
                };
                covariance[i][j][(r, s)] = entry * widened;
            }
        } else {
            for axis in Axis::ALL {
                let Some(std) = sensors.std_arcsec.as_ref().and_then(|std| std.get(axis)) else {
                    return Err(
                        "the directions have no uncertainty; axescal gives one, or state `std_arcsec`",
                    );
                };
                let own = mu.column(axis.index()).into_owned();
                let across = Matrix3::identity() - own * own.transpose();
                covariance[axis.index()][axis.index()] = across * (std * ARCSEC).powi(2) * widened;
            }
        }
        Ok(Self { mu, covariance, freedom })
    }

    /// The direction of a sensor.
    pub fn column(&self, axis: Axis) -> Vector3<f64> {
        self.mu.column(axis.index()).into_owned()
    }

    /// Largest standard uncertainty of a direction over all ways that it may turn, rad.
    pub fn largest_std(&self, axis: Axis) -> f64 {
        let own = &self.covariance[axis.index()][axis.index()];
        (0.5 * (own + own.transpose())).symmetric_eigenvalues().max().max(0.0).sqrt()
    }

    /// Variance of Σ g_i · m_i (delta method), for weights of one vector a sensor.
    pub fn variance(&self, weights: &[Vector3<f64>; 3]) -> f64 {
        let pairs = (0..9).map(|k| (k / 3, k % 3));
        pairs.map(|(i, j)| weights[i].dot(&(self.covariance[i][j] * weights[j]))).sum::<f64>().max(0.0)
    }
}
