//! Readings that fit no position: what would make them fit.

use common::number::significant;

use crate::Error;
use crate::fit::{Found, Known, fit};
use crate::read::{Circle, Set};

/// χ² over its degrees of freedom beyond which readings are no measurement. Circles are then some minutes of arc off.
const IMPOSSIBLE: f64 = 1e4;
/// An explanation leaves less than this share of χ².
const EXPLAINS: f64 = 1e-2;

/// What may be wrong with a whole sheet, and the remedy.
type Mistake = (fn(&mut Circle), &'static str);

const MISTAKES: [Mistake; 3] = [
    (grades, "its circles fit as grades (gon); multiply horizontal_deg and vertical_deg by 0.9"),
    (signs, "residual_nt fits with the other sign; it is positive where the field points along the view"),
    (
        faces,
        "its positions fit with the magnetometer above for below; exchange 90 and 270 of vertical_deg in the readings of the declination",
    ),
];

fn grades(circle: &mut Circle) {
    if let Circle::Mark { horizontal, .. } | Circle::Field { horizontal: Ok(horizontal), .. } = circle {
        *horizontal *= 0.9;
    }
    if let Circle::Field { zenith, .. } = circle {
        *zenith *= 0.9;
    }
}

fn signs(circle: &mut Circle) {
    if let Circle::Field { reading_nt, .. } = circle {
        *reading_nt = -*reading_nt;
    }
}

fn faces(circle: &mut Circle) {
    if let Circle::Field { horizontal: Ok(_), zenith, .. } = circle
        && zenith.cos().abs() < 0.035
    {
        *zenith = -*zenith;
    }
}

/// That readings are those of a theodolite in the field of the Earth.
///
/// Errors: readings that fit nothing, with what would make them fit; a field that points south.
pub fn position(set: &Set, found: &Found, known: Known) -> Result<(), Error> {
    let per_freedom = |found: &Found| {
        let (chi_squared, free) = found.circles();
        chi_squared / free.max(1.0)
    };
    let off = per_freedom(found);
    let refused = |words: String| {
        Err(Error::document(
            &set.path,
            words,
            "the readings of one measurement; correct the sheet or leave it out",
        ))
    };
    if off > IMPOSSIBLE {
        for (change, words) in MISTAKES {
            let mut changed = Set {
                rows: set.rows.clone(),
                without_variometer: Vec::new(),
                id: set.id.clone(),
                path: set.path.clone(),
                ..*set
            };
            changed.rows.iter_mut().for_each(|row| change(&mut row.circle));
            if fit(&changed, known).is_ok_and(|other| per_freedom(&other) < EXPLAINS * off) {
                return refused(format!("readings of \"{}\" that fit no field; {words}", set.id));
            }
        }
        let rms = off.sqrt() * known.circle.to_degrees() * 60.0;
        return refused(format!(
            "readings of \"{}\" that differ by {}′ from those of any field",
            set.id,
            significant(rms, 2)
        ));
    }
    if found.field().0.x < 0.0 {
        return refused(format!(
            "a field that points south in \"{}\": the azimuth of the mark, or the faces of its readings, are off by 180°",
            set.id
        ));
    }
    Ok(())
}
