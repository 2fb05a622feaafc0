//! The command `axescal design`: its arguments, the candidates, JSON and table out.

use clap::Args;
use common::number::{bare, counted, figures};
use common::{Axis, Matrix3x3};
use nalgebra::{Matrix3, Vector3};
use physics::frames;
use program::number;
use program::pipe::{self, Input};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::{Design, ErrorModel, design};

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
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_parser = number::not_negative)]
    noise_nt: f64,
    /// Width of one code of the converter, nT
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_parser = number::not_negative)]
    quantisation_nt: f64,
    /// Field of the driven coil, nT
    #[arg(long, default_value_t = 50_000.0, allow_negative_numbers = true, value_parser = number::positive)]
    drive_nt: f64,
    /// Standard uncertainty of the orientation about each axis, arcsec
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_parser = number::not_negative)]
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
    common::all_finite("design", &design)?;
    let document = serde_json::json!({"fluxcal": common::FORMAT_VERSION, "design": design});
    pipe::write(arguments.output.as_deref(), &common::to_text(&document))?;
    if !arguments.quiet {
        pipe::say(&words(&design));
    }
    Ok(())
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
    let input = Input::read(Some(path))?;
    let list: Vec<Matrix3x3> = common::at_path(&input.text).map_err(|error| input.locate(error))?;
    frames::rotations(&list, &path.display().to_string())
}

fn words(design: &Design) -> String {
    let model = &design.error_model;
    let mut text = format!(
        "axescal design: {}, {} nT noise and {} nT codes in {} nT, theodolites {}\"\n  \
         orientations  worst arcsec  search\n",
        counted(design.candidates, "candidate orientation"),
        bare(model.noise_nt),
        bare(model.quantisation_nt),
        bare(model.drive_nt),
        bare(model.theodolite_arcsec)
    );
    // Writing to a String cannot fail.
    for row in &design.table {
        let worst = row.worst_arcsec.map_or_else(|| "undetermined".to_string(), |worst| figures(worst, 4));
        let mark = if row.number == design.orientations.len() { " <- chosen" } else { "" };
        let _ = writeln!(text, "  {:>12}  {worst:>12}  {}{mark}", row.number, row.search);
    }
    if let Some(more) = &design.one_more {
        let _ = writeln!(
            text,
            "  one more beside the chosen {}: {}\" instead of {}\"",
            design.orientations.len(),
            figures(more.worst_arcsec, 4),
            figures(design.worst_arcsec, 4)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_octagon_has_thirty_two_orientations() {
        let all = octagon();
        assert_eq!(all.len(), 32);
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| (a - b).norm() > 0.1), "{i} is there twice");
        }
    }
}
