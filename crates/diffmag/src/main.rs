//! `diffmag`: two magnetometers side by side.

use clap::{Args, Parser, Subcommand};
use common::procedure;
use diffmag::stream::{self, Partial};
use diffmag::{Columns, Options};
use program::pieces::{self, Answer};
use program::pipe::{self, Program, StageIo};
use program::{manual, number};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "diffmag", version: env!("CARGO_PKG_VERSION"), takes: &[procedure::DIFFERENTIAL] };

/// Compare two magnetometers side by side: how they are turned and scaled, noise, drift, clocks
#[derive(Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Example:\n  \
    diffmag fixtures/diffmag/turned-pair/input.json > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the answer; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    stage: StageIo,
    /// Correct the times of the test instrument for the clock difference, and fit again
    #[arg(long)]
    correct_clock: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Compare long series in files, in one pass and bounded memory
    Stream(StreamArgs),
    /// Compare from statistics of pieces, as `diffmag stream --partial` writes them
    #[command(after_help = "Example:\n  \
        diffmag stream --partial fixtures/diffmag/pieces/morning.csv > pieces.ndjson\n  \
        diffmag stream --partial fixtures/diffmag/pieces/evening.csv >> pieces.ndjson\n  \
        diffmag merge pieces.ndjson > result.json")]
    Merge(pieces::Merge),
}

#[derive(Args)]
#[command(after_help = "Example:\n  \
    diffmag stream fixtures/diffmag/pieces/*.csv > result.json")]
struct StreamArgs {
    #[command(flatten)]
    stream: pieces::Stream,
    /// Sampling interval, s [default: found from the first rows]
    #[arg(long, value_name = "SECONDS", value_parser = number::positive)]
    step_s: Option<f64>,
    /// The reference's columns are NAME_x_nt, NAME_y_nt, NAME_z_nt
    #[arg(long, value_name = "NAME", default_value = "reference")]
    reference: String,
    /// The test instrument's columns are NAME_x_nt, NAME_y_nt, NAME_z_nt: `field` for what `correct` wrote
    #[arg(long, value_name = "NAME", default_value = "test")]
    test: String,
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    let result = match &cli.command {
        None => run(&cli),
        Some(Command::Stream(args)) => stream(args),
        Some(Command::Merge(merge)) => merge.run(&answer(Vec::new())).map_err(Into::into),
    };
    pipe::finish(PROGRAM, result)
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let options = Options { correct_clock: cli.correct_clock };
    let arguments = if cli.correct_clock { vec!["--correct-clock".to_string()] } else { Vec::new() };
    pipe::stage(
        PROGRAM,
        &cli.stage,
        arguments,
        |document| diffmag::run(document, &options),
        diffmag::summary,
    )?;
    Ok(())
}

fn stream(args: &StreamArgs) -> anyhow::Result<()> {
    let columns = Columns { step_s: args.step_s, reference: args.reference.clone(), test: args.test.clone() };
    let named = |option: &str, name: &str| (name != option).then(|| format!("--{option}={name}"));
    let arguments = [
        args.step_s.map(|step_s| format!("--step-s={step_s}")),
        named("reference", &args.reference),
        named("test", &args.test),
    ];
    args.stream.run(&columns, &answer(arguments.into_iter().flatten().collect()))?;
    Ok(())
}

fn answer(arguments: Vec<String>) -> Answer<'static, Partial> {
    let of = &|joined: &Partial| Ok((stream::document(joined)?, None));
    Answer { program: PROGRAM, document: None, arguments, of, words: &diffmag::summary }
}
