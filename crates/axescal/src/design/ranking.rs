//! Sets of orientations, ranked by the worst direction they leave.
//!
//! For nominal axes (μ = η = 1), each coil driven once in each orientation and every sensor read, the
//! information of an orientation on the 12 off-diagonal cosines is Jᵀ (σ² 1 + s² G Gᵀ)⁻¹ J, with G the
//! derivatives by a turn of the block, which the theodolites leave uncertain by s. Informations add; the
//! score of a set is the largest standard deviation in the inverse of its sum (NASA eq. 62).

use common::Matrix3x3;
use common::number::counted;
use nalgebra::{DMatrix, Matrix3, SMatrix, SVector, Vector3};
use physics::frames::{self, ARCSEC};
use rayon::prelude::*;
use serde::Serialize;

use super::information::{Pieces, Readings, TURNS};
use crate::{Error, Result};

/// Sets up to this number are all tried; beyond, the search exchanges members.
const MOST_SETS: f64 = 1.5e6;
const BEGINNINGS: usize = 24;

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

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    pub number: usize,
    /// Largest standard deviation, arcsec; absent where no set determines the directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_arcsec: Option<f64>,
    /// `exhaustive` or `exchange`.
    pub search: &'static str,
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
    let sizes: Vec<(Scored, &str)> = (2..=last).map(|size| field.best(size)).collect();
    let best = &sizes[number - 2].0;
    if !best.worst.is_finite() {
        let why = if number < 3 {
            "two never suffice, three do when their rotations are about two different axes"
        } else {
            "their rotations must be about at least two different axes"
        };
        let of = candidates.len();
        return Err(Error::Unanswerable(format!(
            "no {number} of the {of} candidate orientations determine the directions; {why}"
        )));
    }
    let more = (0..candidates.len())
        .filter(|candidate| !best.members.contains(candidate))
        .map(|candidate| (field.score([&best.members[..], &[candidate]].concat()), candidate))
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
            .iter()
            .map(|(best, search)| Row {
                number: best.members.len(),
                worst_arcsec: Some(best.worst).filter(|worst| worst.is_finite()),
                search,
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

/// What an orientation says on the directions; informations add.
pub type Information = SMatrix<f64, TURNS, TURNS>;

/// Information of each candidate on the directions.
pub struct Field(pub Vec<Information>);

/// A set with its score, rounded so that sets equal but for rounding are equal.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
pub struct Scored {
    /// Largest standard deviation, arcsec; infinite where the set does not determine the directions.
    pub worst: f64,
    /// Numbers of the members, rising.
    pub members: Vec<usize>,
}

impl Field {
    pub fn score(&self, mut members: Vec<usize>) -> Scored {
        members.sort_unstable();
        let sum = members.iter().fold(Information::zeros(), |sum, &member| sum + self.0[member]);
        let scale = SVector::<f64, TURNS>::from_fn(|k, _| sum[(k, k)]).max();
        let worst = match sum.cholesky() {
            Some(root) if root.l_dirty().diagonal().min().powi(2) > 1e-9 * scale => {
                let variance = root.inverse().diagonal().max();
                let arcsec = variance.sqrt() / ARCSEC;
                // Twelve digits: sets that differ only by rounding compare as equal.
                let digits = 10f64.powi(11 - arcsec.log10().floor() as i32);
                (arcsec * digits).round() / digits
            }
            _ => f64::INFINITY,
        };
        Scored { worst, members }
    }

    /// The best set of a size and how it was found: of all sets where feasible, else by exchange.
    pub fn best(&self, size: usize) -> (Scored, &'static str) {
        let count = self.0.len();
        let sets = (0..size).map(|k| (count - k) as f64 / (size - k) as f64).product::<f64>();
        if sets <= MOST_SETS {
            (self.exhaustive(size), "exhaustive")
        } else {
            (self.exchange(size), "exchange")
        }
    }

    pub fn exhaustive(&self, size: usize) -> Scored {
        let count = self.0.len();
        let least = |a: Scored, b: Scored| if b < a { b } else { a };
        let none = || Scored { worst: f64::INFINITY, members: (0..size).collect() };
        (0..=count - size)
            .into_par_iter()
            .map(|first| {
                let mut best = none();
                let mut members: Vec<usize> = (first..first + size).collect();
                loop {
                    best = least(best, self.score(members.clone()));
                    // The next combination that begins with `first`, in lexicographic order.
                    let Some(place) = (1..size).rev().find(|&p| members[p] < count - size + p) else {
                        break best;
                    };
                    members[place] += 1;
                    for p in place + 1..size {
                        members[p] = members[p - 1] + 1;
                    }
                }
            })
            .reduce(none, least)
    }

    /// Exchanges one member for one candidate as long as that helps, from several beginnings.
    pub fn exchange(&self, size: usize) -> Scored {
        let count = self.0.len();
        let improve = |mut members: Vec<usize>| {
            let mut best = self.score(members.clone());
            loop {
                let better = (0..size)
                    .flat_map(|place| (0..count).map(move |candidate| (place, candidate)))
                    .filter(|(_, candidate)| !members.contains(candidate))
                    .map(|(place, candidate)| {
                        let mut trial = members.clone();
                        trial[place] = candidate;
                        self.score(trial)
                    })
                    .fold(best.clone(), |a, b| if b.worst < a.worst { b } else { a });
                if better.worst >= best.worst {
                    return best;
                }
                members = better.members.clone();
                best = better;
            }
        };
        (0..BEGINNINGS)
            .into_par_iter()
            .map(|beginning| {
                // Spread over the candidates with a step that has no factor in common with their number.
                let step =
                    (0..).map(|k| 2 * (beginning + k) + 1).find(|step| gcd(*step, count) == 1).unwrap_or(1);
                improve((0..size).map(|k| (beginning + k * step) % count).collect())
            })
            .reduce(
                || Scored { worst: f64::INFINITY, members: (0..size).collect() },
                |a, b| if b < a { b } else { a },
            )
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
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
