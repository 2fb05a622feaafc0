//! A calibration with all that stands behind it, and its rows.

use common::{BodyIron, Noise, VectorFit};
use nalgebra::Matrix3;
use physics::{EffectInstance, Unit};

use crate::design::{Rows, Scales};
use crate::factor::Factor;
use crate::fit::{FittedState, PriorRows};
use crate::kalman::Form;
use crate::known::Beforehand;
use crate::model::Model;
use crate::noise::Groups;
use crate::read::{Series, Source};

/// A calibration with all that stands behind it.
pub struct Solved {
    /// Unit of the readings.
    pub unit: Unit,
    /// The units of the parameters.
    pub scales: Scales,
    /// The parameters.
    pub model: Model,
    /// What one unit of the state is in the unit of an effect's parameter.
    pub units: Vec<f64>,
    /// The effects that were fitted.
    pub effects: Vec<EffectInstance>,
    /// The fit.
    pub found: FittedState,
    /// What was known beforehand.
    pub beforehand: Beforehand,
    /// Rows of the fit for what no reading shows and is held.
    pub held: PriorRows,
    /// Those, and the rows for what is known beforehand and used.
    pub known: PriorRows,
    /// μ.
    pub mu: Matrix3<f64>,
    /// Noise of a residual (white) and of the sensors (with memory).
    pub noise: Noise,
    /// Its form.
    pub form: Form,
    /// Whether the noise is declared white: the factor then holds all that the rows say.
    pub white: bool,
    /// Names of the recordings.
    pub recordings: Vec<String>,
    /// Where their magnitude comes from.
    pub sources: Vec<Source>,
    /// Rows used.
    pub rows: u64,
    /// Rows that lack a reading.
    pub missing: u64,
    /// Rows left out, by the reason.
    pub left_out: Vec<(String, u64)>,
    /// What was done or assumed, in words.
    pub told: Vec<String>,
    /// The iron of the body, where the sensors' own calibration is known.
    pub body: Option<BodyIron>,
    /// Whether the calibration includes it.
    pub includes_body: bool,
    /// The field and its direction, where they were used.
    pub vector: Option<VectorFit>,
}

impl Solved {
    /// The unit of a residual, nT.
    pub fn unit_nt(&self) -> f64 {
        self.scales.magnitude_nt * self.model.scale(&self.found.state)
    }

    /// Variance of the white noise of a residual over the square of that.
    pub fn white_variance(&self) -> f64 {
        (self.noise.white_rms_nt.unwrap_or(0.0) / self.unit_nt()).powi(2)
    }
}

/// The rows of a calibration, where they are at hand.
pub struct Detail {
    /// The rows that were used, without what the effects of the model add.
    pub series: Vec<Series>,
    /// |B| − F in each row, nT.
    pub residuals: Vec<Vec<f64>>,
    /// The columns that effects follow.
    pub follows: Vec<Vec<Vec<f64>>>,
    /// The factor of their products.
    pub plain: Factor,
}

impl Detail {
    /// The rows in the units of the parameters.
    pub fn rows(&self, scales: Scales) -> Rows<'_> {
        Rows { series: &self.series, scales, follows: self.follows.clone(), weights: None }
    }

    /// The rows about a fit of a model, as they are whitened.
    pub fn groups(&self, solved: &Solved, model: &Model, found: &FittedState, timed: bool) -> Option<Groups> {
        if solved.white {
            return Groups::of_factors(&[([0.0; 2], &self.plain)], model, found);
        }
        Groups::of(&self.rows(solved.scales), model, found, timed)
    }

    /// Some rows of one recording.
    pub fn part(&self, solved: &Solved, number: usize, from: usize, to: usize) -> Self {
        let follows = self.follows[number].iter().map(|column| column[from..to].to_vec()).collect();
        let mut part = Self {
            series: vec![self.series[number].part(from, to)],
            residuals: vec![self.residuals[number][from..to].to_vec()],
            follows: vec![follows],
            plain: Factor::new(solved.model.terms.count()),
        };
        if solved.white {
            part.plain = part.rows(solved.scales).factor(&solved.model.terms);
        }
        part
    }
}
