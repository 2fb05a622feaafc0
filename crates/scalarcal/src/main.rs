//! `scalarcal`: calibration without a facility.

use clap::Parser;
use common::procedure;
use physics::Kind;
use program::manual;
use program::pipe::{self, Io, Program};
use scalarcal::Options;
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "scalarcal", version: env!("CARGO_PKG_VERSION"), takes: &[procedure::FREE_RUN] };

/// Sensitivities, offsets and angles of a vector magnetometer by the magnitude of the field, without a facility
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    scalarcal fixtures/scalarcal/meadow/input.json > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the calibration; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
    /// Use what calibration states of the sensors, within its uncertainty
    #[arg(long)]
    known: bool,
    /// Weigh rows that are far from the rest down
    #[arg(long)]
    robust: bool,
    /// The field's magnitude is constant and not known in recordings without a reference
    #[arg(long)]
    constant_magnitude: bool,
    /// Fit a constant error of the reference
    #[arg(long)]
    reference_offset: bool,
    /// Hold the readings against the known field (ambient_*_nt) turned by the attitude: the directions of the sensors in full
    #[arg(long)]
    vector: bool,
    /// Fit an effect of the catalogue too (offset_temperature, sensitivity_temperature, stray_current, …); may be repeated
    #[arg(long, value_name = "EFFECT", value_parser = Kind::known)]
    with: Vec<Kind>,
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    pipe::finish(PROGRAM, run(cli))
}

fn run(cli: Cli) -> anyhow::Result<()> {
    let options = Options {
        known: cli.known,
        robust: cli.robust,
        constant_magnitude: cli.constant_magnitude,
        reference_offset: cli.reference_offset,
        vector: cli.vector,
        with: cli.with,
    };
    pipe::stage(
        PROGRAM,
        &cli.io,
        options.arguments(),
        |document| scalarcal::run(document, &options),
        scalarcal::summary,
    )?;
    Ok(())
}
