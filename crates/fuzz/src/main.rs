//! `fuzz`: every program on fixtures that were changed.

use clap::Parser;
use fuzz::{Error, NAMES, Programs, Session, Settings, Summary};
use program::pipe::{self, Program};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::Duration;

const PROGRAM: Program = Program { name: "fuzz", version: env!("CARGO_PKG_VERSION"), takes: &[] };

/// Processor time of a program, s: 20 s on two cores.
const PROCESSOR_S: u64 = 40;
/// How many findings that are alike are told.
const ALIKE: usize = 3;

/// Runs every program on fixtures that were changed, and fails where one breaks a rule
#[derive(Parser)]
#[command(
    version,
    after_help = "Rules: no panic, no signal, an end in 40 s of processor time and 4 GB, the exit codes 0, 1 and 2, words for every \
    failure and nothing written beside it, no number that is none, documents by their schema, and no program that refuses what \
    another wrote.\n\n\
    Example:\n  \
    fuzz --minutes 1 --seed 7 --keep findings\n\n\
    Exit codes: 0 nothing found; 1 findings; 2 the request is wrong or a program is not there."
)]
struct Cli {
    /// Have cargo build the programs first
    #[arg(long)]
    build: bool,
    /// How long, minutes
    #[arg(long, value_parser = program::number::positive, default_value_t = 10.0)]
    minutes: f64,
    /// Where all choices come from
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One case alone
    #[arg(long)]
    case: Option<u64>,
    /// The cases of one program alone
    #[arg(long, value_name = "PROGRAM", value_parser = NAMES)]
    only: Option<String>,
    /// Where the programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    programs: Option<PathBuf>,
    /// Keep the files of findings in this folder
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

fn main() -> ExitCode {
    pipe::finish(PROGRAM, run(Cli::parse()).map_err(anyhow::Error::from))
}

fn run(cli: Cli) -> Result<(), Error> {
    if cli.build {
        Programs::build()?;
    }
    let session = Session::new(Programs::find(cli.programs.as_deref())?)?;
    // More than a year is no budget.
    let time = Duration::from_secs_f64((cli.minutes * 60.0).min(3.2e7));
    let settings = Settings {
        seed: cli.seed,
        cases: cli.case.map_or(0..u64::MAX, |case| case..case.saturating_add(1)),
        time: Some(time),
        processor_s: PROCESSOR_S,
        only: cli.only,
        keep: cli.keep,
    };
    pipe::say(&format!("fuzz: seed {}", settings.seed));
    let alike: Mutex<BTreeMap<String, usize>> = Mutex::default();
    let summary = session.run(&settings, |finding| {
        let mut alike = alike.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let count = alike.entry(finding.likeness()).or_default();
        *count += 1;
        if *count <= ALIKE {
            pipe::say(&finding.text());
        }
    })?;
    pipe::say(&counts(&summary));
    if summary.findings.is_empty() {
        return Ok(());
    }
    let alike = alike.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    let lines: Vec<String> =
        alike.iter().map(|(likeness, count)| format!("  {count} × {likeness}")).collect();
    let (found, kinds) = (summary.findings.len(), alike.len());
    Err(Error::Unanswerable(format!("{found} findings of {kinds} kinds\n{}", lines.join("\n"))))
}

/// What was run, as words.
fn counts(summary: &Summary) -> String {
    let mut text = format!("fuzz: {} cases, {} runs", summary.cases, summary.runs.values().sum::<u64>());
    for name in NAMES {
        let own = summary.runs.iter().filter(|((program, _), _)| program == name);
        let ends: Vec<String> = own.map(|((_, end), count)| format!("{count} {end}")).collect();
        text += &format!("\n  {name}: {}", ends.join(", "));
    }
    text
}
