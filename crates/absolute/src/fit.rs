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
use crate::read::{Circle, Row, Set};

/// How many unknowns there are.
pub const UNKNOWNS: usize = 8;
const NORTH: usize = 3;
const COLLIMATION: usize = 4;
const OFFSET: usize = 5;
const HORIZONTAL: usize = 6;
const VERTICAL: usize = 7;
/// Scatter of the readings of a scalar magnetometer beside the vector, nT.
const SCALAR_NT: f64 = 0.1;
/// What an offset costs where a calculation begins; views are unit vectors.
const RATHER: f64 = 1e-6;

/// What is known of the instruments.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Standard uncertainty of a circle reading, rad.
    pub circle: f64,
    /// Of the scalar magnetometer, the same in all readings, nT.
    pub scalar_nt: f64,
}

/// The readings of a set as a problem.
struct Readings<'a> {
    set: &'a Set,
    components: Components,
    circles: Vec<&'a Row>,
    scalars: Vec<&'a Row>,
    known: Known,
    /// The size of the field for the weights, nT.
    start: [f64; UNKNOWNS],
}

/// A measurement with what it says.
pub struct Found {
    pub components: Components,
    /// Rows of the circles, in the order of the residuals.
    pub rows: Vec<Row>,
    pub fit: Fit<[f64; UNKNOWNS]>,
    /// Derivative of every unknown by the difference of the pillars.
    pub by_pillar: Vec<f64>,
    /// Whether a circle that reads too much makes each residual larger, 1, or smaller, −1.
    signs: Vec<f64>,
}

/// Baseline values of a state.
pub fn baseline(state: &[f64; UNKNOWNS]) -> Vector3<f64> {
    Vector3::new(state[0], state[1], state[2])
}

/// The telescope's magnetometer of a state.
pub fn mounting(state: &[f64; UNKNOWNS]) -> Mounting {
    Mounting { offset_nt: state[OFFSET], horizontal_rad: state[HORIZONTAL], vertical_rad: state[VERTICAL] }
}

/// What the circle reads towards north, rad.
pub fn north(state: &[f64; UNKNOWNS]) -> f64 {
    state[NORTH]
}

/// The magnetic declination of a field.
pub fn declination(field: &Vector3<f64>) -> f64 {
    field.y.atan2(field.x)
}

/// Within ±π.
pub fn wrapped(angle: f64) -> f64 {
    angle - 2.0 * PI * (angle / (2.0 * PI)).round()
}

/// Finds the baseline values of a measurement.
///
/// Errors: readings that do not determine them, naming what is missing.
pub fn fit(set: &Set, known: Known) -> Result<Found, Error> {
    let components = set.components.unwrap_or_default();
    let circles: Vec<&Row> = set.rows.iter().filter(|row| row.circle != Circle::None).collect();
    let scalars: Vec<&Row> = set.rows.iter().filter(|row| row.scalar_nt.is_some()).collect();
    let start = start(set, components, &circles, &scalars)?;
    let problem = Readings { set, components, circles, scalars, known, start };
    let fit = solve(&problem, start, None, &Options::default())
        .map_err(|error| Error::Fit(format!("\"{}\": {error}", set.id)))?;
    if fit.svd.rank() < UNKNOWNS {
        return Err(missing(
            set,
            &problem.circles,
            start[NORTH] + declination(&field(components, &start, &mean(&problem.circles)).0),
        ));
    }
    // The sum of the scalars' rows for 1 nT.
    let count = problem.circles.len();
    let per_nt: Vec<f64> =
        (0..problem.rows()).map(|row| if row < count { 0.0 } else { 1.0 / SCALAR_NT }).collect();
    let signs = problem.circles.iter().map(|row| problem.sign(row)).collect();
    Ok(Found {
        components,
        by_pillar: fit.svd.solve(&per_nt),
        rows: problem.circles.iter().map(|row| (*row).clone()).collect(),
        fit,
        signs,
    })
}

fn mean(rows: &[&Row]) -> Vector3<f64> {
    let fields: Vec<&Vector3<f64>> = rows
        .iter()
        .filter(|row| matches!(row.circle, Circle::Field { .. }))
        .map(|row| &row.variometer_nt)
        .collect();
    fields.iter().copied().sum::<Vector3<f64>>() / fields.len() as f64
}

fn field(
    components: Components,
    state: &[f64; UNKNOWNS],
    reading: &Vector3<f64>,
) -> (Vector3<f64>, Matrix3<f64>) {
    components.field_nt(reading, &baseline(state))
}

/// Where the iteration begins: without collimations, by the direction that all readings are at right angles to.
///
/// Errors: readings that do not determine it.
fn start(
    set: &Set,
    components: Components,
    circles: &[&Row],
    scalars: &[&Row],
) -> Result<[f64; UNKNOWNS], Error> {
    let refused = |words: String| Error::Unanswerable(format!("\"{}\": {words}", set.id));
    let marks: Vec<f64> = (circles.iter())
        .filter_map(|row| match row.circle {
            Circle::Mark { horizontal, above } => Some(horizontal - if above { 0.0 } else { PI }),
            _ => None,
        })
        .collect();
    let Some(first) = marks.first() else {
        return Err(refused(
            "no reading of the azimuth mark: a row with horizontal_deg and without residual_nt".into(),
        ));
    };
    let spread = marks.iter().map(|mark| wrapped(mark - first)).sum::<f64>() / marks.len() as f64;
    if let Some(off) = marks.iter().map(|mark| wrapped(mark - first).abs()).find(|off| *off > 0.1) {
        return Err(refused(format!(
            "readings of the mark differ by {:.2}° with the faces that are stated; vertical_deg is 90 with the magnetometer above the telescope and 270 below, where the circle reads 180° more; the circle may be in grades (gon)",
            off.to_degrees()
        )));
    }
    let north = first + spread - set.azimuth[0];
    let magnitude = scalars.iter().filter_map(|row| row.scalar_nt).map(|scalar| scalar + set.pillar[0]);
    let magnitude = magnitude.sum::<f64>() / scalars.len() as f64;
    if magnitude.is_nan() {
        return Err(refused("no scalar magnetometer: reference_nt in the readings or beside the variometer; directions alone give no baseline in nT".into()));
    }
    let views = |level: bool, declination: f64| -> Vec<[f64; 4]> {
        let of = |row: &&Row| match row.circle {
            Circle::Field { horizontal, zenith, .. } if !level || row.is_level() => {
                let azimuth = horizontal.map_or_else(|from| from + declination, |circle| circle - north);
                let (sin, cos) = zenith.sin_cos();
                Some([sin * azimuth.cos(), sin * azimuth.sin(), -cos, 1.0])
            }
            _ => None,
        };
        circles.iter().filter_map(of).collect()
    };
    // The declination by the level readings alone, then all of them in its meridian.
    let level = views(true, 0.0);
    let across = least(&level.iter().map(|[x, y, _, one]| [*x, *y, *one]).collect::<Vec<_>>());
    let Some(across) = across.filter(|_| level.len() > 1) else {
        return Err(missing(set, circles, north));
    };
    let declination = (across.y / across.x).atan();
    let (sin, cos) = declination.sin_cos();
    let all: Vec<[f64; 3]> =
        views(false, declination).iter().map(|[x, y, z, one]| [x * cos + y * sin, *z, *one]).collect();
    let Some(along) = least(&all) else { return Err(missing(set, circles, north)) };
    let (h, z) = (along.x.abs(), along.y * along.x.signum());
    let scale = magnitude / h.hypot(z);
    let field = Vector3::new(h * cos, h * sin, z) * scale;
    let baseline = components.baseline(&mean(circles), &field);
    Ok([baseline.x, baseline.y, baseline.z, north, 0.0, 0.0, 0.0, 0.0])
}

/// The direction that rows say least of; rather without an offset, the last of three.
fn least(rows: &[[f64; 3]]) -> Option<Vector3<f64>> {
    let squares: Matrix3<f64> =
        rows.iter().map(|row| Vector3::from(*row) * Vector3::from(*row).transpose()).sum();
    let own = (squares + Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, RATHER))).symmetric_eigen();
    let found = own.eigenvectors.column(own.eigenvalues.imin()).into_owned();
    (found.x != 0.0 && found.iter().all(|value| value.is_finite())).then_some(found)
}

/// That positions are missing, which.
fn missing(set: &Set, circles: &[&Row], magnetic_north: f64) -> Error {
    let there: Vec<String> = circles.iter().map(|row| row.position(magnetic_north)).collect();
    let all = ["mark", "east", "west", "north", "south"]
        .map(|view| ["up", "down"].map(|face| format!("{view} {face}")));
    let missing: Vec<String> =
        all.concat().into_iter().filter(|position| !there.contains(position)).collect();
    let missing = if missing.is_empty() { "positions that differ".into() } else { missing.join(", ") };
    Error::Unanswerable(format!(
        "\"{}\": its readings do not determine declination, inclination and the errors of the instrument; missing: {missing}",
        set.id
    ))
}

impl Readings<'_> {
    /// Of the residual of a reading: what a circle misread by its standard uncertainty makes of it.
    fn std(&self, row: &Row) -> f64 {
        match row.circle {
            Circle::Field { .. } => {
                let (_, by_azimuth, by_zenith) = self.seen(row, &self.start);
                self.known.circle * by_azimuth.hypot(by_zenith)
            }
            _ => self.known.circle,
        }
    }

    fn sign(&self, row: &Row) -> f64 {
        let (_, by_azimuth, by_zenith) = self.seen(row, &self.start);
        match row.circle {
            Circle::Field { .. } if by_azimuth.abs() > by_zenith.abs() => -by_azimuth.signum(),
            Circle::Field { .. } => -by_zenith.signum(),
            _ => 1.0,
        }
    }

    fn seen(&self, row: &Row, state: &[f64; UNKNOWNS]) -> (Vector3<f64>, f64, f64) {
        let Circle::Field { horizontal, zenith, .. } = row.circle else {
            return (Vector3::zeros(), 0.0, 1.0);
        };
        let (field, _) = field(self.components, state, &row.variometer_nt);
        let azimuth = azimuth(horizontal, state, &field);
        let seen = sighting(&field, azimuth, zenith, &mounting(state));
        // A direction that was not read has no error of the circle.
        (field, if horizontal.is_ok() { seen.by_azimuth } else { 0.0 }, seen.by_zenith)
    }
}

fn azimuth(horizontal: Result<f64, f64>, state: &[f64; UNKNOWNS], field: &Vector3<f64>) -> f64 {
    horizontal.map_or_else(|from| from + declination(field), |circle| circle - state[NORTH])
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
                Circle::Field { horizontal, zenith, reading_nt } => {
                    let (field, by) = field(self.components, state, &row.variometer_nt);
                    let seen = sighting(&field, azimuth(horizontal, state, &field), zenith, &mounting(state));
                    residual[i] = (reading_nt - seen.reading_nt) / std;
                    // In the meridian of the field the view turns with it.
                    let turned = if horizontal.is_err() { seen.by_azimuth } else { 0.0 };
                    let square = field.x.powi(2) + field.y.powi(2);
                    let by_field = seen.by_field + Vector3::new(-field.y, field.x, 0.0) * (turned / square);
                    (0..3).for_each(|k| put(k, by_field.dot(&by.column(k))));
                    put(NORTH, if horizontal.is_ok() { -seen.by_azimuth } else { 0.0 });
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
    pub fn residuals(&self, known: Known) -> Vec<[f64; 3]> {
        let influence = influence::influence(&self.fit, self.rows.len(), true, 0);
        let one = |(i, one): (usize, influence::Influence)| {
            let rad = known.circle * self.signs[i];
            [self.fit.residual[i] * rad, one.leave_one_out * rad, one.t]
        };
        influence.into_iter().enumerate().map(one).collect()
    }

    /// χ² of the circles alone, and its degrees of freedom.
    pub fn circles(&self) -> (f64, f64) {
        let count = self.rows.len();
        let chi_squared = self.fit.residual[..count].iter().map(|r| r * r).sum();
        let leverage: f64 = self.fit.svd.leverage()[..count].iter().sum();
        (chi_squared, count as f64 - leverage)
    }
}
