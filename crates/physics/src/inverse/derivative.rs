//! Derivatives of a field that was found, by what it was found with.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{PASSES, REACHES, Row, Solved, Step};
use crate::chain::{Direction, seed, values};
use crate::lanes::{self, Dual, LANES};
use crate::{Basic, Error};

/// A derivative has settled when a pass changes it by no more than this share of its largest value.
const TOLERANCE: f64 = 1e-9;

impl Solved<'_> {
    /// ∂B/∂θ · d for each of some directions d of the parameters and each row, nT, the readings held: F(B, θ)
    /// = y gives ∂F/∂B · ∂B/∂θ = −∂F/∂θ. NaN where there is no field.
    pub fn along(&self, directions: &[Direction]) -> Result<Vec<Vec<Vector3<f64>>>, Error> {
        let all: Vec<Vec<Vec<Vector3<f64>>>> = directions
            .par_chunks(LANES)
            .map(|some| self.derivatives(some, some.len(), |_, _| Vector3::zeros()))
            .collect::<Result<_, Error>>()?;
        Ok(all.into_iter().flatten().collect())
    }

    /// Covariance of each row's field, nT², from independent errors of the readings with these variances,
    /// nT². Where the chain remembers, the errors of the rows around are in it.
    pub fn covariance_of_readings(&self, variance_nt2: Vector3<f64>) -> Result<Vec<Matrix3<f64>>, Error> {
        let apart = match &self.step {
            Step::Band(band) if band.reach() > 0 => 2 * band.reach().max(2 * REACHES[0]) + 1,
            _ => 1,
        };
        let mut covariance = vec![Matrix3::zeros(); self.rows.len()];
        let errors: Vec<(usize, usize)> = (0..3 * apart).map(|k| (k / 3, k % 3)).collect();
        for errors in errors.chunks(LANES) {
            let direction = |row: usize, lane: usize| {
                let (colour, sensor) = errors[lane];
                let std = if row % apart == colour { variance_nt2[sensor].sqrt() } else { 0.0 };
                Vector3::ith(sensor, std)
            };
            for moved in self.derivatives(&[], errors.len(), direction)? {
                for (covariance, error) in covariance.iter_mut().zip(moved) {
                    *covariance += error * error.transpose();
                }
            }
        }
        Ok(covariance)
    }

    /// Whether S is the whole inverse of ∂F/∂B, so that one pass is all.
    fn is_exact(&self) -> bool {
        match &self.step {
            Step::Unmix(_) => self.inverter.is_affine(),
            Step::Band(band) => band.reach() == 0,
            Step::Rows(_) => true,
        }
    }

    /// The same passes as for the field, with derivatives in so many lanes: along one direction of the
    /// parameters in each; without these, by the readings, which change by `moved`, nT along the sensors.
    fn derivatives(
        &self,
        directions: &[Direction],
        lanes: usize,
        moved: impl Fn(usize, usize) -> Vector3<f64>,
    ) -> Result<Vec<Vec<Vector3<f64>>>, Error> {
        let sensitivity = self.inverter.basic.sensors.map(|sensor| sensor.sensitivity);
        let (mut basic, mut values) = (self.inverter.basic.lift(), values(self.inverter.effects));
        seed(self.inverter.basic, &mut basic, &mut values, directions);
        // None before the first pass.
        let mut derivatives: Vec<Vec<Vector3<f64>>> = Vec::new();
        for pass in 0..PASSES {
            // Where neither the parameters nor yet the field has a derivative, the readings have none.
            let still = pass == 0 && directions.is_empty();
            let readings = if still { None } else { Some(self.pass(&basic, &values, &derivatives)?) };
            let finite = |row: usize| {
                readings.as_ref().is_none_or(|readings| readings[row].iter().all(lanes::is_finite))
            };
            let known: Vec<bool> =
                (0..self.rows.len()).map(|row| self.rows[row] != Row::Missing && finite(row)).collect();
            let change = |lane: usize| {
                let slope = |reading: &Vector3<Dual>| {
                    Vector3::from_fn(|i, _| lanes::slope(&reading[i], lane) * sensitivity[i])
                };
                let difference: Vec<Vector3<f64>> = (0..self.rows.len())
                    .map(|row| match (&readings, known[row]) {
                        (_, false) => Vector3::zeros(),
                        (None, true) => moved(row, lane),
                        (Some(readings), true) => moved(row, lane) - slope(&readings[row]),
                    })
                    .collect();
                self.step.of(&difference)
            };
            let changes: Vec<Vec<Vector3<f64>>> = (0..lanes).map(change).collect();
            if derivatives.is_empty() {
                derivatives = changes;
                if self.is_exact() {
                    break;
                }
                continue;
            }
            let (mut changed, mut largest): (f64, f64) = (0.0, 0.0);
            for (derivative, change) in derivatives.iter_mut().zip(&changes) {
                for (row, (derivative, change)) in derivative.iter_mut().zip(change).enumerate() {
                    *derivative += change;
                    if self.rows[row] == Row::Found {
                        changed = changed.max(change.amax());
                        largest = largest.max(derivative.amax());
                    }
                }
            }
            if changed <= TOLERANCE * largest {
                break;
            }
        }
        for derivative in &mut derivatives {
            for (derivative, row) in derivative.iter_mut().zip(&self.rows) {
                if *row != Row::Found {
                    *derivative = Vector3::repeat(f64::NAN);
                }
            }
        }
        Ok(derivatives)
    }

    /// The readings of the field with what is known of its derivatives; none are known before the first pass.
    fn pass(
        &self,
        basic: &Basic<Dual>,
        values: &[Vec<Dual>],
        derivatives: &[Vec<Vector3<f64>>],
    ) -> Result<Vec<Vector3<Dual>>, Error> {
        let by = |row: usize, k: usize, lane: usize| derivatives.get(lane).map_or(0.0, |of| of[row][k]);
        let lift = |(row, at): (usize, &Vector3<f64>)| match derivatives {
            [] => at.map(Dual::from),
            _ => Vector3::from_fn(|k, _| lanes::dual(at[k], |lane| by(row, k, lane))),
        };
        let field: Vec<Vector3<Dual>> = self.at.iter().enumerate().map(lift).collect();
        self.inverter.read(basic, values, &field)
    }
}
