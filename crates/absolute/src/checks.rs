//! Readings that fit no position: what would make them fit.

use common::number::significant;
use physics::frames::ARCSEC;

use crate::Error;
use crate::fit::{Found, Known, declination, fit, north};
use crate::read::{Circle, Row, Set};

/// χ² over its degrees of freedom from which an explanation is looked for.
const SUSPECT: f64 = 4.0;
/// Circles that are off by more than this, rms, are no measurement, rad.
const IMPOSSIBLE: f64 = 300.0 * ARCSEC;
/// An explanation leaves less than this share of χ².
const EXPLAINS: f64 = 0.1;

/// What may be wrong with a whole sheet, and the remedy.
type Mistake = (fn(&mut Circle), &'static str);

const MISTAKES: [Mistake; 3] = [
    (
        signs,
        "they fit with the other sign of residual_nt, which is positive where the field points along the view",
    ),
    (
        faces,
        "they fit if \"above\" and \"below\" are exchanged where the telescope is level; exchange 90 and 270 of vertical_deg there",
    ),
    (
        opposite,
        "they fit with the mark in the opposite direction; its azimuth is off by 180°, or 90 and 270 of vertical_deg are exchanged in its readings",
    ),
];

fn signs(circle: &mut Circle) {
    if let Circle::Field { reading_nt, .. } = circle {
        *reading_nt = -*reading_nt;
    }
}

fn faces(circle: &mut Circle) {
    let is_level = circle.is_level();
    match circle {
        Circle::Field { zenith, .. } if is_level => *zenith = -*zenith,
        _ => {}
    }
}

fn opposite(circle: &mut Circle) {
    if let Circle::Mark { above, .. } = circle {
        *above = !*above;
    }
}

fn per_freedom(found: &Found) -> f64 {
    let (chi_squared, free) = found.circles();
    chi_squared / free.max(1.0)
}

/// The fit of other rows in place of those of a set, with its χ² over its degrees of freedom.
fn with_rows(set: &Set, rows: Vec<Row>, known: Known) -> Option<(f64, Found)> {
    let other =
        Set { rows, without_variometer: Vec::new(), id: set.id.clone(), path: set.path.clone(), ..*set };
    let found = fit(&other, known).ok()?;
    Some((per_freedom(&found), found))
}

/// That readings are those of a theodolite in the field of the Earth.
/// Errors: readings that fit with one mistake undone; readings that fit nothing, with the one without which they do.
pub fn position(set: &Set, found: &Found, known: Known) -> Result<(), Error> {
    let off = per_freedom(found);
    if off <= SUSPECT {
        return Ok(());
    }
    let refused = |words: String| {
        let expected = "the readings of one measurement; correct the sheet or leave it out";
        Err(Error::document(&set.path, format!("readings of \"{}\" {words}", set.id), expected))
    };
    let undone = MISTAKES.into_iter().filter_map(|(change, words)| {
        let mut rows = set.rows.clone();
        rows.iter_mut().for_each(|row| change(&mut row.circle));
        Some((with_rows(set, rows, known)?.0, words))
    });
    let undone = undone.min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((_, words)) = undone.filter(|(left, _)| *left < EXPLAINS * off) {
        return refused(format!("that fit no field; {words}"));
    }
    let rms = off.sqrt() * known.circle;
    if rms <= IMPOSSIBLE {
        return Ok(());
    }
    let arcmin = significant(rms.to_degrees() * 60.0, 2);
    let left_out = set.rows.iter().enumerate().filter_map(|(at, row)| {
        let mut rows = set.rows.clone();
        rows.remove(at);
        let (left, found) = with_rows(set, rows, known)?;
        Some((left, row, north(&found.fit.state) + declination(&found.field().0)))
    });
    let best = left_out.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(left, ..)| *left < EXPLAINS * off);
    let one = best.map_or_else(String::new, |(_, row, magnetic_north)| {
        format!("; without row {} ({}) they fit", row.row, row.position(magnetic_north))
    });
    refused(format!("that differ by {arcmin}′ from those of any field{one}"))
}
