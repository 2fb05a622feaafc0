//! `diffmag`: two magnetometers side by side.

use clap::Parser;
use common::pipe::{self, Io, Program};
use diffmag::Options;
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "diffmag", version: env!("CARGO_PKG_VERSION") };

/// How two magnetometers are turned and scaled against each other, noise and drift of the one under test
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    simulate campaign fixtures/plans/observatory-pair.json | diffmag > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the answer; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let options = Options::default();
    pipe::stage(PROGRAM, &cli.io, Vec::new(), |document| diffmag::run(document, &options), diffmag::summary)?;
    Ok(())
}
