//! `simulate`: from a plan to the recordings that a campaign would give.

use clap::{Parser, Subcommand};
use common::pipe::{self, Input, Io, Program};
use common::{HistoryEntry, to_text};
use std::path::PathBuf;
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "simulate", version: env!("CARGO_PKG_VERSION") };

/// From a plan to the recordings that a campaign would give
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  simulate campaign fixtures/plans/magsat-axes.json | axescal > result.json"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Carry out every procedure of a plan and write the document
    Campaign {
        #[command(flatten)]
        io: Io,
        /// Seed of all noise, instead of the plan's
        #[arg(long)]
        seed: Option<u64>,
        /// Write what is true to this file
        #[arg(long, value_name = "FILE")]
        truth: Option<PathBuf>,
    },
}

fn main() -> ExitCode {
    let Command::Campaign { io, seed, truth } = Cli::parse().command;
    pipe::finish(PROGRAM, campaign(&io, seed, truth))
}

fn campaign(io: &Io, seed: Option<u64>, truth: Option<PathBuf>) -> anyhow::Result<()> {
    let input = Input::read(io.file.as_deref())?;
    let mut plan: simulate::Plan = common::parse(&input.text).map_err(|error| input.locate(error))?;
    plan.seed = seed.unwrap_or(plan.seed);
    let simulate::Campaign { mut document, truth: what_is_true } =
        simulate::campaign(&plan).map_err(|error| input.locate(error.into()))?;
    document.history.push(HistoryEntry {
        stage: PROGRAM.name.into(),
        version: PROGRAM.version.into(),
        arguments: vec!["campaign".into(), format!("--seed={}", plan.seed)],
        input_sha256: Some(input.sha256()),
        extra: Default::default(),
    });
    if truth.is_some() && truth == io.output {
        anyhow::bail!(common::Error::Request(
            "--truth and --output name the same file; the truth never goes into the document".into()
        ));
    }
    if let Some(path) = truth {
        pipe::write(Some(&path), &to_text(&what_is_true))?;
    }
    pipe::write(io.output.as_deref(), &to_text(&document))?;
    if !io.quiet {
        let rows: usize = document.recordings.iter().map(common::Recording::rows).sum();
        pipe::say(&format!(
            "simulate: {} recordings, {rows} rows, seed {}",
            document.recordings.len(),
            plan.seed
        ));
    }
    Ok(())
}
