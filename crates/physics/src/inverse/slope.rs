//! ∂F/∂B from the same chain in dual numbers.

use nalgebra::{Matrix3, Vector3};

use super::Inverter;
use super::band::{Band, UNSEEN};
use crate::Error;
use crate::chain::values;
use crate::lanes::{self, Dual, LANES};

impl Inverter<'_> {
    /// The derivatives of the readings, in nT, along directions of the fields, one for each lane.
    fn along(
        &self,
        field: &[Vector3<f64>],
        lanes: usize,
        direction: impl Fn(usize, usize) -> Vector3<f64>,
    ) -> Result<Vec<Vec<Vector3<f64>>>, Error> {
        let seed = |(row, field): (usize, &Vector3<f64>)| -> Vector3<Dual> {
            let by: [Vector3<f64>; LANES] =
                std::array::from_fn(
                    |lane| {
                        if lane < lanes { direction(row, lane) } else { Vector3::zeros() }
                    },
                );
            Vector3::from_fn(|k, _| lanes::dual(field[k], |lane| by[lane][k]))
        };
        let seeded: Vec<Vector3<Dual>> = field.iter().enumerate().map(seed).collect();
        let readings = self.read(&self.basic.lift(), &values(self.effects), &seeded)?;
        let of = |reading: &Vector3<Dual>, lane: usize| {
            Vector3::from_fn(|i, _| lanes::slope(&reading[i], lane) * self.basic.sensors[i].sensitivity)
        };
        Ok((0..lanes).map(|lane| readings.iter().map(|reading| of(reading, lane)).collect()).collect())
    }

    /// Whether a reading depends on the field of another row.
    pub(super) fn remembers(&self, field: &[Vector3<f64>]) -> Result<bool, Error> {
        if self.effects.iter().all(|effect| effect.kind.row_by_row()) || field.len() < 2 {
            return Ok(false);
        }
        let even = self.along(field, 1, |row, _| Vector3::repeat(f64::from(u8::from(row % 2 == 0))))?;
        let remembered =
            |reading: &Vector3<f64>| reading.iter().any(|slope| slope.is_finite() && *slope != 0.0);
        Ok(even[0].iter().skip(1).step_by(2).any(remembered))
    }

    /// (∂F/∂B)⁻¹ in each row, where rows are independent; of what is not shown, nothing (see [`Band`]).
    pub(super) fn inverses(&self, field: &[Vector3<f64>]) -> Result<Vec<Matrix3<f64>>, Error> {
        let passes = self.along(field, 3, |_, lane| Vector3::ith(lane, 1.0))?;
        let inverse = |row: usize| {
            let slope = Matrix3::from_columns(&[passes[0][row], passes[1][row], passes[2][row]]);
            if !slope.iter().all(|slope| slope.is_finite()) {
                return Matrix3::identity();
            }
            let transposed = slope.transpose();
            let damped = transposed * slope + Matrix3::identity() * UNSEEN.powi(2);
            damped.try_inverse().map_or_else(Matrix3::identity, |inverse| inverse * transposed)
        };
        Ok((0..field.len()).map(inverse).collect())
    }

    /// ∂F/∂B over rows no further apart than `reach`: rows 2 reach + 1 apart share a pass of dual numbers.
    pub(super) fn slope(&self, field: &[Vector3<f64>], reach: usize) -> Result<Band, Error> {
        let apart = 2 * reach + 1;
        let colours: Vec<(usize, usize)> = (0..3 * apart).map(|k| (k / 3, k % 3)).collect();
        let mut passes: Vec<Vec<Vector3<f64>>> = Vec::with_capacity(colours.len());
        for colours in colours.chunks(LANES) {
            let direction = |row: usize, lane: usize| {
                let (colour, component) = colours[lane];
                Vector3::ith(component, f64::from(u8::from(row % apart == colour)))
            };
            passes.extend(self.along(field, colours.len(), direction)?);
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
