//! `coilcal`: the coil facility itself.

use clap::Parser;
use coilcal::Options;
use program::pipe::{self, Program, StageIo};
use program::{manual, number};
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
    /// Distance from a coil's centre at which the field error is stated, m
    #[arg(long, value_name = "M", default_value_t = 0.05, value_parser = number::not_negative)]
    off_centre_m: f64,
    /// Nyquist frequency of the instrument that will measure in the coils, Hz
    #[arg(long, value_name = "HZ", default_value_t = 50.0, value_parser = number::positive)]
    nyquist_hz: f64,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&manual::parse::<Cli>()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let options = Options { off_centre_m: cli.off_centre_m, nyquist_hz: cli.nyquist_hz };
    let arguments =
        vec![format!("--off-centre-m={}", cli.off_centre_m), format!("--nyquist-hz={}", cli.nyquist_hz)];
    pipe::stage(
        PROGRAM,
        &cli.stage,
        arguments,
        |document| coilcal::run(document, &options),
        coilcal::summary,
    )?;
    Ok(())
}
