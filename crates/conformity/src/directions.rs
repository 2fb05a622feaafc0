use common::covariance::between;
use common::uncertainty::directions;
use common::{Axis, Document};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use physics::frames::matrix;

use crate::joint::Joint;

/// μ with its covariance, as the document has them.
pub struct Directions {
    /// Columns = unit vectors of the sensors in SEN.
    pub mu: Matrix3<f64>,
    /// Covariance of the nine cosines, column by column, rad², scaled so that standard uncertainties are
    /// normal.
    covariance: Mat<f64>,
    /// Degrees of freedom behind it, where they are known.
    pub freedom: Option<f64>,
}

impl Directions {
    /// From `calibration.axes.sensors`. What is missing otherwise, in words.
    pub fn of(document: &Document, joint: &Joint) -> Result<Self, &'static str> {
        let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
        let rows = axes.and_then(|axes| axes.sensors.as_ref()?.matrix.as_ref());
        let Some(rows) = rows else {
            return Err(
                "the document holds no directions of three sensors; axescal finds them from `axes_orientation`",
            );
        };
        let mut mu = matrix(rows);
        mu.column_iter_mut().for_each(|mut column| {
            column.normalize_mut();
        });
        let fit = axes.and_then(|axes| axes.fit.as_ref());
        let freedom = fit.map(|fit| fit.degrees_of_freedom).filter(|freedom| *freedom > 0.0);
        let covariance = joint.covariance(&directions("sensors"));
        if (0..3).any(|i| (0..3).all(|r| covariance[(3 * i + r, 3 * i + r)] == 0.0)) {
            return Err("the directions have no uncertainty; axescal gives one, or state `std_arcsec`");
        }
        Ok(Self { mu, covariance, freedom })
    }

    /// The direction of a sensor.
    pub fn column(&self, axis: Axis) -> Vector3<f64> {
        self.mu.column(axis.index()).into_owned()
    }

    /// Largest standard uncertainty of a direction over all ways that it may turn, rad.
    pub fn largest_std(&self, axis: Axis) -> f64 {
        let first = 3 * axis.index();
        let own = Matrix3::from_fn(|r, s| self.covariance[(first + r, first + s)]);
        (0.5 * (own + own.transpose())).symmetric_eigenvalues().max().max(0.0).sqrt()
    }

    /// Variance of Σ g_i · m_i (delta method), for weights of one vector a sensor.
    pub fn variance(&self, weights: &[Vector3<f64>; 3]) -> f64 {
        let weights: Vec<f64> = weights.iter().flatten().copied().collect();
        between(&self.covariance, &weights, &weights).max(0.0)
    }
}
