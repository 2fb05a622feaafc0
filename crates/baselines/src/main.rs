//! `baselines`: the answer of another method, from the same dictionary.

use baselines::{Method, Options};
use clap::Parser;
use common::procedure;
use physics::Kind;
use program::pipe::{self, Io, Program, StageIo};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "baselines", version: env!("CARGO_PKG_VERSION"), takes: procedure::ALL };

/// What another method would answer in the place of diagnose: the same candidates, chosen by regression
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    baselines --method stepwise fixtures/diagnose/warm/input.json > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the answer; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
    /// How effects are chosen
    #[arg(long, value_enum)]
    method: Method,
    /// Seed of the half-samples and of the bags
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// An effect that is known not to act, and is not considered; several may be given
    #[arg(long, value_name = "EFFECT", value_parser = Kind::known)]
    without: Vec<Kind>,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&Cli::parse()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let mut arguments = vec![format!("--method={}", cli.method.name()), format!("--seed={}", cli.seed)];
    arguments.extend(cli.without.iter().map(|kind| format!("--without={}", kind.name())));
    let options = Options { method: cli.method, seed: cli.seed, without: cli.without.clone() };
    pipe::stage(
        PROGRAM,
        &StageIo::from(&cli.io),
        arguments,
        |document| baselines::run(document, &options),
        baselines::summary,
    )?;
    Ok(())
}
