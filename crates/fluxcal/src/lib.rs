//! The programs of fluxcal, by name, and `fluxcal view`, which runs two of them.

pub mod view;

use std::env::{self, consts::EXE_SUFFIX};
use std::path::PathBuf;

/// A program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// Its name.
    pub name: &'static str,
    /// What it does: the first line of its own help.
    pub does: &'static str,
}

/// All of them, in the order in which a calibration needs them.
pub const PROGRAMS: [Program; 13] = [
    of("simulate", "Simulate the recordings of a campaign from a plan"),
    of(
        "ingest",
        "Read files of observatories and loggers into a document: IAGA-2002, IAF, CDF, CSV, NDJSON, Parquet",
    ),
    of("series", "Cut, average, resample and join recordings, and rename their columns"),
    of("coilcal", "Find the constants and gradients of a facility's coils, with their uncertainty"),
    of(
        "sensorcal",
        "Find sensitivity, offset, noise, drift and coefficients of each sensor, with their uncertainty",
    ),
    of(
        "axescal",
        "Find the directions of the sensors and of the coils, in arcseconds, with their uncertainty",
    ),
    of("scalarcal", "Calibrate a vector magnetometer by the magnitude of the field, without a facility"),
    of(
        "starcal",
        "Calibrate a vector magnetometer in flight, beside star cameras and in a model of the field",
    ),
    of(
        "diffmag",
        "Compare two magnetometers side by side: how they are turned and scaled, noise, drift, clocks",
    ),
    of(
        "absolute",
        "Find declination, inclination and the baselines of a variometer by a theodolite with a magnetometer",
    ),
    of(
        "diagnose",
        "Find what physics the model left out: where it shows, which effect explains it, the better model",
    ),
    of("correct", "Turn raw readings into the field in nT, with the uncertainty of each sample"),
    of(
        "report",
        "One page that shows what each stage found: words, tables, plots, and the data of each plot",
    ),
];

const fn of(name: &'static str, does: &'static str) -> Program {
    Program { name, does }
}

/// How alike two names are at least (Jaro and Winkler, 0 to 1) for the one to be meant by the other.
const ALIKE: f64 = 0.75;

/// The program of that name.
pub fn program(name: &str) -> Option<Program> {
    PROGRAMS.into_iter().find(|program| program.name == name)
}

/// The program whose name is most like one that is none.
pub fn nearest(name: &str) -> Option<Program> {
    let alike = |program: &Program| strsim::jaro_winkler(name, program.name);
    PROGRAMS.into_iter().max_by(|a, b| alike(a).total_cmp(&alike(b))).filter(|program| alike(program) > ALIKE)
}

/// The completions for a shell, which go on with those of the program that is named: its options are its own,
/// and are asked of it. None where the shell has none of its own, and only the programs' names are completed.
pub fn script(shell: &str) -> Option<String> {
    let script = match shell {
        "bash" => include_str!("completions/bash"),
        "zsh" => include_str!("completions/zsh"),
        "fish" => include_str!("completions/fish"),
        _ => return None,
    };
    Some(script.replace("PROGRAMS", &PROGRAMS.map(|program| program.name).join(" ")))
}

impl Program {
    /// Where it is: beside the running executable; its bare name, which is looked for on the PATH, where it
    /// is not.
    pub fn path(&self) -> PathBuf {
        let file = format!("{}{EXE_SUFFIX}", self.name);
        let own = env::current_exe().and_then(|own| own.canonicalize()).ok();
        let beside = own.and_then(|own| Some(own.parent()?.join(&file)));
        beside.filter(|path| path.is_file()).unwrap_or(file.into())
    }
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn names_that_are_nearly_right() {
        for (typed, meant) in [
            ("axecal", "axescal"),
            ("Axescal", "axescal"),
            ("sim", "simulate"),
            ("scalecal", "scalarcal"),
            ("diff", "diffmag"),
            ("reprot", "report"),
            ("diagnosis", "diagnose"),
        ] {
            assert_eq!(nearest(typed).map(|program| program.name), Some(meant), "{typed}");
        }
        for typed in ["xyz", "calibrate-everything", ""] {
            assert_eq!(nearest(typed), None, "{typed}");
        }
    }
}
