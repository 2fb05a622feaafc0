//! `axescal`: directions of the sensors and of the coils, in arcseconds.

use axescal::{Coils, Options, Start, design};
use clap::{Parser, Subcommand, ValueEnum};
use common::{Axis, procedure};
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
    /// Take calibration.axes.coils as known, with its covariance or std_arcsec
    #[arg(long)]
    known_coils: bool,
    /// Where the iteration begins
    #[arg(long, value_enum, default_value_t = Start::Identity)]
    start: Start,
    /// Fit the scale factors of sensors and coils, and compare them with the calibration
    #[arg(long)]
    free_scales: bool,
    /// Down-weight outliers
    #[arg(long)]
    robust: bool,
    /// Use this sensor alone
    #[arg(long, value_enum)]
    sensor: Option<Letter>,
    /// Use the readings with this coil alone
    #[arg(long, value_enum)]
    coil: Option<Letter>,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Find the orientations of the block that determine the directions best
    Design(design::Arguments),
}

#[derive(Clone, Copy, ValueEnum)]
enum Letter {
    X,
    Y,
    Z,
}

impl Letter {
    fn axis(self) -> Axis {
        Axis::ALL[self as usize]
    }
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    pipe::finish(PROGRAM, run(cli))
}

fn run(cli: Cli) -> anyhow::Result<()> {
    if let Some(Command::Design(arguments)) = cli.command {
        return Ok(design::main(&arguments)?);
    }
    let options = Options {
        coils: if cli.known_coils { Coils::Known } else { Coils::Unknown },
        start: cli.start,
        free_scales: cli.free_scales,
        robust: cli.robust,
        sensor: cli.sensor.map(Letter::axis),
        coil: cli.coil.map(Letter::axis),
    };
    pipe::stage(
        PROGRAM,
        &cli.stage,
        options.arguments(),
        |document| axescal::run(document, &options),
        |document| axescal::summary(document, &options),
    )?;
    Ok(())
}
