//! Recordings in which the field is known with its direction, and the rows of their moments.

use common::Document;
use estimate::Svd;
use faer::ColRef;
use nalgebra::{Matrix3, Vector3};
use physics::{Context, References};
use std::ops::Range;

use crate::Error;
use crate::design::Rows;
use crate::directions::{directions_by, unmixed};
use crate::linear::RANK_TOLERANCE;
use crate::model::{Model, Parameter, State, own};
use crate::noise::{Group, Groups};
use crate::read::{Series, Source};
use crate::terms::Factor;

/// The attitude is the inverse one where that leaves less than this share of the residual.
const INVERSE: f64 = 0.1;
/// Rows that are filtered one by one; of longer recordings groups of rows are.
const FILTERED: usize = 8192;
/// Rows that one thread takes at a time.
const CHUNK: usize = 4096;

/// A moment: what the sensors read, and the field that is known.
pub struct Moment {
    pub own: [f64; 3],
    pub z: Vec<f64>,
    /// In SEN, over the typical magnitude.
    pub field: Vector3<f64>,
    pub rotation: Matrix3<f64>,
}

/// How much rows err: variances over the square of the typical magnitude.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    pub along: f64,
    pub across: f64,
    /// What the attitude adds across it, by the square of the field.
    pub attitude: f64,
    pub moments: usize,
}

/// What makes rows of a moment about a state with its directions, by the share of the field in the noise:
/// along the field, which is left out beside a scalar magnetometer, and twice across it. A row has what is to
/// be explained, its derivatives, and what it reads of the noise of the field in GEO. The derivatives are
/// taken at the most likely field and reading: at what was read, they would be correlated with the residual.
pub fn rows_about<'s>(
    model: &'s Model,
    state: &'s State,
    mu: &'s Matrix3<f64>,
    (share, scalar): (f64, bool),
    spread: Spread,
) -> impl Fn(&Moment) -> Vec<Vec<f64>> + Sync + 's {
    let (inverse, by) = (unmixed(mu), directions_by(model, state, mu));
    move |moment| {
        let field = &moment.field;
        let off = Vector3::from(moment.own) - mu.transpose() * field;
        let likely = field + share * (inverse * off);
        let own = Vector3::from(moment.own) - (1.0 - share) * off;
        let derivative = |(j, parameter): (usize, &Parameter)| -> Vector3<f64> {
            match parameter {
                Parameter::Sensitivity(axis) => {
                    let read = moment.z[*axis] + (own[*axis] - moment.own[*axis]) / state[*axis];
                    Vector3::ith(*axis, read)
                }
                Parameter::Offset(axis) => Vector3::ith(*axis, 1.0),
                Parameter::Effect { follows, .. } => Vector3::from_fn(|axis, _| {
                    follows[axis].map_or(0.0, |(column, factor)| -factor * moment.z[column])
                }),
                _ => by[j].map_or_else(Vector3::zeros, |by| -(by.transpose() * likely)),
            }
        };
        let derivatives: Vec<Vector3<f64>> = model.parameters.iter().enumerate().map(derivative).collect();
        let unit = field.normalize();
        let first = unit.cross(&Vector3::ith(unit.iamin(), 1.0)).normalize();
        let attitude = spread.attitude * field.norm_squared();
        let across = (spread.along / (spread.along + attitude)).sqrt();
        let all = [(unit, 1.0), (first, across), (unit.cross(&first), across)];
        let of = |(direction, weight): (Vector3<f64>, f64)| {
            let along = weight * (inverse.transpose() * direction);
            let geo = weight * (moment.rotation.transpose() * direction);
            std::iter::once(-along.dot(&off))
                .chain(derivatives.iter().map(|by| along.dot(by)))
                .chain(geo.iter().copied())
                .collect()
        };
        all.into_iter().skip(usize::from(scalar)).map(of).collect()
    }
}

pub struct Vectors<'a> {
    rows: Rows<'a>,
    contexts: Vec<Context<'a>>,
    /// Whether a scalar magnetometer reads beside: only what is across the field is used.
    pub scalar: bool,
    /// Share of the noise of a residual that is the field's, not the sensors'.
    pub share: f64,
}

impl<'a> Vectors<'a> {
    pub fn read(document: &'a Document, rows: Rows<'a>) -> Result<Self, Error> {
        let references = References::of(document);
        let mut contexts = Vec::new();
        for one in rows.series {
            let recording = &document.recordings[one.index];
            let refused = |error: physics::Error| error.at(&one.path());
            let context = Context::new(document, recording, references).map_err(refused)?;
            let lacks = |what: &str, expected: &str| {
                let found = format!("no {what} beside the readings of \"{}\"", one.id);
                Err(Error::document(format!("{}.columns", one.path()), found, expected))
            };
            if context.ambient_nt.len() < context.rows && context.ambient(0).norm() == 0.0 {
                let expected = "`ambient_x_nt`, `ambient_y_nt`, `ambient_z_nt`, in GEO, for --vector";
                return lacks("known field", expected);
            }
            let conditions = &recording.conditions;
            let stated = conditions.orientation.is_some() || conditions.theodolite.is_some();
            if context.attitude.is_empty() && !stated {
                let expected = "`attitude_w`, `attitude_x`, `attitude_y`, `attitude_z` (GEO → SEN) or `conditions.orientation`, for --vector";
                return lacks("attitude", expected);
            }
            contexts.push(context);
        }
        let scalar = rows.series.iter().all(|one| one.source == Source::Scalar);
        Ok(Self { rows, contexts, scalar, share: 0.0 })
    }

    /// A row of a recording; None where field or attitude are missing.
    fn moment(&self, model: &Model, state: &State, number: usize, row: usize) -> Option<Moment> {
        let series = &self.rows.series[number];
        let context = &self.contexts[number];
        let rotation = context.rotation(series.rows[row]);
        let field = rotation * context.ambient(series.rows[row]) / self.rows.scales.magnitude_nt;
        if !field.iter().all(|value| value.is_finite()) || field.norm() == 0.0 {
            return None;
        }
        let z = self.rows.z(number, row);
        let own = own(&model.along(state), &z);
        Some(Moment { own, z, field, rotation })
    }

    /// The directions by linear least squares of each sensor on the field, V = a·B + c, a along the sensor;
    /// and whether the inverse of the attitude explains the readings far better.
    pub fn start(&self, model: &Model) -> Result<(Matrix3<f64>, bool), Error> {
        let nominal = model.nominal();
        let fitted = |inverse: bool| -> Result<(Matrix3<f64>, f64), Error> {
            let mut factor = Factor::new(7);
            let rows = self.rows.places();
            let moments = rows.filter_map(|(number, row)| self.moment(model, &nominal, number, row));
            for Moment { z, field, rotation, .. } in moments {
                let turn = rotation.transpose();
                let field = if inverse { turn * turn * field } else { field };
                factor.row([field.x, field.y, field.z, 1.0, z[0], z[1], z[2]]);
            }
            factor.settle();
            let upper = factor.upper();
            let svd = Svd::of(upper.subcols(0, 4), RANK_TOLERANCE)?;
            let mut mu = Matrix3::zeros();
            let mut squares = 0.0;
            for axis in 0..3 {
                let x = svd.solve(upper.col_as_slice(4 + axis));
                let left = upper.col(4 + axis) - upper.subcols(0, 4) * ColRef::from_slice(&x);
                squares += left.squared_norm_l2();
                mu.set_column(axis, &Vector3::new(x[0], x[1], x[2]));
            }
            if svd.rank() < 4 || (0..3).any(|axis| mu.column(axis).norm() == 0.0) {
                let message = "the known field, rotated by the attitude, lies in one plane of SEN, which does not determine the calibration. \
                               Record more attitudes, so that the field lies along each sensor in both directions";
                return Err(Error::Unanswerable(message.into()));
            }
            for axis in 0..3 {
                mu.column_mut(axis).normalize_mut();
            }
            Ok((mu, (squares / factor.rows as f64).sqrt()))
        };
        let (mu, rms) = fitted(false)?;
        let inverse = fitted(true).is_ok_and(|(_, inverse)| inverse < INVERSE * rms);
        Ok((mu, inverse))
    }

    /// How the residuals scatter along the field and across it.
    pub fn spread(&self, model: &Model, state: &State, mu: &Matrix3<f64>) -> Spread {
        let inverse = unmixed(mu);
        let of = |number: usize, row: usize| -> Option<[f64; 4]> {
            let moment = self.moment(model, state, number, row)?;
            let off = inverse * Vector3::from(moment.own) - moment.field;
            let part = off.dot(&moment.field.normalize()).powi(2);
            Some([1.0, part, 0.5 * (off.norm_squared() - part), moment.field.norm_squared()])
        };
        let add = |sums: [f64; 4], more: [f64; 4]| std::array::from_fn(|k| sums[k] + more[k]);
        let of_chunk =
            |number: usize, rows: Range<usize>| rows.filter_map(|row| of(number, row)).fold([0.0; 4], add);
        let all = self.rows.each(CHUNK, of_chunk).into_iter().flatten().fold([0.0; 4], add);
        let [moments, along, across, squares] = all;
        let count = moments.max(1.0);
        let [along, across, square] =
            [along, across, squares].map(|sum| (sum / count).max(f64::MIN_POSITIVE));
        Spread { along, across, attitude: ((across - along) / square).max(0.0), moments: moments as usize }
    }

    /// The rows about a state: residual, derivatives, and what a row reads of the noise of the field in GEO.
    pub fn groups(&self, model: &Model, state: &State, mu: &Matrix3<f64>, spread: Spread) -> Groups {
        let count = model.parameters.len();
        let rows_of = rows_about(model, state, mu, (self.share, self.scalar), spread);
        let total: usize = self.rows.series.iter().map(Series::len).sum();
        let width = count + 4;
        let each = if total * 3 <= FILTERED { 1 } else { (total * width).div_ceil(FILTERED) };
        let of = |number: usize, rows: Range<usize>| -> (usize, Group) {
            let moments = rows.clone().filter_map(|row| self.moment(model, state, number, row));
            let all: Vec<Vec<f64>> = moments.flat_map(|moment| rows_of(&moment)).collect();
            (all.len(), Group::of(&self.rows.series[number], rows, all, width))
        };
        let groups = self.rows.each(each, of);
        let read: usize = groups.iter().flatten().map(|(count, _)| count).sum();
        let recordings = groups.into_iter().map(|all| all.into_iter().map(|(_, group)| group).collect());
        Groups::of_rows(recordings.collect(), count + 1, read as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::{frame, turned};
    use crate::terms::ONE;

    #[test]
    fn rows_move_as_their_derivatives_say() {
        let effect = Parameter::Effect {
            number: [0, 0],
            unit: 1.0,
            follows: [Some((4, 1.0)), None, Some((4, 0.7))],
            name: String::new(),
        };
        let turns = (0..3).map(Parameter::Turn);
        let model = Model::new(ONE + 2, std::iter::once(effect).chain(turns));
        let state = vec![1.1, 0.9, 1.02, 0.01, -0.02, 0.03, 0.05, -0.04, 0.02, 0.3, 0.0, 0.0, 0.0];
        let mu = frame(&state, &Matrix3::new(0.0, 1.0, 0.1, -1.0, 0.0, 0.0, 0.0, 0.1, 1.0));
        let z = vec![0.4, -0.3, 0.8, 1.0, 0.2, 0.97];
        // A field that explains the readings: where it does not, the weights move as well.
        let along = Vector3::from(own(&model.along(&state), &z));
        let field = mu.transpose().try_inverse().expect("axes") * along;
        let spread = Spread { along: 1e-8, across: 3e-8, attitude: 2e-8, moments: 1 };
        let rows = |state: &[f64]| {
            let (state, mu) = (state.to_vec(), turned(&state.to_vec(), 10, &mu));
            let own = own(&model.along(&state), &z);
            let moment = Moment { own, z: z.clone(), field, rotation: Matrix3::identity() };
            rows_about(&model, &state, &mu, (0.5, false), spread)(&moment)
        };
        // What is to be explained falls as the residual rises.
        let residuals = |state: &[f64]| rows(state).iter().map(|row| -row[0]).collect();
        let at = rows(&state);
        let columns: Vec<Vec<f64>> =
            (0..state.len()).map(|j| at.iter().map(|row| row[1 + j]).collect()).collect();
        testkit::check_jacobian(residuals, &state, &[1e-4; 13], &columns, 1e-8);
    }
}
