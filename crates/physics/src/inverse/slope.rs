//! ∂F/∂B from the same chain in dual numbers.

use nalgebra::Vector3;
use num_dual::Dual64;

use super::Inverter;
use super::band::Band;
use crate::Error;

impl Inverter<'_> {
    /// The derivative of the readings, in nT, along one direction of the fields.
    fn along(
        &self,
        field: &[Vector3<f64>],
        direction: impl Fn(usize) -> Vector3<f64>,
    ) -> Result<Vec<Vector3<f64>>, Error> {
        let seeded: Vec<Vector3<Dual64>> = field
            .iter()
            .enumerate()
            .map(|(row, field)| {
                let direction = direction(row);
                Vector3::from_fn(|k, _| Dual64::new(field[k], direction[k]))
            })
            .collect();
        let readings = self.read(&self.basic.lift(), &self.values(), &seeded)?;
        let scale = |reading: &Vector3<Dual64>| {
            Vector3::from_fn(|i, _| reading[i].eps * self.basic.sensors[i].sensitivity)
        };
        Ok(readings.iter().map(scale).collect())
    }

    /// Whether a reading depends on the field of another row.
    pub(super) fn remembers(&self, field: &[Vector3<f64>]) -> Result<bool, Error> {
        if self.is_affine() || field.len() < 2 {
            return Ok(false);
        }
        let even = self.along(field, |row| Vector3::repeat(f64::from(u8::from(row % 2 == 0))))?;
        let remembered =
            |reading: &Vector3<f64>| reading.iter().any(|slope| slope.is_finite() && *slope != 0.0);
        Ok(even.iter().skip(1).step_by(2).any(remembered))
    }

    /// ∂F/∂B over rows no further apart than `reach`: rows 2 reach + 1 apart share a pass of dual numbers.
    pub(super) fn slope(&self, field: &[Vector3<f64>], reach: usize) -> Result<Band, Error> {
        let apart = 2 * reach + 1;
        let mut passes: Vec<Vec<Vector3<f64>>> = Vec::with_capacity(3 * apart);
        for (colour, component) in (0..3 * apart).map(|k| (k / 3, k % 3)) {
            let direction = |row: usize| {
                if row % apart == colour { Vector3::ith(component, 1.0) } else { Vector3::zeros() }
            };
            passes.push(self.along(field, direction)?);
        }
        let known: Vec<bool> = field.iter().map(|row| row.iter().all(|value| value.is_finite())).collect();
        Ok(Band::new(field.len(), reach, |row, component, other, of| {
            let slope = passes[3 * (other % apart) + of][row][component];
            match known[row] && known[other] && slope.is_finite() {
                true => slope,
                false => f64::from(u8::from(row == other && component == of)),
            }
        }))
    }
}
