//! Recordings in which the field is known with its direction.

use common::Document;
use estimate::Svd;
use faer::ColRef;
use nalgebra::{Matrix3, Vector3};
use physics::{Context, References};
use rayon::prelude::*;
use std::ops::Range;

use crate::Error;
use crate::design::Rows;
use crate::directions::unmixed;
use crate::factor::{Factor, compressed};
use crate::linear::RANK_TOLERANCE;
use crate::model::{Model, State, own};
use crate::moment::{About, Moment, Spread};
use crate::noise::{Group, Groups};
use crate::read::{Series, Source};

/// Rows that are filtered one by one; of longer recordings groups of rows are.
const FILTERED: usize = 8192;
/// Rows that one thread takes at a time.
const CHUNK: usize = 4096;

/// The known field of each recording.
pub struct Vectors<'a> {
    rows: Rows<'a>,
    contexts: Vec<Context<'a>>,
    /// Whether a scalar magnetometer reads beside: only what is across the field is used.
    pub scalar: bool,
    /// Share of the noise of a residual that is the field's, not the sensors'.
    pub share: f64,
}

/// Where the iteration begins.
pub struct Start {
    /// The directions by linear least squares.
    pub mu: Matrix3<f64>,
    /// Rms of their residuals.
    pub rms: f64,
    /// That of the residuals with the inverse attitude.
    pub inverse_rms: f64,
}

impl<'a> Vectors<'a> {
    /// Field and attitude of the recordings.
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

    /// Each sensor by linear least squares on the field: V = a·B + c, a along the sensor.
    pub fn start(&self, model: &Model) -> Result<Start, Error> {
        let nominal = model.nominal();
        let of = |inverse: bool| {
            let mut factor = Factor::new(7);
            let rows = self.rows.places();
            let moments = rows.filter_map(|(number, row)| self.moment(model, &nominal, number, row));
            for Moment { z, field, rotation, .. } in moments {
                let turn = rotation.transpose();
                let field = if inverse { turn * turn * field } else { field };
                factor.row([field.x, field.y, field.z, 1.0, z[0], z[1], z[2]]);
            }
            factor.finish()
        };
        let fitted = |inverse: bool| -> Result<(Matrix3<f64>, f64), Error> {
            let factor = of(inverse);
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
        let inverse_rms = fitted(true).map_or(f64::INFINITY, |(_, rms)| rms);
        Ok(Start { mu, rms, inverse_rms })
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
        let all = self.each(CHUNK, of_chunk).into_iter().flatten().fold([0.0; 4], add);
        let [moments, along, across, squares] = all;
        let count = moments.max(1.0);
        let [along, across, square] =
            [along, across, squares].map(|sum| (sum / count).max(f64::MIN_POSITIVE));
        Spread { along, across, attitude: ((across - along) / square).max(0.0), moments: moments as usize }
    }

    /// Something of each so many rows of each recording.
    fn each<T: Send>(&self, rows: usize, of: impl Fn(usize, Range<usize>) -> T + Sync) -> Vec<Vec<T>> {
        let of_recording = |(number, series): (usize, &Series)| {
            let starts: Vec<usize> = (0..series.len()).step_by(rows).collect();
            starts.into_par_iter().map(|from| of(number, from..(from + rows).min(series.len()))).collect()
        };
        self.rows.series.iter().enumerate().map(of_recording).collect()
    }

    /// The rows about a state, as those of the magnitude: residual, derivatives, and what a row reads of the
    /// noise of the field in GEO.
    pub fn groups(&self, model: &Model, state: &State, mu: &Matrix3<f64>, spread: Spread) -> Groups {
        let count = model.parameters.len();
        let about = About::new(model, state, mu, (self.share, self.scalar), spread);
        let total: usize = self.rows.series.iter().map(Series::len).sum();
        let width = count + 4;
        let each = if total * 3 <= FILTERED { 1 } else { (total * width).div_ceil(FILTERED) };
        let of = |number: usize, rows: Range<usize>| -> (usize, Group) {
            let (from, last) = (rows.start, rows.end - 1);
            let moments = rows.filter_map(|row| self.moment(model, state, number, row));
            let all: Vec<Vec<f64>> = moments.flat_map(|moment| about.rows(&moment)).collect();
            let time = self.rows.series[number].time_s.as_deref();
            let time_s = time.map_or(0.0, |time| 0.5 * (time[from] + time[last]));
            (all.len(), Group::at(time_s, compressed(all, width)))
        };
        let groups = self.each(each, of);
        let read: usize = groups.iter().flatten().map(|(count, _)| count).sum();
        let recordings = groups.into_iter().map(|all| all.into_iter().map(|(_, group)| group).collect());
        Groups::of_rows(recordings.collect(), count + 1, read as f64)
    }
}
