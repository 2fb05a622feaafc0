//! `sensorcal`: each sensor by itself.

use clap::Parser;
use program::manual;
use program::pipe::{self, Program, StageIo};
use sensorcal::Options;
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "sensorcal", version: env!("CARGO_PKG_VERSION"), takes: &sensorcal::PROCEDURES };

/// Find sensitivity, offset, noise, drift and coefficients of each sensor, with their uncertainty
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    simulate campaign fixtures/plans/magsat.json | coilcal | sensorcal > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the answer; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    stage: StageIo,
    #[command(flatten)]
    options: Options,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&manual::parse::<Cli>()))
}

fn run(Cli { stage, options }: &Cli) -> anyhow::Result<()> {
    let run = |document| sensorcal::run(document, options);
    Ok(pipe::stage(PROGRAM, stage, options.arguments(), run, sensorcal::summary)?)
}
