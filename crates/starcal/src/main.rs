//! `starcal`: calibration in flight.

use clap::{Args, Parser, Subcommand, ValueEnum};
use common::{Document, Error};
use mainfield::Model;
use program::manual;
use program::pieces::{self, Answer};
use program::pipe::{self, Input, Program, StageIo};
use starcal::{Columns, Partial};
use std::path::PathBuf;
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "starcal", version: env!("CARGO_PKG_VERSION"), takes: &starcal::PROCEDURES };

/// Calibrate a vector magnetometer in flight, beside star cameras and in a model of the field
#[derive(Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Example:\n  \
    starcal fixtures/starcal/day/input.json > result.json\n\n\
    Exit codes: 0 done; 1 the flight does not determine the calibration; 2 the request or the document is wrong."
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
    /// Calibrate from a long flight in files, in one pass and bounded memory
    #[command(after_help = "Example:\n  \
        starcal stream --attitude-frame icrf fixtures/starcal/pieces/*.csv > result.json")]
    Stream(StreamArgs),
    /// Calibrate from statistics of parts of a flight, as `starcal stream --partial` writes them
    #[command(after_help = "Example:\n  \
        starcal stream --partial --attitude-frame icrf \\\n    fixtures/starcal/pieces/morning.csv > pieces.ndjson\n  \
        starcal stream --partial --attitude-frame icrf \\\n    fixtures/starcal/pieces/evening.csv >> pieces.ndjson\n  \
        starcal merge pieces.ndjson > result.json")]
    Merge(MergeArgs),
}

#[derive(Args)]
struct StreamArgs {
    #[command(flatten)]
    stream: pieces::Stream,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    known: Known,
}

#[derive(Args)]
struct MergeArgs {
    #[command(flatten)]
    merge: pieces::Merge,
    #[command(flatten)]
    known: Known,
}

#[derive(Args)]
struct Known {
    /// Document that states the sensors; the calibration is added to it, its recordings are not read
    #[arg(long, value_name = "DOCUMENT", conflicts_with = "partial")]
    document: Option<PathBuf>,
}

#[derive(Args)]
struct Options {
    /// From which frame the attitudes turn, where `conditions.attitude_frame` does not say it
    #[arg(long, value_enum, default_value = "geo")]
    attitude_frame: Frame,
    /// The field where there are no columns `ambient_*_nt`: igrf14 or wmm2025
    #[arg(long, value_parser = model, default_value = "igrf14")]
    field_model: Model,
    /// UT1 less UTC, s, for attitudes from icrf (IERS Bulletin A)
    #[arg(long, value_name = "S", value_parser = ut1, default_value = "0", allow_hyphen_values = true)]
    ut1_utc_s: f64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Frame {
    /// North, east and down at the place
    Geo,
    /// Fixed to the Earth
    Itrf,
    /// Celestial
    Icrf,
}

fn model(text: &str) -> Result<Model, String> {
    let known = Model::ALL.map(Model::name).join(" or ");
    Model::ALL.into_iter().find(|model| model.name() == text).ok_or(format!("expected {known}"))
}

fn ut1(text: &str) -> Result<f64, String> {
    let found = program::number::finite(text)?;
    if found.abs() <= 1.0 {
        Ok(found)
    } else {
        Err("expected seconds within ±1; is it in milliseconds?".into())
    }
}

impl Options {
    fn columns(&self) -> Columns {
        let frame = match self.attitude_frame {
            Frame::Geo => "geo",
            Frame::Itrf => "itrf",
            Frame::Icrf => "icrf",
        };
        Columns { frame: frame.into(), model: self.field_model, ut1_utc_s: self.ut1_utc_s }
    }

    fn arguments(&self) -> Vec<String> {
        let Columns { frame, model, ut1_utc_s } = self.columns();
        let mut said = Vec::new();
        if frame != "geo" {
            said.push(format!("--attitude-frame={frame}"));
        }
        if model != Model::default() {
            said.push(format!("--field-model={}", model.name()));
        }
        if ut1_utc_s != 0.0 {
            said.push(format!("--ut1-utc-s={ut1_utc_s}"));
        }
        said
    }
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    let result = match &cli.command {
        None => run(&cli),
        Some(Command::Stream(args)) => {
            let columns = args.options.columns();
            let run = |answer: &Answer<'_, Partial>| args.stream.run(&columns, answer);
            args.known.answered(args.options.arguments(), run).map_err(Into::into)
        }
        Some(Command::Merge(args)) => {
            args.known.answered(Vec::new(), |answer| args.merge.run(answer)).map_err(Into::into)
        }
    };
    pipe::finish(PROGRAM, result)
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let run = |document| starcal::run(document, &cli.options.columns());
    pipe::stage(PROGRAM, &cli.stage, cli.options.arguments(), run, starcal::summary)?;
    Ok(())
}

impl Known {
    /// Does what answers from statistics with the document that is known.
    fn answered(
        &self,
        arguments: Vec<String>,
        run: impl FnOnce(&Answer<'_, Partial>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let stated = self.document.as_deref();
        let stated = stated.map(|file| Input::document(Some(file), |file| format!("starcal stream {file}")));
        let stated = stated.transpose()?;
        let of = |joined: &Partial| {
            let (input, document) = match &stated {
                Some((input, document)) => (Some(input), document.clone()),
                None => (None, Document { fluxcal: common::FORMAT_VERSION, ..Document::default() }),
            };
            let document = starcal::answer(joined, document).map_err(|error| match input {
                Some(input) => input.locate(error),
                None => error,
            })?;
            Ok((document, input.map(Input::sha256)))
        };
        run(&Answer {
            program: PROGRAM,
            document: self.document.as_deref(),
            arguments,
            of: &of,
            words: &starcal::summary,
        })
    }
}
