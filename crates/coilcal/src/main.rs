//! `coilcal`: the coil facility itself.

use clap::Parser;
use common::pipe::{self, Io, Program};
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "coilcal", version: env!("CARGO_PKG_VERSION") };

/// Constants of the coils, with their uncertainty
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    simulate campaign fixtures/plans/magsat.json | coilcal > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the constants; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    pipe::stage(PROGRAM, &cli.io, Vec::new(), coilcal::run, coilcal::summary)?;
    Ok(())
}
