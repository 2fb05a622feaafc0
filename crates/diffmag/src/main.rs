//! `diffmag`: two magnetometers side by side.

use clap::{Args, Parser, Subcommand};
use common::procedure;
use common::{Document, HistoryEntry};
use diffmag::Options;
use diffmag::stream::{self, Partial};
use program::pipe::{self, Io, Program};
use program::{apart, manual, number};
use rayon::prelude::*;
use std::path::PathBuf;
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "diffmag", version: env!("CARGO_PKG_VERSION"), takes: &[procedure::DIFFERENTIAL] };

/// How two magnetometers are turned and scaled against each other, noise and drift of the one under test
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
    io: Io,
    /// Correct the times of the test instrument by what its clock differs, and fit again
    #[arg(long)]
    correct_clock: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Long series in files, in one pass and bounded memory
    Stream(StreamArgs),
    /// Join statistics that `stream --partial` wrote
    #[command(after_help = "Example:\n  \
        diffmag stream --partial fixtures/diffmag/pieces/morning.csv -o morning.json\n  \
        diffmag stream --partial fixtures/diffmag/pieces/evening.csv -o evening.json\n  \
        diffmag merge morning.json evening.json > result.json")]
    Merge(PiecesArgs),
}

#[derive(Args)]
#[command(after_help = "Example:\n  \
    diffmag stream fixtures/diffmag/pieces/*.csv > result.json")]
struct StreamArgs {
    #[command(flatten)]
    pieces: PiecesArgs,
    /// From one sample to the next, s; found from the first rows where it is not told
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = number::positive)]
    step_s: Option<f64>,
}

#[derive(Args)]
struct PiecesArgs {
    /// Pieces in any order: .csv, .ndjson, .parquet (columns time_s, reference_x_nt, …, test_z_nt), .json
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Write the statistics, to be merged with those of other pieces, in place of the answer
    #[arg(long)]
    partial: bool,
    /// Write to this file; absent: standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Say nothing on standard error
    #[arg(short, long)]
    quiet: bool,
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    let result = match &cli.command {
        None => run(&cli),
        Some(Command::Stream(StreamArgs { pieces, step_s })) => join(pieces, "stream", *step_s),
        Some(Command::Merge(pieces)) => join(pieces, "merge", None),
    };
    pipe::finish(PROGRAM, result)
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let options = Options { correct_clock: cli.correct_clock };
    let arguments = if cli.correct_clock { vec!["--correct-clock".to_string()] } else { Vec::new() };
    pipe::stage(PROGRAM, &cli.io, arguments, |document| diffmag::run(document, &options), diffmag::summary)?;
    Ok(())
}

fn join(args: &PiecesArgs, command: &str, step_s: Option<f64>) -> anyhow::Result<()> {
    apart::check(args.output.as_deref(), args.files.iter().map(PathBuf::as_path))?;
    let pieces: Vec<Partial> = args
        .files
        .par_iter()
        .map(|file| diffmag::take(file, step_s))
        .collect::<Result<_, _>>()
        .map_err(common::Error::from)?;
    let joined = stream::merge(pieces).map_err(common::Error::from)?;
    if args.partial {
        pipe::write(args.output.as_deref(), &joined.to_text())?;
        return Ok(());
    }
    let mut document: Document = stream::document(&joined).map_err(common::Error::from)?;
    let step = step_s.map(|step_s| format!("--step-s={step_s}"));
    document.history.push(HistoryEntry {
        stage: PROGRAM.name.into(),
        version: PROGRAM.version.into(),
        arguments: [command.to_string()].into_iter().chain(step).collect(),
        input_sha256: None,
        extra: Default::default(),
    });
    pipe::write(args.output.as_deref(), &document.to_text()?)?;
    if !args.quiet {
        pipe::say(&diffmag::summary(&document));
    }
    Ok(())
}
