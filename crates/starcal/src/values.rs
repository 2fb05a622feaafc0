//! Sensors and heads as numbers of the document, with their covariance.

use common::{Axis, uncertainty};
use faer::Mat;
use nalgebra::{Matrix3, Rotation3, Vector3};
use physics::frames::ARCSEC;

use crate::axes::Axes;
use crate::heads::{First, Head};

/// Step of the derivatives by the twelve, as a share of the largest; of those by the turns, rad.
const STEP: f64 = 1e-7;
/// Place of the first angle: k, O and the nine elements of μ stand before.
const ANGLES: usize = 15;

/// k, O, μ column by column, then the three angles of each head, degrees.
pub struct Values {
    pub names: Vec<String>,
    pub values: Vec<f64>,
    /// How they move with the values of the fit, and with turns of the other heads about their axes, arcsec.
    pub moves: Mat<f64>,
    pub covariance: Mat<f64>,
    /// SEN to each head.
    pub heads: Vec<Matrix3<f64>>,
    /// How each head turns about its axes, arcsec, with the same as `moves`.
    turns: Vec<Mat<f64>>,
}

impl Values {
    /// None where the sensors lie in a plane.
    pub fn of(first: &First, others: &[&Head], stated: &Matrix3<f64>) -> Option<Self> {
        let fit = &first.fit;
        let turns: Vec<Rotation3<f64>> = others.iter().map(|head| head.turn).collect();
        let values = |twelve: &[f64], turns: &[Rotation3<f64>]| -> Option<(Vec<f64>, Vec<Matrix3<f64>>)> {
            let axes = Axes::of(twelve, stated)?;
            let mut all: Vec<f64> =
                axes.k.iter().chain(axes.offset_nt.iter()).chain(axes.mu.iter()).copied().collect();
            let heads: Vec<Matrix3<f64>> =
                [axes.turn].into_iter().chain(turns.iter().map(|turn| turn.matrix() * axes.turn)).collect();
            all.extend(heads.iter().flat_map(angles));
            Some((all, heads))
        };
        let twelve = &fit.values[..12];
        let (found, heads) = values(twelve, &turns)?;
        let (count, all) = (fit.values.len(), fit.values.len() + 3 * others.len());
        let largest = twelve.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        let mut moves = Mat::zeros(found.len(), all);
        let mut turned = vec![Mat::zeros(3, all); heads.len()];
        for k in (0..12).chain(count..all) {
            let at = |sign: f64| {
                let (mut twelve, mut turns) = (twelve.to_vec(), turns.clone());
                if k < 12 {
                    twelve[k] += sign * STEP * largest;
                } else {
                    let head = &mut turns[(k - count) / 3];
                    *head = Rotation3::from_scaled_axis(Vector3::ith((k - count) % 3, sign * STEP)) * *head;
                }
                values(&twelve, &turns)
            };
            let ((up, above), (down, below)) = at(1.0).zip(at(-1.0))?;
            let step = if k < 12 { STEP * largest } else { STEP / ARCSEC };
            for (row, (up, down)) in up.iter().zip(&down).enumerate() {
                // Angles may pass ±180°.
                let moved =
                    if row >= ANGLES { (up - down + 180.0).rem_euclid(360.0) - 180.0 } else { up - down };
                moves[(row, k)] = moved / (2.0 * step);
            }
            for (turned, (above, below)) in turned.iter_mut().zip(above.iter().zip(&below)) {
                // A small turn.
                let m = above * below.transpose();
                let between = [m[(2, 1)] - m[(1, 2)], m[(0, 2)] - m[(2, 0)], m[(1, 0)] - m[(0, 1)]];
                (0..3).for_each(|axis| turned[(axis, k)] = between[axis] / ARCSEC / (4.0 * step));
            }
        }
        let mut covariance = Mat::zeros(all, all);
        covariance.submatrix_mut(0, 0, count, count).copy_from(&fit.covariance);
        for (number, head) in others.iter().enumerate() {
            let at = count + 3 * number;
            covariance.submatrix_mut(at, at, 3, 3).copy_from(&head.covariance);
        }
        let mut names: Vec<String> = Axis::ALL.map(|axis| uncertainty::sensitivity(axis, "nt")).to_vec();
        names.extend(Axis::ALL.map(uncertainty::sensor_offset));
        names.extend(uncertainty::directions("sensors"));
        let head = |camera: usize| {
            (0..3).map(move |k| format!("calibration.flight.cameras[{camera}].angles_deg[{k}]"))
        };
        names.extend((0..heads.len()).flat_map(head));
        Some(Self { names, values: found, moves, covariance, heads, turns: turned })
    }

    /// Adds a value of the fit itself, by its place and unit.
    pub fn add(&mut self, name: String, place: usize) {
        let (rows, own) = (self.moves.nrows(), &self.moves);
        let moved = |i: usize, j: usize| if i < rows { own[(i, j)] } else { f64::from(u8::from(j == place)) };
        self.moves = Mat::from_fn(rows + 1, own.ncols(), moved);
        self.names.push(name);
    }

    pub fn joint(&self) -> Mat<f64> {
        let joint = &self.moves * &self.covariance * self.moves.transpose();
        (&joint + joint.transpose()) * faer::Scale(0.5)
    }

    /// Moves a number by a value of the fit, by its place there.
    pub fn shift(&mut self, number: usize, by: f64, place: usize, rate: f64) {
        self.values[number] += by;
        self.moves[(number, place)] += rate;
    }

    /// Standard uncertainties of turns of a head about its axes, arcsec.
    pub fn turn_std(&self, camera: usize) -> [f64; 3] {
        let turned = &self.turns[camera] * &self.covariance * self.turns[camera].transpose();
        [0, 1, 2].map(|k| turned[(k, k)].max(0.0).sqrt())
    }

    pub fn angle(camera: usize, k: usize) -> usize {
        ANGLES + 3 * camera + k
    }
}

/// a, b, c of Rz(c) Ry(b) Rx(a), degrees.
fn angles(rotation: &Matrix3<f64>) -> [f64; 3] {
    let (a, b, c) = Rotation3::from_matrix_unchecked(*rotation).euler_angles();
    [a, b, c].map(f64::to_degrees)
}
