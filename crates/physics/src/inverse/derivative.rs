//! Derivatives of a field that was found, by what it was found with.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::{PASSES, REACHES, Row, Solved, Step};
use crate::chain::seed;
use crate::lanes::{self, Dual, LANES};
use crate::{Basic, Error, Parameter};

/// A derivative has settled when a pass changes it by no more than this share of its largest value.
const TOLERANCE: f64 = 1e-9;

impl Solved<'_> {
    /// ∂B/∂θ for each of some parameters and each row, nT per unit of the parameter, the readings held: F(B,
    /// θ) = y gives ∂F/∂B · ∂B/∂θ = −∂F/∂θ. NaN where there is no field.
    pub fn by_parameters(&self, parameters: &[Parameter]) -> Result<Vec<Vec<Vector3<f64>>>, Error> {
        let all: Vec<Vec<Vec<Vector3<f64>>>> = parameters
            .par_chunks(LANES)
            .map(|some| self.derivatives(some, some.len(), |_, _| Vector3::zeros()))
            .collect::<Result<_, Error>>()?;
        Ok(all.into_iter().flatten().collect())
    }

    /// Covariance of each row's field, nT², from errors of the readings that are independent from row to row
    /// and between sensors, with these variances, nT². Where the chain remembers, the errors of the rows
    /// around are in it.
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

    /// The same passes as for the field, with derivatives carried along in so many lanes: by one parameter in
    /// each; without parameters, by the readings of each row, which change along a direction in each lane, in
    /// nT along the sensors.
    fn derivatives(
        &self,
        parameters: &[Parameter],
        lanes: usize,
        direction: impl Fn(usize, usize) -> Vector3<f64>,
    ) -> Result<Vec<Vec<Vector3<f64>>>, Error> {
        let sensitivity = self.inverter.basic.sensors.map(|sensor| sensor.sensitivity);
        let (mut basic, mut values) = (self.inverter.basic.lift(), self.inverter.values());
        seed(self.inverter.basic, &mut basic, &mut values, parameters);
        let mut derivatives = vec![vec![Vector3::zeros(); self.rows.len()]; lanes];
        for pass in 0..PASSES {
            // Where neither a parameter nor yet the field has a derivative, the readings have none.
            let still = pass == 0 && parameters.is_empty();
            let readings = if still { None } else { Some(self.pass(&basic, &values, &derivatives)?) };
            let (mut moved, mut largest): (f64, f64) = (0.0, 0.0);
            for (lane, derivative) in derivatives.iter_mut().enumerate() {
                let difference: Vec<Vector3<f64>> = (0..self.rows.len())
                    .map(|row| {
                        let reading = readings.as_ref().map(|readings| &readings[row]);
                        let finite = reading.is_none_or(|reading| reading.iter().all(lanes::is_finite));
                        if self.rows[row] == Row::Missing || !finite {
                            return Vector3::zeros();
                        }
                        let slope = |i: usize| {
                            reading.map_or(0.0, |reading| lanes::slope(&reading[i], lane) * sensitivity[i])
                        };
                        direction(row, lane) - Vector3::from_fn(|i, _| slope(i))
                    })
                    .collect();
                let change = self.step.of(&difference);
                for (row, derivative) in derivative.iter_mut().enumerate() {
                    *derivative += change[row];
                    if self.rows[row] == Row::Found {
                        moved = moved.max(change[row].amax());
                        largest = largest.max(derivative.amax());
                    }
                }
            }
            if moved <= TOLERANCE * largest || self.is_exact() {
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

    /// The readings of the field with what is known of its derivatives.
    fn pass(
        &self,
        basic: &Basic<Dual>,
        values: &[Vec<Dual>],
        derivatives: &[Vec<Vector3<f64>>],
    ) -> Result<Vec<Vector3<Dual>>, Error> {
        let by = |row: usize, k: usize, lane: usize| derivatives.get(lane).map_or(0.0, |of| of[row][k]);
        let field: Vec<Vector3<Dual>> = self
            .at
            .iter()
            .enumerate()
            .map(|(row, at)| Vector3::from_fn(|k, _| lanes::dual(at[k], |lane| by(row, k, lane))))
            .collect();
        self.inverter.read(basic, values, &field)
    }
}
