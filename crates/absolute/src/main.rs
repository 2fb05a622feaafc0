//! `absolute`: absolute measurements of an observatory.

use clap::Parser;
use program::manual;
use program::pipe::{self, Program, StageIo};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "absolute", version: env!("CARGO_PKG_VERSION"), takes: &absolute::PROCEDURES };

/// Find declination, inclination and the baselines of a variometer by a theodolite with a magnetometer
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    absolute fixtures/absolute/weeks/input.json > result.json\n\n\
    Exit codes: 0 done; 1 the readings do not determine the field; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    stage: StageIo,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&manual::parse::<Cli>()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    pipe::stage(PROGRAM, &cli.stage, Vec::new(), absolute::run, absolute::summary)?;
    Ok(())
}
