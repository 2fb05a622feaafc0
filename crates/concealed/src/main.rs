//! `concealed`: conceals physics in recordings and counts who finds it.

use clap::{Parser, Subcommand};
use common::pipe::{self, Program};
use concealed::seal::Folder;
use concealed::sets::Set;
use std::path::PathBuf;
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "concealed", version: env!("CARGO_PKG_VERSION") };

/// Conceals physics in recordings, seals the truth, and counts what diagnose finds of it
#[derive(Parser)]
#[command(version)]
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
    /// Recordings that somebody else made, through the stages
    Real(concealed::real::Arguments),
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    match &cli.command {
        Command::Make { set, seed, cases, output } => {
            let folder = Folder::at(output).map_err(common::Error::from)?;
            let made = set.cases(*seed, cases.unwrap_or(set.round()));
            folder.seal(&made).map_err(common::Error::from)?;
            for (case, seal) in folder.stored().map_err(common::Error::from)? {
                println!("{seal}  {case}");
            }
        }
        Command::Prove(arguments) => {
            let score = concealed::prove::run(arguments).map_err(common::Error::from)?;
            pipe::say(&concealed::prove::summary(&score));
        }
        Command::Real(arguments) => concealed::real::run(arguments).map_err(common::Error::from)?,
    }
    Ok(())
}
