//! `starcal`: calibration in flight.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use common::{AttitudeFrame, Error};
use mainfield::Model;
use program::manual;
use program::pieces::{self, Answer, Stated};
use program::pipe::{self, Program, StageIo};
use starcal::{Columns, Partial};
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
    stated: Stated,
}

#[derive(Args)]
struct MergeArgs {
    #[command(flatten)]
    merge: pieces::Merge,
    #[command(flatten)]
    stated: Stated,
}

#[derive(Args)]
struct Options {
    /// From which frame the attitudes turn, where `conditions.attitude_frame` does not say it
    #[arg(long, default_value = "geo", value_parser = PossibleValuesParser::new(AttitudeFrame::ALL.map(AttitudeFrame::name)).map(frame))]
    attitude_frame: AttitudeFrame,
    /// The field where there are no columns `ambient_*_nt`: igrf14 or wmm2025
    #[arg(long, default_value = "igrf14", value_parser = PossibleValuesParser::new(Model::ALL.map(Model::name)).map(model))]
    field_model: Model,
    /// UT1 less UTC, s, for attitudes from icrf (IERS Bulletin A)
    #[arg(long, value_name = "S", value_parser = ut1, default_value = "0", allow_hyphen_values = true)]
    ut1_utc_s: f64,
}

fn model(text: String) -> Model {
    Model::ALL.into_iter().find(|model| model.name() == text).unwrap_or_default()
}

fn frame(text: String) -> AttitudeFrame {
    AttitudeFrame::named(&text).unwrap_or_default()
}

fn ut1(text: &str) -> Result<f64, String> {
    let found = program::number::finite(text)?;
    Some(found)
        .filter(|found| found.abs() <= 1.0)
        .ok_or("expected seconds within ±1; is it in milliseconds?".into())
}

impl Options {
    fn columns(&self) -> Columns {
        Columns { frame: self.attitude_frame, model: self.field_model, ut1_utc_s: self.ut1_utc_s }
    }

    fn arguments(&self) -> Vec<String> {
        let Columns { frame, model, ut1_utc_s } = self.columns();
        let mut said = Vec::new();
        if frame != AttitudeFrame::Geo {
            said.push(format!("--attitude-frame={}", frame.name()));
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
            answered(&args.stated, args.options.arguments(), |answer| args.stream.run(&columns, answer))
        }
        Some(Command::Merge(args)) => answered(&args.stated, Vec::new(), |answer| args.merge.run(answer)),
    };
    pipe::finish(PROGRAM, result)
}

fn answered(
    stated: &Stated,
    arguments: Vec<String>,
    run: impl FnOnce(&Answer<'_, Partial>) -> Result<(), Error>,
) -> anyhow::Result<()> {
    Ok(stated.answered(PROGRAM, arguments, starcal::answer, &starcal::summary, run)?)
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let run = |document| starcal::run(document, &cli.options.columns());
    pipe::stage(PROGRAM, &cli.stage, cli.options.arguments(), run, starcal::summary)?;
    Ok(())
}
