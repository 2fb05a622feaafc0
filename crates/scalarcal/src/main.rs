//! `scalarcal`: calibration without a facility.

use clap::{Args, Parser, Subcommand};
use common::{Document, HistoryEntry, procedure};
use physics::Kind;
use program::pipe::{self, Input, Io, Program};
use program::{apart, manual, number};
use rayon::prelude::*;
use scalarcal::Options;
use scalarcal::stream::{self, Partial};
use std::path::PathBuf;
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "scalarcal", version: env!("CARGO_PKG_VERSION"), takes: &[procedure::FREE_RUN] };

/// Sensitivities, offsets and angles of a vector magnetometer by the magnitude of the field, without a facility
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
    io: Io,
    #[command(flatten)]
    fit: FitArgs,
    /// Leave out rows that are far from the rest
    #[arg(long)]
    robust: bool,
    /// The field's magnitude is constant and not known in recordings without a reference
    #[arg(long)]
    constant_magnitude: bool,
    /// Hold the readings against the known field (ambient_*_nt) turned by the attitude: the directions of the sensors in full
    #[arg(long)]
    vector: bool,
    /// Fit an effect of the catalogue too (offset_temperature, sensitivity_temperature, stray_current, …); may be repeated
    #[arg(long, value_name = "EFFECT", value_parser = Kind::known)]
    with: Vec<Kind>,
}

#[derive(Subcommand)]
enum Command {
    /// Long series in files, in one pass and bounded memory
    #[command(after_help = "Example:\n  \
        scalarcal stream --document fixtures/scalarcal/pieces/stated.json \\\n    fixtures/scalarcal/pieces/*.csv > result.json")]
    Stream(PiecesArgs),
    /// Join statistics that `stream --partial` wrote
    #[command(after_help = "Example:\n  \
        scalarcal stream --partial fixtures/scalarcal/pieces/morning.csv -o morning.json\n  \
        scalarcal stream --partial fixtures/scalarcal/pieces/evening.csv -o evening.json\n  \
        scalarcal merge --document fixtures/scalarcal/pieces/stated.json \\\n    morning.json evening.json > result.json")]
    Merge(PiecesArgs),
}

#[derive(Args)]
struct FitArgs {
    /// Use what calibration states of the sensors, within its uncertainty
    #[arg(long)]
    known: bool,
    /// Fit a constant error of the reference
    #[arg(long)]
    reference_offset: bool,
    /// Tell the calibration in windows of this length, s, and whether it is the same in all
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = number::positive)]
    windows: Option<f64>,
}

#[derive(Args)]
struct PiecesArgs {
    /// Pieces in any order: .csv, .ndjson, .parquet (columns time_s, sensor_x_v, …, reference_nt), .json
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// What is known of instrument, reference and sensors; the calibration is put into this document, whose recordings are not read
    #[arg(long, value_name = "DOCUMENT", conflicts_with = "partial")]
    document: Option<PathBuf>,
    #[command(flatten)]
    fit: FitArgs,
    /// Write the statistics, to be merged with those of other pieces, in place of the calibration
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
        None => run(cli),
        Some(Command::Stream(pieces)) => join(pieces, "stream"),
        Some(Command::Merge(pieces)) => join(pieces, "merge"),
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
        &cli.io,
        options.arguments(),
        |document| scalarcal::run(document, &options),
        scalarcal::summary,
    )?;
    Ok(())
}

fn join(args: &PiecesArgs, command: &str) -> anyhow::Result<()> {
    let inputs = args.files.iter().chain(&args.document).map(PathBuf::as_path);
    apart::check(args.output.as_deref(), inputs)?;
    let stated = args
        .document
        .as_deref()
        .map(|file| Input::document(Some(file), |file| format!("scalarcal stream {file}")))
        .transpose()?;
    let pieces: Vec<Partial> = args
        .files
        .par_iter()
        .map(|file| scalarcal::take(file))
        .collect::<Result<_, _>>()
        .map_err(common::Error::from)?;
    let joined = stream::merge(pieces).map_err(common::Error::from)?;
    if args.partial {
        pipe::write(args.output.as_deref(), &joined.to_text())?;
        return Ok(());
    }
    let options = args.fit.options();
    let (input, document) = match stated {
        Some((input, document)) => (Some(input), document),
        None => (None, Document { fluxcal: common::FORMAT_VERSION, ..Document::default() }),
    };
    let mut document = stream::document(&joined, document, &options).map_err(|error| {
        let error = common::Error::from(error);
        match &input {
            Some(input) => input.locate(error),
            None => error,
        }
    })?;
    document.history.push(HistoryEntry {
        stage: PROGRAM.name.into(),
        version: PROGRAM.version.into(),
        arguments: [command.to_string()].into_iter().chain(options.arguments()).collect(),
        input_sha256: input.as_ref().map(Input::sha256),
        extra: Default::default(),
    });
    pipe::write(args.output.as_deref(), &document.to_text()?)?;
    if !args.quiet {
        pipe::say(&scalarcal::summary(&document));
    }
    Ok(())
}
