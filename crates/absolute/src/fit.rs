//! One measurement by least squares: every reading of a circle against the field that the variometer, the
//! baseline values and the scalar magnetometer make there.
//!
//! A reading S of the theodolite's magnetometer is predicted as S0 + n·B (`physics::theodolite`), the circle towards
//! the mark as N + A ± c, the scalar as |B| − p. The unknowns are the three baseline values, the circle towards north N,
//! the telescope's collimation c, and the magnetometer's offset and two collimations. The mean of the four positions is
//! the solution where each is read once; repeated, missing and reordered readings need no formula of their own.

use estimate::{Fit, Options, Problem, influence, solve};
use faer::MatMut;
use nalgebra::{Matrix3, Vector3};
use physics::Components;
use physics::theodolite::{Mounting, sighting};
use std::f64::consts::PI;

use crate::Error;
use crate::read::{Azimuth, Circle, Row, Set};
use crate::start::{UNKNOWNS, mean, missing, start, wrapped};
use crate::variometer::LONGEST_STEP_S;

const NORTH: usize = 3;
const COLLIMATION: usize = 4;
const OFFSET: usize = 5;
const HORIZONTAL: usize = 6;
const VERTICAL: usize = 7;
/// Scatter of the readings of a scalar magnetometer beside the vector, nT.
const SCALAR_NT: f64 = 0.1;

/// What is known of the instruments.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Standard uncertainty of a circle reading, rad.
    pub circle: f64,
    /// Of the scalar magnetometer, the same in all readings, nT.
    pub scalar_nt: f64,
}

struct Readings<'a> {
    set: &'a Set,
    components: Components,
    circles: Vec<&'a Row>,
    scalars: Vec<&'a Row>,
    known: Known,
    /// The size of the field for the weights, nT.
    start: [f64; UNKNOWNS],
}

pub struct Found {
    pub components: Components,
    /// Rows of the circles, in the order of the residuals.
    pub rows: Vec<Row>,
    pub fit: Fit<[f64; UNKNOWNS]>,
    /// Derivative of every unknown by the difference of the pillars.
    pub by_pillar: Vec<f64>,
    /// What a circle reads too much, rad, for a weighted residual of 1.
    per_residual: Vec<f64>,
}

pub fn baseline(state: &[f64; UNKNOWNS]) -> Vector3<f64> {
    Vector3::new(state[0], state[1], state[2])
}

pub fn mounting(state: &[f64; UNKNOWNS]) -> Mounting {
    Mounting { offset_nt: state[OFFSET], horizontal_rad: state[HORIZONTAL], vertical_rad: state[VERTICAL] }
}

/// What the circle reads towards north, rad.
pub fn north(state: &[f64; UNKNOWNS]) -> f64 {
    state[NORTH]
}

/// From the x axis of the field, rad.
pub fn declination(field: &Vector3<f64>) -> f64 {
    field.y.atan2(field.x)
}

/// Finds the baseline values of a measurement. Errors: readings that do not determine them, naming what is missing.
pub fn fit(set: &Set, known: Known) -> Result<Found, Error> {
    let components = set.components.unwrap_or_default();
    let circles: Vec<&Row> = set.rows.iter().filter(|row| row.circle != Circle::None).collect();
    let scalars: Vec<&Row> = set.rows.iter().filter(|row| row.scalar_nt.is_some()).collect();
    let is_field = |row: &&Row| matches!(row.circle, Circle::Field { .. });
    if !circles.iter().any(is_field) && !set.without_variometer.is_empty() {
        return Err(Error::Unanswerable(format!(
            "\"{}\": the variometer did not read within {LONGEST_STEP_S} s of any reading of the field; check the times and the start of both",
            set.id
        )));
    }
    let start = start(set, components, &circles, &scalars)?;
    let problem = Readings { set, components, circles, scalars, known, start };
    let fit = solve(&problem, start, None, &Options::default())
        .map_err(|error| Error::Fit(format!("\"{}\": {error}", set.id)))?;
    if fit.svd.rank() < UNKNOWNS {
        let field = field(components, &start, &mean(&problem.circles)).0;
        return Err(missing(set, &problem.circles, start[NORTH] + declination(&field)));
    }
    // The sum of the scalars' rows for 1 nT.
    let count = problem.circles.len();
    let per_nt: Vec<f64> =
        (0..problem.rows()).map(|row| if row < count { 0.0 } else { 1.0 / SCALAR_NT }).collect();
    let per_residual = problem.circles.iter().map(|row| problem.circle(row)).collect();
    Ok(Found {
        components,
        by_pillar: fit.svd.solve(&per_nt),
        rows: problem.circles.iter().map(|row| (*row).clone()).collect(),
        fit,
        per_residual,
    })
}

fn field(
    components: Components,
    state: &[f64; UNKNOWNS],
    reading: &Vector3<f64>,
) -> (Vector3<f64>, Matrix3<f64>) {
    components.field_nt(reading, &baseline(state))
}

impl Readings<'_> {
    /// Of the residual of a reading: what a circle misread by its standard uncertainty makes of it.
    fn std(&self, row: &Row) -> f64 {
        match row.circle {
            Circle::Field { azimuth, zenith, .. } => {
                let [by_azimuth, by_zenith] = self.by_circles(azimuth, zenith, row);
                self.known.circle * by_azimuth.hypot(by_zenith)
            }
            _ => self.known.circle,
        }
    }

    /// By how much the circle that the position is about reads too much, rad, for a weighted residual of 1: the
    /// horizontal one where the telescope is level.
    fn circle(&self, row: &Row) -> f64 {
        match row.circle {
            Circle::Field { azimuth, zenith, .. } => {
                let [by_azimuth, by_zenith] = self.by_circles(azimuth, zenith, row);
                -self.std(row) / if row.circle.is_level() { by_azimuth } else { by_zenith }
            }
            _ => self.known.circle,
        }
    }

    /// Derivatives of a reading by the two circles.
    fn by_circles(&self, azimuth: Azimuth, zenith: f64, row: &Row) -> [f64; 2] {
        let (field, _) = field(self.components, &self.start, &row.variometer_nt);
        let seen = sighting(&field, azimuth.of(&self.start, &field), zenith, &mounting(&self.start));
        // A direction that was not read has no error of the circle.
        [if matches!(azimuth, Azimuth::Circle(_)) { seen.by_azimuth } else { 0.0 }, seen.by_zenith]
    }
}

impl Azimuth {
    fn of(self, state: &[f64; UNKNOWNS], field: &Vector3<f64>) -> f64 {
        self.geographic(state[NORTH], declination(field))
    }
}

impl Problem for Readings<'_> {
    type State = [f64; UNKNOWNS];

    fn unknowns(&self) -> usize {
        UNKNOWNS
    }

    fn rows(&self) -> usize {
        self.circles.len() + self.scalars.len()
    }

    fn readings(&self) -> usize {
        self.circles.len()
    }

    fn linearise(&self, state: &Self::State, residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
        for (i, row) in self.circles.iter().enumerate() {
            let std = self.std(row);
            let mut put = |j: usize, slope: f64| jacobian[(i, j)] = slope / std;
            match row.circle {
                Circle::Field { azimuth, zenith, reading_nt } => {
                    let (field, by) = field(self.components, state, &row.variometer_nt);
                    let seen = sighting(&field, azimuth.of(state, &field), zenith, &mounting(state));
                    residual[i] = (reading_nt - seen.reading_nt) / std;
                    // In the meridian of the field the view turns with it.
                    let [read, turned] = match azimuth {
                        Azimuth::Circle(_) => [seen.by_azimuth, 0.0],
                        Azimuth::FromMeridian(_) => [0.0, seen.by_azimuth],
                    };
                    let square = field.x.powi(2) + field.y.powi(2);
                    let by_field = seen.by_field + Vector3::new(-field.y, field.x, 0.0) * (turned / square);
                    (0..3).for_each(|k| put(k, by_field.dot(&by.column(k))));
                    put(NORTH, -read);
                    put(OFFSET, 1.0);
                    put(HORIZONTAL, seen.by_mounting[0]);
                    put(VERTICAL, seen.by_mounting[1]);
                }
                Circle::Mark { horizontal, above } => {
                    let (face, turned) = if above { (1.0, 0.0) } else { (-1.0, PI) };
                    let predicted = state[NORTH] + self.set.azimuth[0] + face * state[COLLIMATION] + turned;
                    residual[i] = wrapped(horizontal - predicted) / std;
                    put(NORTH, 1.0);
                    put(COLLIMATION, face);
                }
                Circle::None => {}
            }
        }
        for (i, row) in self.scalars.iter().enumerate() {
            let i = self.circles.len() + i;
            let (field, by) = field(self.components, state, &row.variometer_nt);
            let length = field.norm();
            residual[i] = (row.scalar_nt.unwrap_or(length) + self.set.pillar[0] - length) / SCALAR_NT;
            (0..3).for_each(|k| jacobian[(i, k)] = field.dot(&by.column(k)) / length / SCALAR_NT);
        }
    }

    fn advance(&self, state: &Self::State, step: &[f64]) -> Self::State {
        std::array::from_fn(|k| state[k] + step[k])
    }
}

impl Found {
    /// The field at the mean reading of the variometer, with its derivatives by the baseline values.
    pub fn field(&self) -> (Vector3<f64>, Matrix3<f64>) {
        field(self.components, &self.fit.state, &mean(&self.rows.iter().collect::<Vec<_>>()))
    }

    /// Of each circle its residual, and that without it, rad, with the studentised residual.
    pub fn residuals(&self) -> Vec<[f64; 3]> {
        let influence = influence::influence(&self.fit, self.rows.len(), true, 0);
        let one = |(i, one): (usize, influence::Influence)| {
            let rad = self.per_residual[i];
            [self.fit.residual[i] * rad, one.leave_one_out * rad, one.t]
        };
        influence.into_iter().enumerate().map(one).collect()
    }

    /// χ² of the circles without one of them.
    pub fn without(&self, at: usize) -> f64 {
        let one = influence::influence(&self.fit, self.rows.len(), true, 0)[at];
        self.circles().0 - self.fit.residual[at] * one.leave_one_out
    }

    /// χ² of the circles alone, and its degrees of freedom.
    pub fn circles(&self) -> (f64, f64) {
        let count = self.rows.len();
        let chi_squared = self.fit.residual[..count].iter().map(|r| r * r).sum();
        let leverage: f64 = self.fit.svd.leverage()[..count].iter().sum();
        (chi_squared, count as f64 - leverage)
    }
}
