//! A calibration with all that stands behind it, and its rows.

use common::ScalarCalibration;
use nalgebra::Matrix3;
use physics::{EffectInstance, Unit};

use crate::design::{Rows, Scales};
use crate::factor::Factor;
use crate::fit::FittedState;
use crate::kalman::{Form, WHITE};
use crate::known::Beforehand;
use crate::linear::Linear;
use crate::model::Model;
use crate::noise::Groups;
use crate::read::{Series, Source};

/// A calibration with all that stands behind it.
pub struct Solved {
    pub unit: Unit,
    pub scales: Scales,
    pub model: Model,
    /// What one unit of the state is in the unit of an effect's parameter.
    pub units: Vec<f64>,
    pub effects: Vec<EffectInstance>,
    pub found: FittedState,
    pub beforehand: Beforehand,
    /// Rows of the fit for what no reading shows and is held.
    pub held: Linear,
    /// Those, and the rows for what is known beforehand and used.
    pub known: Linear,
    pub mu: Matrix3<f64>,
    pub form: Form,
    /// Whether the noise is declared white: the factor then holds all that the rows say.
    pub white: bool,
    pub sources: Vec<Source>,
    /// What is said of it, as far as it is known.
    pub scalar: ScalarCalibration,
}

impl Solved {
    /// The unit of a residual, nT.
    pub fn unit_nt(&self) -> f64 {
        self.scales.magnitude_nt * self.model.scale(&self.found.state)
    }

    /// Variance of the white noise of a residual over the square of that.
    pub fn white_variance(&self) -> f64 {
        (self.scalar.noise.white_rms_nt.unwrap_or(0.0) / self.unit_nt()).powi(2)
    }

    /// Rows about a fit of a model, as they are whitened; `plain` is their factor, where white noise is
    /// declared.
    pub fn groups(
        &self,
        rows: &Rows<'_>,
        plain: Option<&Factor>,
        model: &Model,
        found: &FittedState,
    ) -> Option<Groups> {
        match plain.filter(|_| self.white) {
            Some(plain) => Groups::of_factors(&[([0.0; 2], plain)], model, found),
            None => Groups::of(rows, model, found, self.form != WHITE),
        }
    }
}

/// The rows of a calibration, where they are at hand.
pub struct Detail {
    /// The rows that were used, without what the effects of the model add.
    pub series: Vec<Series>,
    /// |B| − F in each row, nT.
    pub residuals: Vec<Vec<f64>>,
    pub follows: Vec<Vec<Vec<f64>>>,
    pub plain: Factor,
}

impl Detail {
    pub fn rows(&self, scales: Scales) -> Rows<'_> {
        Rows::new(&self.series, scales, &self.follows)
    }
}
