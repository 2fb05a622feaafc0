//! `scalarcal`: calibration without a facility.

use clap::{Args, Parser, Subcommand};
use common::{Document, Error, procedure};
use physics::Kind;
use program::pieces::{self, Answer};
use program::pipe::{self, Input, Program, StageIo};
use program::{manual, number};
use scalarcal::stream::{self, Partial};
use scalarcal::{Columns, Options};
use std::path::PathBuf;
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
    fit: FitArgs,
    /// Leave out rows that are outliers
    #[arg(long)]
    robust: bool,
    /// Fit one constant magnitude of the field in recordings without a reference
    #[arg(long)]
    constant_magnitude: bool,
    /// Compare the readings with the known field (ambient_*_nt) rotated by the attitude: determines the directions of the sensors fully
    #[arg(long)]
    vector: bool,
    /// Fit an effect of the catalogue too (offset_temperature, sensitivity_temperature, stray_current, …); may be repeated
    #[arg(long, value_name = "EFFECT", value_parser = Kind::known)]
    with: Vec<Kind>,
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
struct FitArgs {
    /// Use the stated calibration of the sensors as a prior, with its uncertainty
    #[arg(long)]
    known: bool,
    /// Fit a constant error of the reference
    #[arg(long)]
    reference_offset: bool,
    /// Calibrate in windows of this length, s, and test whether they agree
    #[arg(long, value_name = "SECONDS", value_parser = number::positive)]
    windows: Option<f64>,
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
    /// Document that states instrument, reference and sensors; the calibration is added to it, its recordings are not read
    #[arg(long, value_name = "DOCUMENT", conflicts_with = "partial")]
    document: Option<PathBuf>,
    #[command(flatten)]
    fit: FitArgs,
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    let result = match &cli.command {
        None => run(cli),
        Some(Command::Stream(args)) => {
            args.known.answered(|answer| args.stream.run(&Columns, answer)).map_err(Into::into)
        }
        Some(Command::Merge(args)) => {
            args.known.answered(|answer| args.merge.run(answer)).map_err(Into::into)
        }
    };
    pipe::finish(PROGRAM, result)
}

impl FitArgs {
    fn options(&self) -> Options {
        Options {
            known: self.known,
            reference_offset: self.reference_offset,
            windows_s: self.windows,
            ..Options::default()
        }
    }
}

fn run(cli: Cli) -> anyhow::Result<()> {
    let options = Options {
        robust: cli.robust,
        constant_magnitude: cli.constant_magnitude,
        vector: cli.vector,
        with: cli.with,
        ..cli.fit.options()
    };
    pipe::stage(
        PROGRAM,
        &cli.stage,
        options.arguments(),
        |document| scalarcal::run(document, &options),
        scalarcal::summary,
    )?;
    Ok(())
}

impl KnownArgs {
    /// Does what answers from statistics with the document that is known.
    fn answered(&self, run: impl FnOnce(&Answer<'_, Partial>) -> Result<(), Error>) -> Result<(), Error> {
        let stated = self.document.as_deref();
        let stated =
            stated.map(|file| Input::document(Some(file), |file| format!("scalarcal stream {file}")));
        let stated = stated.transpose()?;
        let options = self.fit.options();
        let of = |joined: &Partial| {
            let (input, document) = match &stated {
                Some((input, document)) => (Some(input), document.clone()),
                None => (None, Document { fluxcal: common::FORMAT_VERSION, ..Document::default() }),
            };
            let document = stream::document(joined, document, &options).map_err(|error| match input {
                Some(input) => input.locate(error),
                None => error,
            })?;
            Ok((document, input.map(Input::sha256)))
        };
        run(&Answer {
            program: PROGRAM,
            document: self.document.as_deref(),
            arguments: options.arguments(),
            of: &of,
            words: &scalarcal::summary,
        })
    }
}
