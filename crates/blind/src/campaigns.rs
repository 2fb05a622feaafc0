//! Two campaigns of one case each: an orbit and an observatory's month.

use clap::Args;
use std::path::PathBuf;
use std::time::Duration;
use testkit::programs::Programs;

use crate::Error;
use crate::folder::{self, Asked, Folder};
use crate::page::{month, orbit};
use concealed::{pillar, swarm};

/// What is asked of one of the two campaigns.
#[derive(Args, Clone, Debug)]
pub struct Campaign {
    /// Its seed
    #[arg(long, default_value_t = 8001)]
    pub seed: u64,
    /// Where document and answer are kept
    #[arg(long, value_name = "FOLDER", default_value = "target/blind")]
    pub folder: PathBuf,
    /// Where the stages' programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
}

/// The orbit, diagnosed, in words.
pub fn orbit(arguments: &Campaign) -> Result<String, Error> {
    let programs = Programs::find(arguments.programs.as_deref())?;
    let folder = Folder::at(&arguments.folder.join("orbit"))?;
    let flight = swarm::flight(arguments.seed);
    let case = &flight.case.truth.case;
    folder.write(case, &flight.case.document)?;
    // A program that does not take a scalar magnetometer without coils refuses the document.
    let answer = match answered(&folder, &Asked::diagnose(&programs), case) {
        Ok(answer) => Some(answer),
        Err(Error::Program { .. }) => None,
        Err(error) => return Err(error),
    };
    Ok(orbit::section(&flight, answer.as_ref()))
}

/// The observatory, compared, diagnosed, in words.
pub fn month(arguments: &Campaign) -> Result<String, Error> {
    let programs = Programs::find(arguments.programs.as_deref())?;
    let case = pillar::month(arguments.seed);
    let name = &case.truth.case;
    let first = Folder::at(&arguments.folder.join("month"))?;
    first.write(name, &case.document)?;
    let clock = ["--correct-clock".to_string()];
    let diffmag =
        Asked { name: "diffmag", arguments: &clock, programs: &programs, limit: Duration::from_secs(900) };
    let compared = answered(&first, &diffmag, name)?;
    let second = Folder::at(&arguments.folder.join("month-compared"))?;
    second.write(name, &compared)?;
    let answer = answered(&second, &Asked::diagnose(&programs), name)?;
    Ok(month::section(&case.truth, &compared, &answer))
}

fn answered(folder: &Folder, asked: &Asked<'_>, case: &str) -> Result<serde_json::Value, Error> {
    let answers = folder.answers(asked.name, asked.arguments, asked.programs)?;
    folder.answer(asked, case, &answers)?;
    folder::value(&answers.join(format!("{case}.json")))
}
