//! `diagnose`: what physics the model left out.

use clap::Parser;
use common::pipe::{self, Io, Program};
use diagnose::Options;
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "diagnose", version: env!("CARGO_PKG_VERSION") };

/// What physics the model left out: where recording and prediction differ, the effect that explains it, the better model
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    simulate campaign fixtures/plans/cubesat.json | coilcal | sensorcal | axescal | diagnose > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the answer; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
    /// Seed of the draws by which chance is judged
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Probability of a claim where there is nothing
    #[arg(long, default_value_t = 0.01)]
    level: f64,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let options = Options { seed: cli.seed, level: cli.level };
    let arguments = vec![format!("--seed={}", cli.seed), format!("--level={}", cli.level)];
    pipe::stage(PROGRAM, &cli.io, arguments, |document| diagnose::run(document, &options), diagnose::summary)?;
    Ok(())
}
