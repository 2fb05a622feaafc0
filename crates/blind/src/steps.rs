//! The steps of a proof, each a run of its own: make, answer, score.

use clap::Args;
use concealed::case::Case;
use concealed::sets::Set;
use std::path::PathBuf;
use testkit::programs::Programs;

use crate::Error;
use crate::campaigns::{self, Campaign};
use crate::folder::{Asked, Folder};
use crate::history;
use crate::hosted;
use crate::hosts;
use crate::methods;
use crate::page::{self, Besides};
use crate::score::Score;
use crate::seal;

/// What is asked of the making.
#[derive(Args, Clone, Debug)]
pub struct Make {
    /// What is concealed; several may be given; absent: the sets of a release
    #[arg(long, value_enum)]
    pub set: Vec<Set>,
    /// The seed of the sets; absent: a random number of the system, kept in the truths
    #[arg(long)]
    pub seed: Option<u64>,
    /// Rounds of every set; one has each kind at each strength once
    #[arg(long, default_value_t = 1)]
    pub rounds: usize,
    /// At most so many cases of a set, but of `removed`, which has every name of the catalogue once a round
    #[arg(long, value_name = "N")]
    pub cases: Option<usize>,
    /// The folder of real recordings, to conceal effects in those that show nothing; absent: none
    #[arg(long, value_name = "FOLDER")]
    pub recordings: Option<PathBuf>,
    /// At most so many effects a round in each real recording
    #[arg(long, value_name = "N", default_value_t = 12)]
    pub each: usize,
    /// Where the stages' programs are, which read real recordings and say whether they show nothing; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
    /// The folder of the documents and the seals
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// The file of the truths, to be kept away from whoever answers
    #[arg(long, value_name = "FILE")]
    pub truths: PathBuf,
}

/// What is asked of the answering.
#[derive(Args, Clone, Debug)]
pub struct Answer {
    /// The folder of the documents
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Where the stages' programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
}

/// What is asked of the scoring.
#[derive(Args, Clone, Debug)]
pub struct Scoring {
    /// The folder of the documents, seals and answers
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// The file of the truths
    #[arg(long, value_name = "FILE")]
    pub truths: PathBuf,
    /// Leave out the orbit and the observatory
    #[arg(long)]
    pub cases_only: bool,
    /// Where the stages' programs are, whose answers are scored; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
    /// The page to write, its pictures in a folder of its name
    #[arg(short, long, value_name = "FILE", default_value = "docs/proof.md")]
    pub output: PathBuf,
}

/// Makes cases and seals their truths. Gives the commitment.
pub fn make(asked: &Make) -> Result<String, Error> {
    let seed = match asked.seed {
        Some(seed) => seed,
        // As large as a number in JSON that every reader takes.
        None => getrandom::u32().map(u64::from).map_err(|error| {
            Error::Common(common::Error::Request(format!("the system gave no random number: {error}")))
        })?,
    };
    let sets: &[Set] = if asked.set.is_empty() { &Set::SCORE } else { &asked.set };
    let count = |set: Set| match (set, asked.cases) {
        // Every name is taken out, whatever else there is.
        (Set::Removed, _) | (_, None) => set.round() * asked.rounds,
        (_, Some(most)) => most.min(set.round() * asked.rounds),
    };
    let mut cases: Vec<Case> = sets.iter().flat_map(|set| set.cases(seed, count(*set))).collect();
    let folder = Folder::at(&asked.output)?;
    if let Some(recordings) = &asked.recordings {
        cases.extend(hosts::cases(&folder, recordings, asked, seed)?);
    }
    seal::seal(&folder, &cases, &asked.truths)?;
    seal::commitment(&folder)
}

/// Has diagnose answer every document, and the methods beside it. What ends with an error, or takes too long, stands as an answer without a diagnosis.
pub fn answer(asked: &Answer) -> Result<usize, Error> {
    let programs = Programs::find(asked.programs.as_deref())?;
    let folder = Folder::at(&asked.folder)?;
    let stored = seal::stored(&folder)?;
    folder.answer_all(&Asked::diagnose(&programs), stored.keys())?;
    methods::answer(&folder, &programs, stored.keys())?;
    Ok(stored.len())
}

/// Opens the truths, scores the answers of a build and writes the page.
pub fn score(asked: &Scoring) -> Result<Score, Error> {
    let programs = Programs::find(asked.programs.as_deref())?;
    let folder = Folder::at(&asked.folder)?;
    let diagnose = Asked::diagnose(&programs);
    let answers = folder.answers(diagnose.name, diagnose.arguments, &programs)?;
    let truths = seal::open(&folder, &asked.truths, &answers)?;
    let score = Score::of(truths, &answers, seal::commitment(&folder)?)?;
    let others = methods::scores(&folder, &programs, &asked.truths)?;
    let campaign = Campaign {
        seed: score.outcomes.first().map_or(0, |outcome| outcome.truth.seed),
        folder: asked.folder.clone(),
        programs: asked.programs.clone(),
    };
    let section =
        |of: fn(&Campaign) -> Result<String, Error>| (!asked.cases_only).then(|| of(&campaign)).transpose();
    let besides = Besides {
        methods: methods::section(&score, &others),
        orbit: section(campaigns::orbit)?,
        month: section(campaigns::month)?,
        real: page::real::of(&score, &hosts::tried(&folder)?, &answers)?,
    };
    let (text, pictures) = page::of(&score, &besides);
    let beside = asked.output.with_extension("");
    std::fs::create_dir_all(&beside).map_err(|source| Error::file(&beside, "written", source))?;
    for (name, svg) in pictures {
        program::pipe::write(Some(&beside.join(name)), &svg)?;
    }
    program::pipe::write(Some(&asked.output), &text)?;
    history::add(&beside.join("history.md"), &score)?;
    Ok(score)
}

/// The goals in a few lines, for people.
pub fn summary(score: &Score) -> String {
    let line = |goal: crate::score::Goal| {
        format!("  {}: {} (wanted: {}): {}\n", goal.what, goal.found.words(), goal.wanted(), goal.verdict())
    };
    let lines: String = score.goals().into_iter().chain(hosted::goals(score)).map(line).collect();
    format!("blind: {} cases\n{lines}", score.cases())
}
