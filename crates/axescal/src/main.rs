//! `axescal`: directions of the sensors and of the coils, in arcseconds.

use axescal::{Options, design};
use clap::{Parser, Subcommand};
use common::procedure;
use program::manual;
use program::pipe::{self, Program, StageIo};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "axescal", version: env!("CARGO_PKG_VERSION"), takes: &[procedure::AXES_ORIENTATION] };

/// Find the directions of the sensors and of the coils, in arcseconds, with their uncertainty
#[derive(Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Example:\n  \
    axescal fixtures/nasa-1977/table-4.json > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the directions; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    stage: StageIo,
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Find the orientations of the block that determine the directions best
    Design(design::Arguments),
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    pipe::finish(PROGRAM, run(cli))
}

fn run(cli: Cli) -> anyhow::Result<()> {
    if let Some(Command::Design(arguments)) = cli.command {
        return Ok(design::main(&arguments)?);
    }
    let options = cli.options;
    pipe::stage(
        PROGRAM,
        &cli.stage,
        options.arguments(),
        |document| axescal::run(document, &options),
        |document| axescal::summary(document, &options),
    )?;
    Ok(())
}
