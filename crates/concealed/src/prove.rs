//! The whole proof: make, seal, diagnose, open, score, write.

use clap::Args;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::case::Case;
use crate::page::{self, Besides};
use crate::programs::Programs;
use crate::score::Score;
use crate::seal::{self, Folder};
use crate::sets::Set;
use crate::{pillar, real, swarm};

/// The seeds on which this crate and `diagnose` were developed.
const DEVELOPMENT: [u64; 6] = [1, 1001, 2001, 3001, 4001, 6001];

/// What is asked of a proof.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// Seed of the scored cases; development was on 1, 1001, 2001, 3001, 4001 and 6001
    #[arg(long, default_value_t = 8001)]
    pub seed: u64,
    /// Rounds of every set; one has each kind at each strength once
    #[arg(long, default_value_t = 2)]
    pub rounds: usize,
    /// At most so many cases of a set
    #[arg(long, value_name = "N")]
    pub cases: Option<usize>,
    /// Leave out the orbit, the observatory and the recordings that somebody else made
    #[arg(long)]
    pub cases_only: bool,
    /// Have cargo build the programs first
    #[arg(long)]
    pub build: bool,
    /// The folder of the recordings that somebody else made
    #[arg(long, value_name = "FOLDER", default_value = "../shared/data")]
    pub data: PathBuf,
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

/// Makes, seals and diagnoses the cases, then opens and scores them.
pub fn run(arguments: &Arguments) -> Result<Score, Error> {
    if arguments.build {
        Programs::build()?;
    }
    let programs = Programs::find(arguments.programs.as_deref())?;
    programs.program("diagnose")?;
    let folder = cases(arguments)?;
    for set in Set::ALL {
        let count = (set.round() * arguments.rounds).min(arguments.cases.unwrap_or(usize::MAX));
        folder.seal(&set.cases(arguments.seed, count))?;
    }
    program::pipe::say(&format!("concealed: sealed, {}", folder.seal_of_all()?));
    score(arguments)
}

/// Where the cases of the seed are.
fn cases(arguments: &Arguments) -> Result<Folder, Error> {
    Folder::at(&arguments.folder.join(format!("seed-{}", arguments.seed)))
}

/// Scores a folder of sealed cases, those that have no answer yet diagnosed first, and writes the page.
pub fn score(arguments: &Arguments) -> Result<Score, Error> {
    let programs = Programs::find(arguments.programs.as_deref())?;
    let folder = cases(arguments)?;
    let answers = folder.diagnose(&programs)?;
    let score = Score::of(&folder, &answers)?;
    let seeds = format!(
        "Developed was on seeds {}; scored here is seed {}, by which nothing in `diagnose` was set. All but the first were scored before: what failed there led to the \
         next build, and the seed to the others.",
        DEVELOPMENT.map(|seed| seed.to_string()).join(", "),
        arguments.seed
    );
    let campaign = |of: fn(u64, &Path, &Programs) -> Result<String, Error>| {
        let wanted = !arguments.cases_only;
        wanted.then(|| of(arguments.seed, &arguments.folder, &programs)).transpose()
    };
    let real = (!arguments.cases_only).then(|| recorded(arguments, programs.clone())).transpose()?;
    let besides = Besides { seeds: &seeds, swarm: campaign(flown)?, pillar: campaign(compared)?, real };
    program::pipe::write(Some(&arguments.output), &page::of(&score, &besides))?;
    Ok(score)
}

/// What is asked of one of the two campaigns.
#[derive(Args, Clone, Debug)]
pub struct Campaign {
    /// Its seed
    #[arg(long, default_value_t = 8001)]
    pub seed: u64,
    /// Where document, seal and answer are kept
    #[arg(long, value_name = "FOLDER", default_value = "target/concealed")]
    pub folder: PathBuf,
    /// Where the stages' programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
}

/// The orbit: sealed, diagnosed, in words.
pub fn swarm(arguments: &Campaign) -> Result<String, Error> {
    flown(arguments.seed, &arguments.folder, &Programs::find(arguments.programs.as_deref())?)
}

/// The observatory: sealed, compared, diagnosed, in words.
pub fn pillar(arguments: &Campaign) -> Result<String, Error> {
    compared(arguments.seed, &arguments.folder, &Programs::find(arguments.programs.as_deref())?)
}

/// Real recordings: their page beside this one, and what stands here of it.
fn recorded(arguments: &Arguments, programs: Programs) -> Result<String, Error> {
    let mut words = String::from("## Recordings that somebody else made\n\n");
    if !arguments.data.is_dir() {
        words += &format!("Not run: no folder {} with recordings.\n", arguments.data.display());
        return Ok(words);
    }
    let recorded = real::recorded(&arguments.data, programs, None)?;
    let page = arguments.output.with_extension("").join("real.md");
    recorded.write(&page)?;
    words += "Fitted on one part, held against another that the fit never saw; with plots, and what each cannot decide, in [real.md](proof/real.md), which \
        `cargo run --release -p concealed -- real` makes of each set by its name.\n\n";
    Ok(words + &recorded.summary)
}

fn flown(seed: u64, folder: &Path, programs: &Programs) -> Result<String, Error> {
    let folder = Folder::at(&folder.join("swarm"))?;
    let flight = swarm::flight(seed);
    folder.seal(std::slice::from_ref(&flight.case))?;
    // A program that does not take a scalar magnetometer without coils refuses the document.
    let answer = match folder.diagnose(programs) {
        Ok(answers) => Some(seal::parsed(&answers.join(format!("{}.json", flight.case.truth.case)))?),
        Err(Error::Program { .. }) => None,
        Err(error) => return Err(error),
    };
    Ok(swarm::section(&flight, answer.as_ref()))
}

fn compared(seed: u64, folder: &Path, programs: &Programs) -> Result<String, Error> {
    let first = Folder::at(&folder.join("pillar"))?;
    let case = pillar::month(seed);
    first.seal(std::slice::from_ref(&case))?;
    let compared =
        first.answer("diffmag", &["--correct-clock"], programs)?.join(format!("{}.json", case.truth.case));
    let compared = seal::parsed(&compared)?;
    let second = Folder::at(&folder.join("pillar-compared"))?;
    let truth = case.truth.clone();
    second.seal(&[Case { document: compared.clone(), truth }])?;
    let answers = second.diagnose(programs)?;
    let sealed = &second.stored()?[&case.truth.case];
    let truth = second.open(&case.truth.case, sealed)?;
    let answer = seal::parsed(&answers.join(format!("{}.json", truth.case)))?;
    Ok(pillar::section(&truth, &compared, &answer))
}

/// The goals in a few lines, for people.
pub fn summary(score: &Score) -> String {
    let line = |goal: crate::score::Goal| {
        format!("  {}: {} (wanted: {}): {}\n", goal.what, goal.found.words(), goal.wanted(), goal.verdict())
    };
    let lines: String = score.goals().into_iter().map(line).collect();
    format!("concealed: {} cases\n{lines}", score.outcomes.len())
}
