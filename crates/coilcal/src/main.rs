//! `coilcal`: the coil facility itself.

use clap::Parser;
use coilcal::Options;
use program::manual;
use program::pipe::{self, Program, StageIo};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "coilcal", version: env!("CARGO_PKG_VERSION"), takes: &coilcal::PROCEDURES };

/// Find the constants and gradients of a facility's coils, with their uncertainty
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    simulate campaign fixtures/plans/magsat.json | coilcal > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the constants; 2 the request or the document is wrong."
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
    let run = |document| coilcal::run(document, options);
    Ok(pipe::stage(PROGRAM, stage, options.arguments(), run, coilcal::summary)?)
}
