//! `scalarcal`: calibration without a facility.

use clap::{Args, Parser, Subcommand};
use common::{Error, procedure};
use program::manual;
use program::pieces::{self, Answer, Stated};
use program::pipe::{self, Program, StageIo};
use scalarcal::stream::{self, Partial};
use scalarcal::{Columns, FitOptions, Options};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "scalarcal", version: env!("CARGO_PKG_VERSION"), takes: &[procedure::FREE_RUN] };

/// Calibrate a vector magnetometer by the magnitude of the field, without a facility
#[derive(Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Example:\n  \
    scalarcal fixtures/scalarcal/meadow/input.json > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the calibration; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    stage: StageIo,
    #[command(flatten)]
    options: Options,
}

#[derive(Subcommand)]
enum Command {
    /// Calibrate from long series in files, in one pass and bounded memory
    #[command(after_help = "Example:\n  \
        scalarcal stream --document fixtures/scalarcal/pieces/stated.json \\\n    fixtures/scalarcal/pieces/*.csv > result.json")]
    Stream(StreamArgs),
    /// Calibrate from statistics of pieces, as `scalarcal stream --partial` writes them
    #[command(after_help = "Example:\n  \
        scalarcal stream --partial fixtures/scalarcal/pieces/morning.csv > pieces.ndjson\n  \
        scalarcal stream --partial fixtures/scalarcal/pieces/evening.csv >> pieces.ndjson\n  \
        scalarcal merge --document fixtures/scalarcal/pieces/stated.json \\\n    pieces.ndjson > result.json")]
    Merge(MergeArgs),
}

#[derive(Args)]
struct StreamArgs {
    #[command(flatten)]
    stream: pieces::Stream,
    #[command(flatten)]
    known: KnownArgs,
}

#[derive(Args)]
struct MergeArgs {
    #[command(flatten)]
    merge: pieces::Merge,
    #[command(flatten)]
    known: KnownArgs,
}

#[derive(Args)]
struct KnownArgs {
    #[command(flatten)]
    stated: Stated,
    #[command(flatten)]
    fit: FitOptions,
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    let result = match &cli.command {
        None => run(&cli),
        Some(Command::Stream(args)) => {
            args.known.answered(|answer| args.stream.run(&Columns, answer)).map_err(Into::into)
        }
        Some(Command::Merge(args)) => {
            args.known.answered(|answer| args.merge.run(answer)).map_err(Into::into)
        }
    };
    pipe::finish(PROGRAM, result)
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let run = |document| scalarcal::run(document, &cli.options);
    pipe::stage(PROGRAM, &cli.stage, cli.options.arguments(), run, scalarcal::summary)?;
    Ok(())
}

impl KnownArgs {
    /// Does what answers from statistics with the document that is known.
    fn answered(&self, run: impl FnOnce(&Answer<'_, Partial>) -> Result<(), Error>) -> Result<(), Error> {
        let arguments = Options { fit: self.fit.clone(), ..Options::default() }.arguments();
        let answer = |joined: &Partial, document| stream::document(joined, document, &self.fit);
        self.stated.answered(PROGRAM, arguments, answer, &scalarcal::summary, run)
    }
}
