//! What is asked of each step on the command line.

use clap::Args;
use concealed::sets::Set;
use std::path::PathBuf;

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
