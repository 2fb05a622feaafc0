//! The command `axescal design`: its arguments, the candidates, JSON and table out.

use clap::Args;
use common::number::{bare, counted, figures};
use common::{Axis, Matrix3x3};
use nalgebra::{Matrix3, Vector3};
use physics::frames;
use program::pipe::{self, Input};
use program::{apart, number};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::basis;
use super::ranking::{Design, ErrorModel, design};
use super::report::{self, Request};
use crate::{Error, Result};

/// What is asked of `axescal design`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:\n  \
    axescal design --target-arcsec 0.5 --theodolite-arcsec 1 --noise-nt 0.1 --write-plan proof.json\n  \
    axescal design --plan fixtures/plans/magsat.json\n  \
    axescal design --number 4 --noise-nt 1 --drive-nt 50000\n\n\
    What is not stated is taken from the plan, else from a facility with coils of 50 000 nT, theodolites of 1 arcsec (0.3 of it shared), \
    and an instrument with 0.1 nT of white noise. With --number: 1 nT, exact theodolites.")]
pub struct Arguments {
    /// Error that each direction is to keep within, arcsec
    #[arg(long, default_value_t = 0.5, value_parser = number::positive)]
    target_arcsec: f64,
    /// Probability with which it is to be kept, for each direction
    #[arg(long, default_value_t = 0.95, value_parser = number::positive)]
    confidence: f64,
    /// Directions that are to keep within it
    #[arg(long, value_enum, default_value_t = Of::All)]
    of: Of,
    /// Plan for simulate whose facility, instrument, times and temperature runs are to be used
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// Write the plan with the designed recordings to this file, to be simulated
    #[arg(long, value_name = "FILE")]
    write_plan: Option<PathBuf>,
    /// Only rank sets of so many orientations, each coil driven once in each, by the largest standard deviation of a cosine
    #[arg(short, long, conflicts_with_all = ["target_arcsec", "confidence", "of", "plan", "write_plan"])]
    number: Option<usize>,
    /// With --number: largest number in the table; at least one more than is chosen
    #[arg(long, default_value_t = 6)]
    table_to: usize,
    /// Orientations that the fixture can take: cube (24), octagon (8 azimuths by 45°, 4 elevations by 90°), or a JSON
    /// file with a list of 3x3 rotations (GEO -> SEN)
    #[arg(long, default_value = "cube")]
    candidates: String,
    /// White noise of one reading, site and instrument, nT
    #[arg(long, value_parser = number::not_negative)]
    noise_nt: Option<f64>,
    /// Flicker noise: power density at 1 Hz, nT²/Hz
    #[arg(long, value_parser = number::not_negative)]
    flicker_nt2_per_hz: Option<f64>,
    /// Width of one code of the converter, nT
    #[arg(long, value_parser = number::not_negative)]
    quantisation_nt: Option<f64>,
    /// Largest field of the coils, nT: one number, or those of x, y and z with commas
    #[arg(long, value_delimiter = ',', value_parser = number::positive)]
    drive_nt: Vec<f64>,
    /// Standard uncertainty of one theodolite reading of an angle, arcsec; with --number, of the orientation about each axis
    #[arg(long, value_parser = number::not_negative)]
    theodolite_arcsec: Option<f64>,
    /// Standard uncertainty of what all readings of an angle in one setting have in common, arcsec
    #[arg(long, value_parser = number::not_negative)]
    theodolite_shared_arcsec: Option<f64>,
    /// Standard uncertainty of each component of the field that nulling leaves, nT
    #[arg(long, value_parser = number::not_negative)]
    residual_field_nt: Option<f64>,
    /// Standard uncertainty of the coils' gradients, as a share of their field for each metre, ppm/m
    #[arg(long, value_parser = number::not_negative)]
    gradient_ppm_per_m: Option<f64>,
    /// Distance of each sensor from the coils' centre, along its own axis, m
    #[arg(long, value_parser = number::not_negative)]
    sensor_distance_m: Option<f64>,
    /// Turning the block to another orientation and reading the theodolites once, min
    #[arg(long, value_parser = number::not_negative)]
    orientation_min: Option<f64>,
    /// Reading the theodolites once more, min
    #[arg(long, value_parser = number::not_negative)]
    theodolite_min: Option<f64>,
    /// From a change of the drive to the first reading, s
    #[arg(long, value_parser = number::not_negative)]
    settle_s: Option<f64>,
    /// One reading, s
    #[arg(long, value_parser = number::positive)]
    reading_s: Option<f64>,
    /// One level of temperature, min
    #[arg(long, value_parser = number::not_negative)]
    temperature_min: Option<f64>,
    /// Levels of temperature, of all sensors and parts together
    #[arg(long)]
    temperature_levels: Option<usize>,
    /// Write to this file; absent or `-`: standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Say nothing on standard error
    #[arg(short, long)]
    quiet: bool,
}

/// The directions that count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Of {
    /// Those of the sensors
    Sensors,
    /// Those of sensors and coils
    All,
}

/// Runs the command: JSON to standard output, the table to standard error.
pub fn main(arguments: &Arguments) -> Result<()> {
    apart::from_document("--write-plan", arguments.write_plan.as_deref(), arguments.output.as_deref())?;
    let candidates = candidates(&arguments.candidates)?;
    let (design, words) = match arguments.number {
        Some(number) => {
            let design = design(&candidates, arguments.error_model()?, number, arguments.table_to)?;
            common::all_finite("design", &design)?;
            (value(&design), words(&design))
        }
        None => {
            let basis = arguments.basis()?;
            let mut given = basis::given(&basis)?;
            if let Some(levels) = arguments.temperature_levels {
                given.times.temperature_levels = levels;
            }
            let request = Request {
                target_arcsec: arguments.target_arcsec,
                confidence: arguments.confidence,
                coils: arguments.of == Of::All,
            };
            let plan = report::plan(&given, &candidates, request)?;
            common::all_finite("design", &plan)?;
            if let Some(path) = &arguments.write_plan {
                let proof = basis::proof(&basis, &plan.procedure);
                pipe::write(Some(path), &common::to_text(&proof))?;
            }
            (value(&plan), report::words(&plan))
        }
    };
    let document = json!({"fluxcal": common::FORMAT_VERSION, "design": design});
    pipe::write(arguments.output.as_deref(), &common::to_text(&document))?;
    if !arguments.quiet {
        pipe::say(&words);
    }
    Ok(())
}

impl Arguments {
    /// What --number counts with.
    fn error_model(&self) -> Result<ErrorModel> {
        let drive_nt = match self.drive_nt.as_slice() {
            [] => 50_000.0,
            [drive] => *drive,
            _ => return Err(Error::Request("with --number, --drive-nt is one number for all coils".into())),
        };
        Ok(ErrorModel {
            noise_nt: self.noise_nt.unwrap_or(1.0),
            quantisation_nt: self.quantisation_nt.unwrap_or(0.0),
            drive_nt,
            theodolite_arcsec: self.theodolite_arcsec.unwrap_or(0.0),
        })
    }

    /// The plan from the file, or the ordinary one, with what the options state.
    fn basis(&self) -> Result<Value> {
        if self.confidence >= 1.0 {
            return Err(Error::Request(format!(
                "--confidence {}: a probability is below 1, 0.95 for example",
                bare(self.confidence)
            )));
        }
        let mut plan = match &self.plan {
            Some(path) => {
                let input = Input::read(Some(path))?;
                common::at_path::<Value>(&input.text).map_err(|error| input.locate(error))?
            }
            None => basis::ordinary(),
        };
        if !plan.is_object() {
            return Err(Error::Request("--plan: no plan, which is a JSON object".into()));
        }
        let mut state = |part: &str, key: &str, value: Option<f64>| {
            if let Some(value) = value {
                object(&mut plan, part)[key] = value.into();
            }
        };
        state("facility", "theodolite_arcsec", self.theodolite_arcsec);
        state("facility", "theodolite_shared_arcsec", self.theodolite_shared_arcsec);
        state("facility", "residual_field_std_nt", self.residual_field_nt);
        let minutes = |minutes: Option<f64>| minutes.map(|minutes| 60.0 * minutes);
        state("timing", "orientation_s", minutes(self.orientation_min));
        state("timing", "theodolite_s", minutes(self.theodolite_min));
        state("timing", "temperature_settle_s", minutes(self.temperature_min));
        state("timing", "field_settle_s", self.settle_s);
        state("timing", "reading_s", self.reading_s);
        let nominal = plan["instrument"]["nominal_sensitivity_nt_per_v"].as_f64();
        if let Some(width) = self.quantisation_nt {
            let (key, width) =
                nominal.map_or(("quantisation_nt", width), |nominal| ("quantisation_v", width / nominal));
            object(&mut plan, "instrument")[key] = width.into();
        }
        if self.noise_nt.is_some() || self.flicker_nt2_per_hz.is_some() {
            let mut noise = basis::noise(&plan);
            noise.white_rms_nt = self.noise_nt.or(noise.white_rms_nt);
            noise.flicker_nt2_per_hz_at_1hz = self.flicker_nt2_per_hz.or(noise.flicker_nt2_per_hz_at_1hz);
            object(&mut plan, "instrument")["noise"] = value(&noise);
        }
        if let Some(distance) = self.sensor_distance_m {
            object(&mut plan, "instrument")["positions_m"] =
                json!({"x": [distance, 0.0, 0.0], "y": [0.0, distance, 0.0], "z": [0.0, 0.0, distance]});
        }
        self.coils(&mut plan)?;
        Ok(plan)
    }

    /// What the options state of the coils.
    fn coils(&self, plan: &mut Value) -> Result<()> {
        let drive_nt = match *self.drive_nt.as_slice() {
            [] => None,
            [drive] => Some([drive; 3]),
            [x, y, z] => Some([x, y, z]),
            _ => return Err(Error::Request("--drive-nt takes one number, or three with commas".into())),
        };
        for axis in Axis::ALL {
            let constant = &plan["calibration"]["coils"][axis.letter()]["constant_nt_per_a"];
            let constant = constant.as_f64().or(constant["value"].as_f64()).unwrap_or(40_000.0);
            let coil = object(object(object(plan, "facility"), "coils"), axis.letter());
            if let Some(drive_nt) = drive_nt {
                coil["max_nt"] = drive_nt[axis.index()].into();
            }
            if let Some(ppm) = self.gradient_ppm_per_m {
                let known = coil.get("gradient_nt_per_m_a").cloned().unwrap_or_default();
                let value = known.as_f64().or(known["value"].as_f64()).unwrap_or(0.0);
                let std = ppm * 1e-6 * constant.abs();
                coil["gradient_nt_per_m_a"] = json!({"value": value, "std": std});
            }
        }
        Ok(())
    }
}

fn value<T: serde::Serialize>(of: &T) -> Value {
    serde_json::to_value(of).expect("numbers, texts and lists of them are JSON")
}

/// An object in another one, made where there is none.
fn object<'a>(of: &'a mut Value, key: &str) -> &'a mut Value {
    if !of[key].is_object() {
        of[key] = json!({});
    }
    &mut of[key]
}

/// The orientations that a fixture can take.
fn candidates(name: &str) -> Result<Vec<Matrix3<f64>>> {
    match name {
        "cube" => Ok(frames::cube_rotations()),
        "octagon" => Ok(octagon()),
        file => {
            let input = Input::read(Some(Path::new(file)))?;
            let list: Vec<Matrix3x3> = common::at_path(&input.text).map_err(|error| input.locate(error))?;
            frames::rotations(&list, file)
        }
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

fn words(design: &Design) -> String {
    let model = &design.error_model;
    let mut text = format!(
        "axescal design: {}, {} nT noise and quantisation steps of {} nT in {} nT, theodolites {}\"\n  \
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
        let [with, without] = [more.worst_arcsec, design.worst_arcsec].map(|worst| figures(worst, 4));
        let chosen = design.orientations.len();
        let _ = writeln!(text, "  one more beside the chosen {chosen}: {with}\" instead of {without}\"");
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
