//! `concealed`: conceals physics in recordings and counts who finds it.

use clap::{Parser, Subcommand};
use common::pipe::{self, Program};
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "concealed", version: env!("CARGO_PKG_VERSION") };

/// Conceals physics in recordings, seals the truth, and counts what diagnose finds of it
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Recordings that somebody else made, through the stages
    Real(concealed::real::Arguments),
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    match &cli.command {
        Command::Real(arguments) => concealed::real::run(arguments).map_err(common::Error::from)?,
    }
    Ok(())
}
