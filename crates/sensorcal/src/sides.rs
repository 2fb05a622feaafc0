//! Where the fields across a sensor come from: the directions of coils and sensors that nobody measured.
//!
//! A sensor that was turned along a coil to the largest reading points along its field: R η = μ, with the
//! measured orientation R of the block. The same sensor along another coil, or along the same one with the
//! block turned about it, determines both directions; so does what a sensor leans towards a coil across it,
//! which is the cosine between two coils. What these do not show is known as far as axes may be from nominal.

use common::{AxesDirections, Axis, Document, Recording, procedure};
use estimate::linear;
use faer::{ColRef, Mat, Side};
use nalgebra::{Matrix3, Vector3};
use physics::frames::{self, ARCSEC};
use physics::{Basic, Unit};

use crate::Result;

/// Procedures in which a sensor is turned along a coil.
const ALONG: [&str; 3] = [procedure::SENSOR_SENSITIVITY, procedure::TEMPERATURE_RUN, procedure::CROSS_FIELD];
/// How well a sensor is turned to the largest reading, rad: a reading falls by 1 in 650 000 at 0.1°.
const ALIGNED: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// That counts as much as so many observed angles.
const ALIGNED_FREEDOM: f64 = 4.0;
/// Standard uncertainty of a direction at least, rad.
const LEAST: f64 = 1e-7;
/// Unknowns: two tangents of each coil and of each sensor.
const UNKNOWNS: usize = 12;
const STEPS: usize = 50;
/// A step by less than this is the last one, rad.
const SETTLED: f64 = 1e-10;

struct Turned {
    sensor: Axis,
    coil: Axis,
    rotation: Matrix3<f64>,
    sign: f64,
}

pub struct Sides {
    turned: Vec<Turned>,
    /// Coils, then sensors, as they are stated or nominal.
    nominal: [Vector3<f64>; 6],
    /// Their standard uncertainties, rad.
    std: [f64; 6],
}

/// The cosine between the directions of two coils, as a sensor along the one leans towards the other.
pub struct Lean {
    pub coils: [Axis; 2],
    pub cosine: f64,
    pub std: f64,
}

pub struct Directions {
    /// Columns = unit vectors of the coils in GEO.
    pub eta: Matrix3<f64>,
    /// Columns = unit vectors of the sensors in SEN.
    pub mu: Matrix3<f64>,
    /// η with each independent error of one standard deviation.
    pub moved: Vec<Matrix3<f64>>,
    /// How well a sensor was turned along a coil, rad.
    pub aligned: f64,
}

impl Sides {
    /// Of all recordings whose orientation is stated; directions not given are `axes_std_deg` from nominal.
    pub fn of(document: &Document, axes_std_deg: f64) -> Self {
        let basic = Basic::of(document, Unit::Volt);
        let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
        let given = |part: Option<&AxesDirections>, axis: Axis| {
            let part = part.filter(|part| part.matrix.is_some());
            let stated = |part: &AxesDirections| part.std_arcsec.as_ref().and_then(|std| std.get(axis));
            part.map_or(axes_std_deg.to_radians(), |part| stated(part).unwrap_or(0.0) * ARCSEC).max(LEAST)
        };
        let parts = [
            (&basic.eta, axes.and_then(|axes| axes.coils.as_ref())),
            (&basic.mu, axes.and_then(|axes| axes.sensors.as_ref())),
        ];
        let directions: [Vector3<f64>; 6] =
            std::array::from_fn(|at| parts[at / 3].0.column(at % 3).normalize());
        let std = std::array::from_fn(|at| given(parts[at / 3].1, Axis::ALL[at % 3]));
        // Their order in the document means nothing, to the last digit.
        let mut recordings: Vec<&Recording> = document.recordings.iter().collect();
        recordings.sort_by(|one, other| one.id.cmp(&other.id));
        let turned = recordings.into_iter().filter_map(|recording| {
            let conditions = &recording.conditions;
            let (sensor, coil) = (conditions.sensor?, conditions.coil?);
            let stated = conditions.orientation.is_some() || conditions.theodolite.is_some();
            if !stated || !ALONG.contains(&recording.procedure.as_str()) {
                return None;
            }
            let rotation = physics::orientation(document, recording).ok()?.rotation;
            let sign = (rotation * directions[coil.index()]).dot(&directions[3 + sensor.index()]).signum();
            Some(Turned { sensor, coil, rotation, sign })
        });
        Self { turned: turned.collect(), nominal: directions, std }
    }

    /// The likeliest directions, by Gauss-Newton steps in the tangents of the nominal ones. How well sensors
    /// were turned along coils is taken from how the recordings agree.
    pub fn solve(&self, leans: &[Lean]) -> Result<Directions> {
        let mut unknowns = [0.0; UNKNOWNS];
        let mut aligned = ALIGNED;
        let observed = (2 * self.turned.len() + leans.len()) as f64;
        for step in 0.. {
            let (design, y, std) = self.linearise(&unknowns, leans, aligned);
            let fit = linear::fit(design.as_ref(), &y, Some(&std))?;
            let moved =
                (0..UNKNOWNS).map(|at| (fit.coefficients[at] - unknowns[at]).abs()).fold(0.0, f64::max);
            unknowns.copy_from_slice(&fit.coefficients);
            let readings = y.len() - UNKNOWNS;
            let squares: f64 = (0..readings).map(|row| (aligned * fit.standardised[row]).powi(2)).sum();
            let taken: f64 =
                (0..UNKNOWNS).map(|at| 1.0 - fit.covariance[(at, at)] / self.std[at / 2].powi(2)).sum();
            let freedom = ALIGNED_FREEDOM + (observed - taken).max(0.0);
            let next = ((ALIGNED_FREEDOM * ALIGNED * ALIGNED + squares) / freedom).sqrt();
            let settled = moved < SETTLED && (next / aligned - 1.0).abs() < 1e-9;
            aligned = next;
            if !settled && step < STEPS {
                continue;
            }
            let of = |unknowns: &[f64; UNKNOWNS], from: usize| {
                let one =
                    |axis: usize| frames::turned(&self.nominal[from + axis], turn(unknowns, from + axis));
                Matrix3::from_columns(&[one(0), one(1), one(2)])
            };
            let covariance = Mat::from_fn(6, 6, |i, j| fit.covariance[(i, j)]);
            let factor = covariance.llt(Side::Lower).map_err(|error| estimate::Error::Decomposition {
                rows: 6,
                columns: 6,
                reason: format!("{error:?}"),
            })?;
            let moved = (0..6).map(|error| {
                let mut moved = unknowns;
                (0..6).for_each(|at| moved[at] += factor.L()[(at, error)]);
                of(&moved, 0)
            });
            return Ok(Directions {
                eta: of(&unknowns, 0),
                mu: of(&unknowns, 3),
                moved: moved.collect(),
                aligned,
            });
        }
        unreachable!("the iteration returns after its last step")
    }

    /// Design, right side and standard deviation of each row about the present unknowns: three components for
    /// each sensor that was turned, the leans, what is known of each direction.
    fn linearise(
        &self,
        unknowns: &[f64; UNKNOWNS],
        leans: &[Lean],
        aligned: f64,
    ) -> (Mat<f64>, Vec<f64>, Vec<f64>) {
        let of = |at: usize| {
            let (nominal, turn) = (&self.nominal[at], turn(unknowns, at));
            (frames::turned(nominal, turn), frames::turned_derivatives(nominal, turn))
        };
        let each: Vec<(Vector3<f64>, [Vector3<f64>; 2])> = (0..6).map(of).collect();
        let rows = 3 * self.turned.len() + leans.len() + UNKNOWNS;
        let mut design = Mat::zeros(rows, UNKNOWNS);
        let mut residual = vec![0.0; rows];
        let mut std = vec![aligned; rows];
        let mut row = 0;
        for turned in &self.turned {
            let (coil, sensor) = (turned.coil.index(), 3 + turned.sensor.index());
            let left = turned.rotation * each[coil].0 * turned.sign - each[sensor].0;
            for k in 0..3 {
                residual[row] = -left[k];
                for tangent in 0..2 {
                    design[(row, 2 * coil + tangent)] =
                        (turned.rotation * each[coil].1[tangent])[k] * turned.sign;
                    design[(row, 2 * sensor + tangent)] = -each[sensor].1[tangent][k];
                }
                row += 1;
            }
        }
        for lean in leans {
            let [one, other] = lean.coils.map(Axis::index);
            residual[row] = lean.cosine - each[one].0.dot(&each[other].0);
            for tangent in 0..2 {
                design[(row, 2 * one + tangent)] = each[one].1[tangent].dot(&each[other].0);
                design[(row, 2 * other + tangent)] = each[other].1[tangent].dot(&each[one].0);
            }
            std[row] = aligned.hypot(lean.std);
            row += 1;
        }
        for at in 0..UNKNOWNS {
            design[(row, at)] = 1.0;
            residual[row] = -unknowns[at];
            std[row] = self.std[at / 2];
            row += 1;
        }
        let y = ColRef::from_slice(&residual) + &design * ColRef::from_slice(unknowns);
        let y = y.iter().copied().collect();
        (design, y, std)
    }
}

fn turn(unknowns: &[f64; UNKNOWNS], at: usize) -> [f64; 2] {
    [unknowns[2 * at], unknowns[2 * at + 1]]
}
