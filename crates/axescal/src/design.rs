//! Which orientations of the block determine the directions best (`axescal design`).
//!
//! For nominal axes (μ = η = 1), each coil driven once in each orientation and every sensor read, the
//! information of an orientation on the 12 off-diagonal cosines is Jᵀ (σ² 1 + s² G Gᵀ)⁻¹ J, with G the derivatives by a
//! turn of the block, which the theodolites leave uncertain by s. Informations add; the score of a set is the
//! largest standard deviation in the inverse of its sum (NASA eq. 62).

use clap::Args;
use common::{Axis, Matrix3x3, pipe};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use physics::frames::{self, ARCSEC, tangents};
use physics::reading;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::Error;

/// Sets up to this number are all tried; beyond, the search exchanges members.
const MOST_SETS: f64 = 1.5e6;
/// Beginnings of the exchange search.
const BEGINNINGS: usize = 24;

/// What is asked of `axescal design`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:\n  axescal design --number 4 --noise-nt 1 --drive-nt 50000")]
pub struct Arguments {
    /// Number of orientations to choose
    #[arg(short, long, default_value_t = 4)]
    number: usize,
    /// Orientations that the fixture can take: cube (24), octagon (8 azimuths by 45°, 4 elevations by 90°), or a JSON
    /// file with a list of 3x3 rotations (GEO -> SEN)
    #[arg(long, default_value = "cube")]
    candidates: String,
    /// Noise of one reading, site and instrument, nT
    #[arg(long, default_value_t = 1.0)]
    noise_nt: f64,
    /// Width of one code of the converter, nT
    #[arg(long, default_value_t = 0.0)]
    quantisation_nt: f64,
    /// Field of the driven coil, nT
    #[arg(long, default_value_t = 50_000.0)]
    drive_nt: f64,
    /// Standard uncertainty of the orientation about each axis, arcsec
    #[arg(long, default_value_t = 0.0)]
    theodolite_arcsec: f64,
    /// Largest number in the table; at least one more than is chosen
    #[arg(long, default_value_t = 6)]
    table_to: usize,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Say nothing on standard error
    #[arg(short, long)]
    quiet: bool,
}

/// Errors of one reading and of one orientation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Design {
    /// What the readings err by.
    pub error_model: ErrorModel,
    /// Number of orientations that the fixture can take.
    pub candidates: usize,
    /// The set, R (GEO -> SEN) each.
    pub orientations: Vec<Matrix3x3>,
    /// Largest standard deviation of an off-diagonal cosine with it, arcsec.
    pub worst_arcsec: f64,
    /// The orientation to add to this set, and what it would bring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub one_more: Option<OneMore>,
    /// The best set of each size.
    pub table: Vec<Row>,
}

/// What one more orientation would buy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OneMore {
    /// R of the orientation to add.
    pub orientation: Matrix3x3,
    /// Largest standard deviation then, arcsec.
    pub worst_arcsec: f64,
}

/// The best set of one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Number of orientations.
    pub number: usize,
    /// Largest standard deviation, arcsec; absent where no set determines the directions.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_arcsec: Option<f64>,
    /// `exhaustive` or `exchange`.
    pub search: String,
}

type Information = SMatrix<f64, 12, 12>;

/// The candidates with their information.
struct Field {
    information: Vec<Information>,
}

/// A set with its score, rounded so that sets equal but for rounding are equal.
#[derive(Clone, Debug, PartialEq, PartialOrd)]
struct Scored {
    worst: f64,
    members: Vec<usize>,
}

/// Runs the command: JSON to standard output, the table to standard error.
pub fn main(arguments: &Arguments) -> Result<(), common::Error> {
    let candidates = candidates(&arguments.candidates)?;
    let error_model = ErrorModel {
        noise_nt: arguments.noise_nt,
        quantisation_nt: arguments.quantisation_nt,
        drive_nt: arguments.drive_nt,
        theodolite_arcsec: arguments.theodolite_arcsec,
    };
    let design = design(&candidates, error_model, arguments.number, arguments.table_to)?;
    let document = serde_json::json!({"fluxcal": common::FORMAT_VERSION, "design": design});
    pipe::write(arguments.output.as_deref(), &common::to_text(&document))?;
    if !arguments.quiet {
        pipe::say(&words(&design));
    }
    Ok(())
}

/// The best `number` of the candidates, and the table up to `table_to`.
pub fn design(
    candidates: &[Matrix3<f64>],
    error_model: ErrorModel,
    number: usize,
    table_to: usize,
) -> Result<Design, Error> {
    check(candidates, &error_model, number)?;
    let field = Field {
        information: candidates.iter().map(|rotation| information(rotation, &error_model)).collect(),
    };
    let last = table_to.max(number + 1).min(candidates.len());
    let sizes: Vec<(usize, Scored, &str)> = (2..=last).map(|size| field.best(size)).collect();
    let best = sizes.iter().find(|(size, ..)| *size == number).map(|(_, best, _)| best.clone());
    let best = best.filter(|best| best.worst.is_finite()).ok_or_else(|| {
        Error::RankShort(format!(
            "no {number} of the {} candidate orientations determine the directions; {}",
            candidates.len(),
            if number < 3 {
                "two never suffice, three do when their turns are about two different axes".to_string()
            } else {
                "their turns must be about at least two different axes".to_string()
            }
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
    Field { information: all }.score((0..orientations.len()).collect()).worst
}

fn check(candidates: &[Matrix3<f64>], model: &ErrorModel, number: usize) -> Result<(), common::Error> {
    let positive = |value: f64| value.is_finite() && value > 0.0;
    if !positive(model.drive_nt)
        || model.noise_nt < 0.0
        || model.quantisation_nt < 0.0
        || model.theodolite_arcsec < 0.0
    {
        return Err(common::Error::Request("the drive must be positive and no error negative".into()));
    }
    if !positive(model.noise_nt + model.quantisation_nt) {
        return Err(common::Error::Request(
            "without noise or quantisation every set is perfect; give --noise-nt".into(),
        ));
    }
    if number > candidates.len() || number < 2 {
        return Err(common::Error::Request(format!(
            "{number} orientations of {} candidates; choose at least 3 and at most {}",
            candidates.len(),
            candidates.len()
        )));
    }
    Ok(())
}

/// Jᵀ (σ² 1 + s² G Gᵀ)⁻¹ J of one orientation; the tangents of nominal axes are the off-diagonal cosines.
fn information(rotation: &Matrix3<f64>, model: &ErrorModel) -> Information {
    let variance = model.noise_nt.powi(2) + model.quantisation_nt.powi(2) / 12.0;
    let theodolite = (model.theodolite_arcsec * ARCSEC).powi(2);
    let mut jacobian = SMatrix::<f64, 9, 12>::zeros();
    let mut turn = SMatrix::<f64, 9, 3>::zeros();
    for j in 0..3 {
        let coil = Vector3::ith(j, 1.0);
        for i in 0..3 {
            let sensor = Vector3::ith(i, 1.0);
            let at = reading(&sensor, rotation, &(coil * model.drive_nt));
            let row = 3 * j + i;
            for k in 0..2 {
                jacobian[(row, 2 * i + k)] = at.by_sensor.dot(&tangents(&sensor)[k]);
                jacobian[(row, 6 + 2 * j + k)] = model.drive_nt * at.by_field.dot(&tangents(&coil)[k]);
            }
            turn.set_row(row, &at.by_rotation.transpose());
        }
    }
    let covariance = SMatrix::<f64, 9, 9>::identity() * variance + turn * turn.transpose() * theodolite;
    let solved = covariance.cholesky().map(|root| root.solve(&jacobian)).unwrap_or_else(SMatrix::zeros);
    jacobian.transpose() * solved
}

impl Field {
    fn score(&self, mut members: Vec<usize>) -> Scored {
        members.sort_unstable();
        let sum = members.iter().fold(Information::zeros(), |sum, &member| sum + self.information[member]);
        let scale = SVector::<f64, 12>::from_fn(|k, _| sum[(k, k)]).max();
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

    /// The best set of a size: of all sets where that is feasible, else by exchange.
    fn best(&self, size: usize) -> (usize, Scored, &'static str) {
        let count = self.information.len();
        let sets = (0..size).map(|k| (count - k) as f64 / (size - k) as f64).product::<f64>();
        if sets <= MOST_SETS {
            (size, self.exhaustive(size), "exhaustive")
        } else {
            (size, self.exchange(size), "exchange")
        }
    }

    fn exhaustive(&self, size: usize) -> Scored {
        let count = self.information.len();
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
    fn exchange(&self, size: usize) -> Scored {
        let count = self.information.len();
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

/// The orientations that a fixture can take.
fn candidates(name: &str) -> Result<Vec<Matrix3<f64>>, common::Error> {
    match name {
        "cube" => Ok(frames::cube_rotations()),
        "octagon" => Ok(octagon()),
        file => from_file(Path::new(file)),
    }
}

/// Azimuth by 45° about the block's vertical axis, then elevation by 90° about north.
fn octagon() -> Vec<Matrix3<f64>> {
    let turn =
        |axis: Axis, degrees: f64| frames::small_rotation(&Vector3::ith(axis.index(), degrees.to_radians()));
    (0..4)
        .flat_map(|elevation| {
            (0..8).map(move |azimuth| (f64::from(elevation) * 90.0, f64::from(azimuth) * 45.0))
        })
        .map(|(elevation, azimuth)| turn(Axis::X, elevation) * turn(Axis::Z, azimuth))
        .collect()
}

fn from_file(path: &Path) -> Result<Vec<Matrix3<f64>>, common::Error> {
    let text = std::fs::read_to_string(path).map_err(|source| common::Error::File {
        path: path.into(),
        action: "read",
        source,
    })?;
    let list: Vec<Matrix3x3> = serde_json::from_str(&text).map_err(|error| common::Error::Syntax {
        message: format!(
            "{}: {error}; expected a JSON list of 3x3 rotations, [[[1,0,0],[0,1,0],[0,0,1]], …]",
            path.display()
        ),
    })?;
    list.iter()
        .enumerate()
        .map(|(index, rows)| match frames::Orientation::from_matrix(rows, None) {
            Ok(orientation) => Ok(orientation.rotation),
            Err(physics::Error::NotARotation { found, expected }) => {
                Err(common::Error::document(format!("{}[{index}]", path.display()), found, expected))
            }
            Err(other) => Err(common::Error::Request(other.to_string())),
        })
        .collect()
}

fn words(design: &Design) -> String {
    let model = &design.error_model;
    let mut text = format!(
        "axescal design: {} candidate orientations, {} nT noise and {} nT codes in {} nT, theodolites {}\"\n  \
         orientations  worst arcsec  search\n",
        design.candidates, model.noise_nt, model.quantisation_nt, model.drive_nt, model.theodolite_arcsec
    );
    // Writing to a String cannot fail.
    for row in &design.table {
        let worst =
            row.worst_arcsec.map_or_else(|| "undetermined".to_string(), |worst| format!("{worst:.3}"));
        let mark = if row.number == design.orientations.len() { " <- chosen" } else { "" };
        let _ = writeln!(text, "  {:>12}  {worst:>12}  {}{mark}", row.number, row.search);
    }
    if let Some(more) = &design.one_more {
        let _ = writeln!(
            text,
            "  one more beside the chosen {}: {:.3}\" instead of {:.3}\"",
            design.orientations.len(),
            more.worst_arcsec,
            design.worst_arcsec
        );
    }
    text
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
        let field = Field {
            information: all.iter().map(|rotation| information(rotation, &one_in_50_000())).collect(),
        };
        for size in [3, 4, 5] {
            assert_eq!(field.exchange(size).worst, field.exhaustive(size).worst, "{size} orientations");
        }
    }

    #[test]
    fn an_octagon_has_thirty_two_orientations() {
        let all = octagon();
        assert_eq!(all.len(), 32);
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| (a - b).norm() > 0.1), "{i} is there twice");
        }
    }
}
