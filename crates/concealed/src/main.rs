//! `concealed`: conceals physics in recordings and counts who finds it.

use clap::{Parser, Subcommand};
use concealed::prove;
use concealed::seal::Folder;
use concealed::sets::Set;
use program::pipe::{self, Program};
use std::path::PathBuf;
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "concealed", version: env!("CARGO_PKG_VERSION"), takes: &[] };

/// Conceals physics in recordings, seals the truth, and counts what diagnose finds of it
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    concealed make --set single --cases 3 -o sealed > seals.txt\n\n\
    Exit codes: 0 done, whatever the score; 2 the request is wrong, a program failed, or a truth was changed after it was sealed."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Documents with something concealed, and the truth sealed beside them
    Make {
        /// What is concealed
        #[arg(long, value_enum)]
        set: Set,
        /// The seed of the set
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// How many; absent: a whole round of the set
        #[arg(long)]
        cases: Option<usize>,
        /// The folder to write to
        #[arg(short, long, value_name = "FOLDER")]
        output: PathBuf,
    },
    /// Several hundred cases, made, sealed, diagnosed, opened and scored, on one page
    Prove(concealed::prove::Arguments),
    /// Opens and scores the cases of a folder, and writes the page
    Score(concealed::prove::Arguments),
    /// Cases of some sets made, sealed, diagnosed and scored, a line each and no page
    Tally(concealed::tally::Arguments),
    /// A vector magnetometer beside a scalar one on an orbit, with a disturbance that follows the Sun
    Swarm(concealed::prove::Campaign),
    /// A month of an observatory's pair, with three things that nobody declared
    Pillar(concealed::prove::Campaign),
    /// Recordings that somebody else made, through the stages
    Real(concealed::real::Arguments),
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    told(&cli.command).map_err(common::Error::from)?;
    Ok(())
}

fn told(command: &Command) -> Result<(), concealed::Error> {
    match command {
        Command::Make { set, seed, cases, output } => {
            let folder = Folder::at(output)?;
            folder.seal(&set.cases(*seed, cases.unwrap_or(set.round())))?;
            let lines: Vec<String> =
                folder.stored()?.iter().map(|(case, seal)| format!("{seal}  {case}\n")).collect();
            pipe::write(None, &lines.concat())?;
        }
        Command::Prove(arguments) => pipe::say(&prove::summary(&prove::run(arguments)?)),
        Command::Score(arguments) => pipe::say(&prove::summary(&prove::score(arguments)?)),
        Command::Tally(arguments) => concealed::tally::run(arguments)?,
        Command::Swarm(arguments) => pipe::write(None, &prove::swarm(arguments)?)?,
        Command::Pillar(arguments) => pipe::write(None, &prove::pillar(arguments)?)?,
        Command::Real(arguments) => concealed::real::run(arguments)?,
    }
    Ok(())
}
