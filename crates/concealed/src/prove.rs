//! The whole proof: make, seal, diagnose, open, score, write.

use clap::Args;
use std::path::PathBuf;

use crate::Error;
use crate::page::{self, Besides};
use crate::programs::Programs;
use crate::score::Score;
use crate::seal::Folder;
use crate::sets::Set;

/// The seed on which this crate was developed.
const DEVELOPMENT: u64 = 1;

/// What is asked of a proof.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// Seed of the scored cases; development was on 1
    #[arg(long, default_value_t = 1001)]
    pub seed: u64,
    /// Rounds of every set; one has each kind at each strength once
    #[arg(long, default_value_t = 2)]
    pub rounds: usize,
    /// At most so many cases of a set
    #[arg(long, value_name = "N")]
    pub cases: Option<usize>,
    /// Where documents, seals and answers are kept; what is there already is not diagnosed again
    #[arg(long, value_name = "FOLDER", default_value = "target/concealed")]
    pub folder: PathBuf,
    /// Where the stages' programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
    /// The page to write
    #[arg(short, long, value_name = "FILE", default_value = "docs/proof.md")]
    pub output: PathBuf,
}

/// Proves, and writes the page.
pub fn run(arguments: &Arguments) -> Result<Score, Error> {
    let programs = Programs::find(arguments.programs.as_deref())?;
    programs.program("diagnose")?;
    let folder = Folder::at(&arguments.folder)?;
    for set in Set::ALL {
        let count = (set.round() * arguments.rounds).min(arguments.cases.unwrap_or(usize::MAX));
        folder.seal(&set.cases(arguments.seed, count))?;
    }
    common::pipe::say(&format!("concealed: sealed, {}", folder.seal_of_all()?));
    let answers = folder.diagnose(&programs)?;
    let score = Score::of(&folder, &answers)?;
    let seeds = format!(
        "This crate was developed on seed {DEVELOPMENT}, with the programs as they were: no threshold of `diagnose` was set by these cases. \
         Scored is seed {}.",
        arguments.seed
    );
    let page = page::of(&score, &Besides { seeds: &seeds, swarm: None, pillar: None });
    common::pipe::write(Some(&arguments.output), &page)?;
    Ok(score)
}

/// The goals in a few lines, for people.
pub fn summary(score: &Score) -> String {
    let line = |goal: crate::score::Goal| {
        format!("  {}: {} (wanted: {}): {}\n", goal.what, goal.found.words(), goal.wanted(), goal.verdict())
    };
    let lines: String = score.goals().into_iter().map(line).collect();
    format!("concealed: {} cases\n{lines}", score.outcomes.len())
}
