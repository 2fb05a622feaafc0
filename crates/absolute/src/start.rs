//! Where the least squares of a measurement begin.

use nalgebra::{Matrix3, Vector3};
use physics::Components;
use std::f64::consts::PI;

use crate::Error;
use crate::read::{Circle, Row, Set};

pub const UNKNOWNS: usize = 8;
/// What an offset costs where a calculation begins; views are unit vectors.
const RATHER: f64 = 1e-6;

/// Within ±π.
pub fn wrapped(angle: f64) -> f64 {
    angle - 2.0 * PI * (angle / (2.0 * PI)).round()
}

/// The mean reading of the variometer beside readings of the field, nT.
pub fn mean(rows: &[&Row]) -> Vector3<f64> {
    let is_field = |row: &&&Row| matches!(row.circle, Circle::Field { .. });
    let fields: Vec<&Vector3<f64>> = rows.iter().filter(is_field).map(|row| &row.variometer_nt).collect();
    fields.iter().copied().sum::<Vector3<f64>>() / fields.len() as f64
}

/// Where the iteration begins: without collimations, by the direction that all readings are at right angles to.
/// Errors: readings that do not determine it.
pub fn start(
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
        let words = "no reading of the azimuth mark, a row with horizontal_deg and vertical_deg and without residual_nt";
        return Err(refused(words.into()));
    };
    let spread = marks.iter().map(|mark| wrapped(mark - first)).sum::<f64>() / marks.len() as f64;
    if let Some(off) = marks.iter().map(|mark| wrapped(mark - first).abs()).find(|off| *off > 0.1) {
        let degrees = off.to_degrees();
        // Half a turn of a circle in grades, and of one that was read with the other face.
        let remedy = if (degrees - 20.0).abs() < 1.0 {
            "its circle fits as grades (gon): multiply horizontal_deg and vertical_deg of all readings by 0.9"
        } else if (degrees - 180.0).abs() < 1.0 {
            "exchange 90 and 270 of vertical_deg in the reading with the wrong face"
        } else {
            "read the circle again, or correct the sheet"
        };
        return Err(refused(format!(
            "readings of the mark differ by {degrees:.2}° after removing the 180° between faces (vertical_deg is 90 with the magnetometer above the telescope, 270 below); {remedy}"
        )));
    }
    let north = first + spread - set.azimuth[0];
    let magnitude = scalars.iter().filter_map(|row| row.scalar_nt).map(|scalar| scalar + set.pillar[0]);
    let magnitude = magnitude.sum::<f64>() / scalars.len() as f64;
    if magnitude.is_nan() {
        return Err(refused("no scalar magnetometer; give reference_nt in the readings or beside the variometer: directions alone give no baseline in nT".into()));
    }
    let views = |level: bool, declination: f64| -> Vec<[f64; 4]> {
        let of = |row: &&Row| match row.circle {
            Circle::Field { azimuth, zenith, .. } if !level || row.circle.is_level() => {
                let azimuth = azimuth.geographic(north, declination);
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
pub fn missing(set: &Set, circles: &[&Row], magnetic_north: f64) -> Error {
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
