//! Sets of orientations, ranked by the worst direction they leave.
//!
//! For nominal axes (μ = η = 1), each coil driven once in each orientation and every sensor read, the
//! information of an orientation on the 12 off-diagonal cosines is Jᵀ (σ² 1 + s² G Gᵀ)⁻¹ J, with G the
//! derivatives by a turn of the block, which the theodolites leave uncertain by s. Informations add; the
//! score of a set is the largest standard deviation in the inverse of its sum (NASA eq. 62).

use common::Matrix3x3;
use common::number::counted;
use nalgebra::{DMatrix, Matrix3, Vector3};
use physics::frames::{self, ARCSEC};
use serde::Serialize;

use super::information::{Pieces, Readings, TURNS};
use super::search::{Field, Information, Scored};
use crate::{Error, Result};

/// Errors of one reading and of one orientation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ErrorModel {
    /// Noise of one reading, nT.
    pub noise_nt: f64,
    /// Width of one code, nT.
    pub quantisation_nt: f64,
    /// Field of the driven coil, nT.
    pub drive_nt: f64,
    /// Standard uncertainty of the orientation about each axis, arcsec.
    pub theodolite_arcsec: f64,
}

/// The best orientations and what others would give.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Design {
    pub error_model: ErrorModel,
    pub candidates: usize,
    /// The set, R (GEO -> SEN) each.
    pub orientations: Vec<Matrix3x3>,
    /// Largest standard deviation of an off-diagonal cosine with it, arcsec.
    pub worst_arcsec: f64,
    /// The orientation to add to this set, and what it would bring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub one_more: Option<OneMore>,
    pub table: Vec<Row>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OneMore {
    /// R of the orientation to add.
    pub orientation: Matrix3x3,
    /// Largest standard deviation then, arcsec.
    pub worst_arcsec: f64,
}

/// The best set of one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub number: usize,
    /// Largest standard deviation, arcsec; absent where no set determines the directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_arcsec: Option<f64>,
    /// `exhaustive` or `exchange`.
    pub search: String,
}

/// The best `number` of the candidates, and the table up to `table_to`.
pub fn design(
    candidates: &[Matrix3<f64>],
    error_model: ErrorModel,
    number: usize,
    table_to: usize,
) -> Result<Design> {
    check(candidates, &error_model, number)?;
    let field = Field(candidates.iter().map(|rotation| information(rotation, &error_model)).collect());
    let last = table_to.max(number + 1).min(candidates.len());
    let sizes: Vec<(usize, Scored, &str)> = (2..=last).map(|size| field.best(size)).collect();
    let best = sizes.iter().find(|(size, ..)| *size == number).map(|(_, best, _)| best.clone());
    let best = best.filter(|best| best.worst.is_finite()).ok_or_else(|| {
        let why = if number < 3 {
            "two never suffice, three do when their rotations are about two different axes"
        } else {
            "their rotations must be about at least two different axes"
        };
        let of = candidates.len();
        Error::Unanswerable(format!(
            "no {number} of the {of} candidate orientations determine the directions; {why}"
        ))
    })?;
    let more = (0..candidates.len())
        .filter(|candidate| !best.members.contains(candidate))
        .map(|candidate| {
            let mut members = best.members.clone();
            members.push(candidate);
            (field.score(members), candidate)
        })
        .min_by(|(a, _), (b, _)| a.worst.total_cmp(&b.worst));
    Ok(Design {
        error_model,
        candidates: candidates.len(),
        orientations: best.members.iter().map(|&member| frames::rows(&candidates[member])).collect(),
        worst_arcsec: best.worst,
        one_more: more.map(|(scored, candidate)| OneMore {
            orientation: frames::rows(&candidates[candidate]),
            worst_arcsec: scored.worst,
        }),
        table: sizes
            .into_iter()
            .map(|(number, best, search)| Row {
                number,
                worst_arcsec: Some(best.worst).filter(|worst| worst.is_finite()),
                search: search.into(),
            })
            .collect(),
    })
}

/// Largest standard deviation of an off-diagonal cosine for a given set of orientations, arcsec.
pub fn worst_arcsec(orientations: &[Matrix3<f64>], error_model: &ErrorModel) -> f64 {
    let all = orientations.iter().map(|rotation| information(rotation, error_model)).collect();
    Field(all).score((0..orientations.len()).collect()).worst
}

fn check(candidates: &[Matrix3<f64>], model: &ErrorModel, number: usize) -> Result<()> {
    if model.noise_nt + model.quantisation_nt < 1e-9 * model.drive_nt {
        return Err(Error::Request(
            "without noise or quantisation all sets are equally exact; give --noise-nt".into(),
        ));
    }
    if candidates.len() < 3 {
        return Err(Error::Request(format!(
            "{}; at least 3 are needed",
            counted(candidates.len(), "candidate orientation")
        )));
    }
    if number > candidates.len() || number < 2 {
        let (most, of) = (candidates.len(), counted(candidates.len(), "candidate"));
        let number = counted(number, "orientation");
        return Err(Error::Request(format!("{number} of {of}; choose at least 3 and at most {most}")));
    }
    Ok(())
}

/// Jᵀ (σ² 1 + s² G Gᵀ)⁻¹ J of one orientation; the tangents of nominal axes are the off-diagonal cosines.
fn information(rotation: &Matrix3<f64>, model: &ErrorModel) -> Information {
    let variance = model.noise_nt.powi(2) + model.quantisation_nt.powi(2) / 12.0;
    let readings = Readings {
        drives_nt: (0..3).map(|coil| Vector3::ith(coil, model.drive_nt)).collect(),
        covariance: std::array::from_fn(|_| DMatrix::identity(3, 3) * variance),
        gradient_per_m: [0.0; 3],
        positions_m: [Vector3::zeros(); 3],
    };
    let said = Pieces::of(rotation, &Matrix3::identity(), &readings).said(model.theodolite_arcsec * ARCSEC);
    said.information.fixed_view::<TURNS, TURNS>(0, 0).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_in_50_000() -> ErrorModel {
        ErrorModel { noise_nt: 1.0, quantisation_nt: 0.0, drive_nt: 50_000.0, theodolite_arcsec: 0.0 }
    }

    #[test]
    fn best_sets_of_the_cube() {
        let design = design(&frames::cube_rotations(), one_in_50_000(), 4, 5).expect("a design");
        let worst: Vec<Option<f64>> = design.table.iter().map(|row| row.worst_arcsec).collect();
        assert_eq!(worst[0], None, "two never suffice");
        assert!((worst[1].expect("three suffice") - 2.526).abs() < 1e-3);
        assert!((design.worst_arcsec - 2.063).abs() < 1e-3);
        assert!(design.one_more.expect("one more").worst_arcsec < design.worst_arcsec);
    }

    #[test]
    fn exchange_finds_what_exhaustion_finds() {
        let all = frames::cube_rotations();
        let field = Field(all.iter().map(|rotation| information(rotation, &one_in_50_000())).collect());
        for size in [3, 4, 5] {
            assert_eq!(field.exchange(size).worst, field.exhaustive(size).worst, "{size} orientations");
        }
    }
}
