//! `blind`: conceals physics in recordings and counts who finds it.

use blind::{Answer, Campaign, Make, Scoring, Tally};
use clap::{Parser, Subcommand};
use program::pipe::{self, Program};
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "blind", version: env!("CARGO_PKG_VERSION"), takes: &[] };

/// Conceals physics in recordings, seals the truth, and counts what diagnose finds of it
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    blind make --set single --cases 3 -o sealed --truths truths.json > commitment.txt\n\n\
    Exit codes: 0 done, whatever the score; 2 the request is wrong, a program failed, a truth was changed after it was sealed, or answers came \
    after the truths were opened."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Makes documents with something concealed and seals the truths; the commitment goes to standard output
    Make(Make),
    /// Has diagnose answer the documents of a folder, and other methods beside it
    Answer(Answer),
    /// Opens the truths, scores the answers, and writes the page
    Score(Scoring),
    /// Cases of some sets made, diagnosed and scored at once, a line each and no page: for development
    Tally(Tally),
    /// A vector magnetometer beside a scalar one on an orbit, with a disturbance that follows the Sun
    Orbit(Campaign),
    /// A month of an observatory's pair, with three things that nobody declared
    Month(Campaign),
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    told(&cli.command).map_err(common::Error::from)?;
    Ok(())
}

fn told(command: &Command) -> Result<(), blind::Error> {
    match command {
        Command::Make(asked) => pipe::write(None, &(blind::make(asked)? + "\n"))?,
        Command::Answer(asked) => pipe::say(&format!("blind: {} cases answered\n", blind::answer(asked)?)),
        Command::Score(asked) => pipe::say(&blind::summary(&blind::score(asked)?)),
        Command::Tally(asked) => blind::tally(asked)?,
        Command::Orbit(asked) => pipe::write(None, &blind::orbit(asked)?)?,
        Command::Month(asked) => pipe::write(None, &blind::month(asked)?)?,
    }
    Ok(())
}
