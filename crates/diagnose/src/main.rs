//! `diagnose`: what physics the model left out.

use clap::Parser;
use common::Document;
use common::procedure;
use diagnose::Options;
use physics::Kind;
use program::pipe::{self, Input, Program, StageIo};
use program::{apart, manual, number, progress};
use std::path::PathBuf;
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "diagnose", version: env!("CARGO_PKG_VERSION"), takes: procedure::ALL };

/// Find what physics the model left out: where it shows, which effect explains it, the better model
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    diagnose fixtures/diagnose/warm/input.json > result.json\n\n\
    Exit codes: 0 done; 1 the recordings do not determine the answer; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    stage: StageIo,
    /// A simulation to compare the recordings with, instead of the prediction of calibration and model
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
    /// Write the refitted calibration even if no effect was found
    #[arg(long)]
    refit: bool,
    /// Adopt structure that no effect explains as the effect `empirical`: a smooth function of what it follows
    #[arg(long)]
    empirical: bool,
    /// Write the plan of the recording that would decide between the alternatives, for `simulate campaign`
    #[arg(long, value_name = "FILE")]
    plan: Option<PathBuf>,
    /// An effect to exclude, because it is known not to act; may be repeated (`simulate effects` lists them)
    #[arg(long, value_name = "EFFECT", value_parser = Kind::known)]
    without: Vec<Kind>,
    /// Seed of the random draws of the significance tests
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Probability of a false alarm
    #[arg(long, default_value_t = 0.01, value_parser = number::positive)]
    level: f64,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(&manual::parse::<Cli>()))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let mut arguments = vec![format!("--seed={}", cli.seed), format!("--level={}", cli.level)];
    let without = cli.without.clone();
    let mut options = Options {
        seed: cli.seed,
        level: cli.level,
        refit: cli.refit,
        against: None,
        without,
        empirical: cli.empirical,
    };
    arguments.extend(cli.without.iter().map(|kind| format!("--without={}", kind.name())));
    if cli.refit {
        arguments.push("--refit".into());
    }
    if cli.empirical {
        arguments.push("--empirical".into());
    }
    if let Some(path) = &cli.against {
        let input = Input::read(Some(path))?;
        options.against = Some(Document::parse(&input.text).map_err(|error| input.locate(error))?);
        arguments.push("--against".into());
    }
    apart::check(
        cli.plan.as_deref(),
        cli.stage.io.file.as_deref().into_iter().chain(cli.against.as_deref()),
    )?;
    apart::from_document("--plan", cli.plan.as_deref(), cli.stage.io.output.as_deref())?;
    let mut plan = None;
    pipe::stage(
        PROGRAM,
        &cli.stage,
        arguments,
        |document| {
            let found = diagnose::run_told(document, &options, &progress::tell);
            plan = found.as_ref().ok().and_then(diagnose::plan);
            found
        },
        diagnose::summary,
    )?;
    match (&cli.plan, plan) {
        (Some(path), Some(plan)) => pipe::write(Some(path), &plan)?,
        (Some(path), None) => pipe::say(&format!(
            "diagnose: no recording is known that would decide between the alternatives; {} was not written\n",
            path.display()
        )),
        _ => {}
    }
    Ok(())
}
