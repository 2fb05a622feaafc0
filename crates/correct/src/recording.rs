//! One recording corrected.

use common::{Axis, Document, Recording, Uncertainty};
use nalgebra::{Matrix3, SMatrix, Vector3, Vector4};
use physics::{Context, Direction, EffectInstance, Inverter, References, Row, Setting, Stage, Unit};
use rayon::prelude::*;

use crate::flags::{self, Limits};
use crate::known;
use crate::noise;
use crate::{Error, Frame};

/// The field of a recording, row by row.
#[derive(Clone, Debug, Default)]
pub struct Corrected {
    /// The field, nT; NaN where there is none.
    pub field_nt: [Vec<f64>; 3],
    /// The standard uncertainty of each component, nT.
    pub std_nt: [Vec<f64>; 3],
    /// Sums of [`flags`].
    pub flags: Vec<u32>,
    /// Effects of the model that could not be taken out, and why.
    pub left: Vec<String>,
}

impl Corrected {
    /// As many rows of which the chain hides the field.
    pub fn not_invertible(rows: usize) -> Self {
        let none = || [0, 1, 2].map(|_| vec![f64::NAN; rows]);
        let flags = vec![flags::NOT_INVERTIBLE; rows];
        Self { field_nt: none(), std_nt: none(), flags, left: Vec::new() }
    }

    /// Pieces of one recording, in their order.
    pub fn joined(pieces: Vec<Self>) -> Self {
        let mut whole = Self::default();
        for piece in pieces {
            for k in 0..3 {
                whole.field_nt[k].extend(&piece.field_nt[k]);
                whole.std_nt[k].extend(&piece.std_nt[k]);
            }
            whole.flags.extend(piece.flags);
            whole.left = piece.left;
        }
        whole
    }

    /// Whether any row has a field.
    pub fn has_field(&self) -> bool {
        self.field_nt[0].iter().any(|value| value.is_finite())
    }

    /// The columns in the order of [`Frame::columns`].
    pub fn into_columns(self) -> [Vec<f64>; 7] {
        let [x, y, z] = self.field_nt;
        let [sx, sy, sz] = self.std_nt;
        [x, y, z, sx, sy, sz, self.flags.iter().map(|flags| f64::from(*flags)).collect()]
    }
}

/// All that a document says of the correction.
pub struct Corrector<'a> {
    document: &'a Document,
    joint: Uncertainty,
    effects: Vec<EffectInstance>,
    references: References,
    limits: Limits,
    frame: Frame,
}

impl<'a> Corrector<'a> {
    /// Reads a document's calibration and model.
    pub fn of(document: &'a Document, frame: Frame) -> Result<Self, Error> {
        let effects = physics::adopt(document).map_err(|error| error.at("model"))?;
        let references = References::stated(document);
        let joint = Uncertainty::of(document)?;
        Ok(Self { document, joint, effects, references, limits: Limits::of(document, &references), frame })
    }

    /// Whether a long recording may be corrected piece by piece.
    pub fn row_by_row(&self) -> bool {
        self.effects.iter().all(|effect| effect.kind.row_by_row())
    }

    /// Corrects a recording that stands at `path`. `length_and_step_s` is of the whole series where this is a
    /// piece of it.
    pub fn correct(
        &self,
        recording: &Recording,
        path: &str,
        length_and_step_s: Option<[f64; 2]>,
    ) -> Result<Corrected, Error> {
        if crate::variometer::is_by_baselines(self.document, recording) {
            return crate::variometer::correct(self.document, recording, path, length_and_step_s);
        }
        let at = |error: physics::Error| error.at(path);
        let Setting { basic, context } =
            Setting::of(self.document, recording, self.references).map_err(at)?;
        let readings = readings(recording, context.unit, context.rows);
        let series =
            length_and_step_s.or_else(|| recording.column("time_s").and_then(noise::length_and_step_s));
        let noise_nt2 = Vector3::from(Axis::ALL.map(|axis| {
            let k = basic.sensors[axis.index()].sensitivity;
            noise::variance_nt2(self.document, axis, context.unit, k, series)
        }));
        // What acts before the field, and in other recordings, is nothing to take out of these readings.
        let acts =
            |effect: &EffectInstance| effect.kind.about().stage >= Stage::Block && effect.acts(recording);
        let mut acting: Vec<(usize, EffectInstance)> =
            self.effects.iter().cloned().enumerate().filter(|(_, effect)| acts(effect)).collect();
        let mut left = Vec::new();
        let solution = loop {
            let (places, effects): (Vec<usize>, Vec<EffectInstance>) = acting.iter().cloned().unzip();
            let sources = known::sources(self.document, &self.joint, (&effects, &places), context.unit)?;
            let solved = Inverter::new(&basic, &effects, &context)
                .and_then(|inverter| Solution::of(inverter, &sources, noise_nt2, &readings));
            match solved {
                Err(physics::Error::Missing { who, what, .. })
                    if acting.iter().any(|(_, effect)| effect.kind.name() == who) =>
                {
                    acting.retain(|(_, effect)| effect.kind.name() != who);
                    left.push(format!("{who} is not corrected: {what} is missing"));
                }
                Err(error @ physics::Error::Hidden { .. }) => {
                    return Err(Error::Unanswerable(error.to_string()));
                }
                other => break other.map_err(at)?,
            }
        };
        let mut common = self.limits.temperatures(&context);
        if !left.is_empty() {
            common.iter_mut().for_each(|flags| *flags |= flags::EFFECT_LEFT);
        }
        let rows: Vec<CorrectedRow> = (0..context.rows)
            .into_par_iter()
            .map(|row| {
                let (field, covariance) = match solution.row(row, &readings[row]) {
                    Ok(found) => found,
                    Err(flag) => return ([f64::NAN; 3], [f64::NAN; 3], flag | common[row]),
                };
                let flag = self.limits.field(&(basic.mu.transpose() * field));
                let (field, covariance) = match self.frame {
                    Frame::Sen => (field, covariance),
                    Frame::Geo => in_geo(&context, row, &field, &covariance),
                };
                let std = [0, 1, 2].map(|k| covariance[(k, k)].max(0.0).sqrt());
                (field.into(), std, flag | common[row])
            })
            .collect();
        Ok(Corrected {
            field_nt: [0, 1, 2].map(|k| rows.iter().map(|row| row.0[k]).collect()),
            std_nt: [0, 1, 2].map(|k| rows.iter().map(|row| row.1[k]).collect()),
            flags: rows.iter().map(|row| row.2).collect(),
            left,
        })
    }
}

/// Field, standard uncertainties, flags.
type CorrectedRow = ([f64; 3], [f64; 3], u32);

/// The fields of a recording with their covariances.
enum Solution {
    Affine(Box<Affine>),
    Rows { field: Vec<Vector3<f64>>, covariance: Vec<Matrix3<f64>>, rows: Vec<Row> },
}

impl Solution {
    fn of(
        inverter: Inverter<'_>,
        sources: &[Direction],
        noise_nt2: Vector3<f64>,
        readings: &[Vector3<f64>],
    ) -> Result<Self, physics::Error> {
        if inverter.is_affine() {
            return Ok(Solution::Affine(Box::new(Affine::of(inverter, sources, noise_nt2)?)));
        }
        let solved = inverter.field(readings)?;
        let mut covariance = solved.covariance_of_readings(noise_nt2)?;
        for moved in solved.along(sources)? {
            for (covariance, moved) in covariance.iter_mut().zip(moved) {
                *covariance += moved * moved.transpose();
            }
        }
        Ok(Solution::Rows { field: solved.field_sen, covariance, rows: solved.rows })
    }

    /// Field and covariance in SEN, or the flag that says why there is none.
    fn row(&self, row: usize, reading: &Vector3<f64>) -> Result<(Vector3<f64>, Matrix3<f64>), u32> {
        if reading.iter().any(|value| !value.is_finite()) {
            return Err(flags::MISSING);
        }
        match self {
            Solution::Affine(affine) => Ok(affine.field(reading)),
            Solution::Rows { field, covariance, rows } => match rows[row] {
                Row::Found => Ok((field[row], covariance[row])),
                Row::Missing => Err(flags::MISSING),
                Row::NotInvertible => Err(flags::NOT_INVERTIBLE),
            },
        }
    }
}

/// The readings of the three sensors; NaN where one is missing.
fn readings(recording: &Recording, unit: Unit, rows: usize) -> Vec<Vector3<f64>> {
    let columns = Axis::ALL.map(|axis| recording.axis_column("sensor", axis, unit.suffix()));
    (0..rows)
        .map(|row| Vector3::from(columns.map(|column| column.map_or(f64::NAN, |column| column[row]))))
        .collect()
}

/// B_geo = Rᵀ B_sen. A small turn ρ of the block, R → exp([ρ]×) R, moves it by −Rᵀ (ρ × B_sen) = Rᵀ [B_sen]×
/// ρ.
fn in_geo(
    context: &Context<'_>,
    row: usize,
    field: &Vector3<f64>,
    covariance: &Matrix3<f64>,
) -> (Vector3<f64>, Matrix3<f64>) {
    let back = context.rotation(row).transpose();
    let by_turn = if context.attitude.is_empty() {
        field.cross_matrix() * context.orientation.uncertainty
    } else {
        // An attitude is taken as it is given.
        Matrix3::zeros()
    };
    let covariance = back * (covariance + by_turn * by_turn.transpose()) * back.transpose();
    (back * field, covariance)
}

/// The correction where no effect acts behind the field: B = M y + o, y in the unit of the recording. The six elements
/// of the covariance of B are quadratic forms of (y, 1).
struct Affine {
    matrix: SMatrix<f64, 3, 4>,
    /// For the elements xx, yy, zz, xy, yz, zx.
    forms: [SMatrix<f64, 4, 4>; 6],
}

const ELEMENTS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

impl Affine {
    /// From the field of four readings and its derivatives, which determine all others. `sources` are those
    /// of [`crate::known`]; `noise_nt2` is the variance of one reading of each sensor.
    fn of(
        inverter: Inverter<'_>,
        sources: &[Direction],
        noise_nt2: Vector3<f64>,
    ) -> Result<Self, physics::Error> {
        let mut readings = vec![Vector3::zeros()];
        readings.extend((0..3).map(|k| Vector3::ith(k, 1.0)));
        let solved = inverter.field(&readings)?;
        let affine = |rows: &[Vector3<f64>]| {
            let [zero, x, y, z] = [0, 1, 2, 3].map(|k| rows[k]);
            SMatrix::<f64, 3, 4>::from_columns(&[x - zero, y - zero, z - zero, zero])
        };
        let mut forms = [SMatrix::zeros(); 6];
        for moved in solved.along(sources)? {
            let moved = affine(&moved);
            for (form, (i, j)) in forms.iter_mut().zip(ELEMENTS) {
                let product = moved.row(i).transpose() * moved.row(j);
                *form += (product + product.transpose()) / 2.0;
            }
        }
        let noise = solved.covariance_of_readings(noise_nt2)?[0];
        for (form, (i, j)) in forms.iter_mut().zip(ELEMENTS) {
            form[(3, 3)] += noise[(i, j)];
        }
        Ok(Self { matrix: affine(&solved.field_sen), forms })
    }

    /// The field in SEN, nT, and its covariance, nT².
    fn field(&self, reading: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let y: Vector4<f64> = reading.push(1.0);
        let mut covariance = Matrix3::zeros();
        for (form, (i, j)) in self.forms.iter().zip(ELEMENTS) {
            let value = y.dot(&(form * y));
            (covariance[(i, j)], covariance[(j, i)]) = (value, value);
        }
        (self.matrix * y, covariance)
    }
}
