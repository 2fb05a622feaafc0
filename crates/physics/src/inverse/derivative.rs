//! Derivatives of a field that was found, by what it was found with.

use nalgebra::{Matrix3, Vector3};
use num_dual::Dual64;

use super::{PASSES, REACHES, Row, Solved, Step};
use crate::chain::seed;
use crate::{Basic, Error, Parameter};

/// A derivative has settled when a pass changes it by no more than this share of its largest value.
const TOLERANCE: f64 = 1e-9;

impl Solved<'_> {
    /// ∂B/∂θ for each row, nT per unit of the parameter, the readings held: F(B, θ) = y gives ∂F/∂B · ∂B/∂θ = −∂F/∂θ. NaN where
    /// there is no field.
    pub fn by_parameter(&self, parameter: Parameter) -> Result<Vec<Vector3<f64>>, Error> {
        let mut basic: Basic<Dual64> = self.inverter.basic.lift();
        let mut values = self.inverter.values();
        seed(self.inverter.basic, &mut basic, &mut values, parameter);
        self.derivative(&basic, &values, |_| Vector3::zeros())
    }

    /// ∂B/∂y along `direction`, a change of each row's readings in nT along the sensors.
    pub fn by_readings(&self, direction: impl Fn(usize) -> Vector3<f64>) -> Result<Vec<Vector3<f64>>, Error> {
        self.derivative(&self.inverter.basic.lift(), &self.inverter.values(), direction)
    }

    /// Covariance of each row's field, nT², from errors of the readings that are independent from row to row and between
    /// sensors, with these variances, nT². Where the chain remembers, the errors of the rows around are in it.
    pub fn covariance_of_readings(&self, variance_nt2: Vector3<f64>) -> Result<Vec<Matrix3<f64>>, Error> {
        let apart = match &self.step {
            Step::Band(band) if band.reach() > 0 => 2 * band.reach().max(2 * REACHES[0]) + 1,
            _ => 1,
        };
        let mut covariance = vec![Matrix3::zeros(); self.rows.len()];
        for (colour, sensor) in (0..3 * apart).map(|k| (k / 3, k % 3)) {
            let std = variance_nt2[sensor].sqrt();
            let direction = |row: usize| {
                if row % apart == colour { Vector3::ith(sensor, std) } else { Vector3::zeros() }
            };
            for (covariance, error) in covariance.iter_mut().zip(self.by_readings(direction)?) {
                *covariance += error * error.transpose();
            }
        }
        Ok(covariance)
    }

    /// Whether S is the whole inverse of ∂F/∂B, so that one pass is all.
    fn is_exact(&self) -> bool {
        match &self.step {
            Step::Unmix(_) => self.inverter.is_affine(),
            Step::Band(band) => band.reach() == 0,
        }
    }

    /// The same passes as for the field, with the derivative carried along.
    fn derivative(
        &self,
        basic: &Basic<Dual64>,
        values: &[Vec<Dual64>],
        direction: impl Fn(usize) -> Vector3<f64>,
    ) -> Result<Vec<Vector3<f64>>, Error> {
        let sensitivity = self.inverter.basic.sensors.map(|sensor| sensor.sensitivity);
        let mut derivative = vec![Vector3::zeros(); self.rows.len()];
        for _ in 0..PASSES {
            let field: Vec<Vector3<Dual64>> = self
                .at
                .iter()
                .zip(&derivative)
                .map(|(at, by): (&Vector3<f64>, &Vector3<f64>)| {
                    Vector3::from_fn(|k, _| Dual64::new(at[k], by[k]))
                })
                .collect();
            let readings = self.inverter.read(basic, values, &field)?;
            let difference: Vec<Vector3<f64>> = readings
                .iter()
                .enumerate()
                .map(|(row, reading)| {
                    if self.rows[row] == Row::Missing || !reading.iter().all(|value| value.eps.is_finite()) {
                        return Vector3::zeros();
                    }
                    direction(row) - Vector3::from_fn(|i, _| reading[i].eps * sensitivity[i])
                })
                .collect();
            let change = self.step.of(&difference);
            let (mut moved, mut largest): (f64, f64) = (0.0, 0.0);
            for (row, derivative) in derivative.iter_mut().enumerate() {
                *derivative += change[row];
                if self.rows[row] == Row::Found {
                    moved = moved.max(change[row].amax());
                    largest = largest.max(derivative.amax());
                }
            }
            if moved <= TOLERANCE * largest || self.is_exact() {
                break;
            }
        }
        let found = |row: usize| self.rows[row] == Row::Found;
        let missing = Vector3::repeat(f64::NAN);
        Ok((0..self.rows.len()).map(|row| if found(row) { derivative[row] } else { missing }).collect())
    }
}
