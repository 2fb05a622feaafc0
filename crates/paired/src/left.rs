//! What an explanation leaves of a channel, and what it is held against; orthonormal columns.

use estimate::{Error, dot, stats};
use explain::{Explained, Problem, filter};
use noise::Whitening;

use crate::courses::Sensors;

/// A column of which the others leave less than this share of the square follows from them.
const INDEPENDENT: f64 = 1e-12;

/// What is left of a channel.
pub struct Left<'a> {
    /// As it is.
    pub left: &'a [f64],
    /// By the filter of its own spectrum, of variance one, and what it was divided by.
    pub filter: Whitening,
    pub white: Vec<f64>,
    size: f64,
    /// The field in the readings, and each part of them that has a cause.
    pub field: Vec<f64>,
    pub parts: Vec<&'a [f64]>,
}

impl<'a> Left<'a> {
    /// None where it is too short for a spectrum.
    /// Refused: times out of order.
    pub fn of(
        problem: &Problem,
        sensors: &Sensors,
        explained: &'a Explained,
        channel: usize,
    ) -> Result<Option<Self>, Error> {
        let left = &explained.residual[channel];
        let Some(filter) = filter(&problem.time_s, left, problem.step_s())? else { return Ok(None) };
        let mut white = filter.whiten(left);
        let size = (dot(&white, &white) / white.len() as f64).sqrt();
        white.iter_mut().for_each(|value| *value /= size);
        let mut field = sensors.seen(problem, channel, left);
        let middle = stats::mean(&field);
        field.iter_mut().for_each(|value| *value -= middle);
        let parts = explained.contributions.iter().map(|of| of[channel].as_slice()).collect();
        Ok(Some(Self { left, filter, white, size, field, parts }))
    }

    /// Sine and cosine parts of a series, whitened in the same way.
    pub fn wave_of(&self, waves: &[Vec<f64>; 2], series: &[f64]) -> [f64; 2] {
        let white = self.filter.whiten(series);
        waves.each_ref().map(|wave| dot(wave, &white) / self.size)
    }
}

/// Orthonormal columns that span some.
pub fn basis(columns: impl IntoIterator<Item = Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let whole = dot(&column, &column);
        basis.iter().for_each(|known| without(&mut column, known));
        let square = dot(&column, &column);
        if square > INDEPENDENT * whole {
            let size = square.sqrt();
            column.iter_mut().for_each(|value| *value /= size);
            basis.push(column);
        }
    }
    basis
}

/// Takes what is along a column of length one out of a series.
pub fn without(series: &mut [f64], column: &[f64]) {
    let part = dot(column, series);
    series.iter_mut().zip(column).for_each(|(value, along)| *value -= part * along);
}
