//! `recorded`: recordings that somebody else made, through the stages.

use clap::Parser;
use program::pipe::{self, Program};
use recorded::Arguments;
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "recorded", version: env!("CARGO_PKG_VERSION"), takes: &[] };

/// Recordings that somebody else made, through the stages: fitted on one part, held against another
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    recorded conrad-pair\n\n\
    Exit codes: 0 done, also where a stage refused; 2 the request is wrong, or a file or program is missing."
)]
struct Cli {
    #[command(flatten)]
    arguments: Arguments,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    Ok(recorded::run(&cli.arguments).map_err(common::Error::from)?)
}
