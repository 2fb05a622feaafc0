//! `simulate`: from a plan to the recordings that a campaign would give.

use clap::{Args, Parser, Subcommand};
use common::number::counted;
use common::time::Start;
use common::{Document, Error, HistoryEntry, Recording};
use program::beside::{self, INLINE_ROWS, Table};
use program::pipe::{self, Input, Io, Program, Sink, StageIo};
use program::place::AtPlace;
use program::{apart, manual, progress};
use rayon::prelude::*;
use simulate::{
    Campaign, Case, FlightPlan, Layout, MadeFlight, Observatory, ObservatoryPlan, Replayed, RunSheet,
    Variation,
};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "simulate", version: env!("CARGO_PKG_VERSION"), takes: &[] };

/// Simulate the recordings of a campaign from a plan
#[derive(Parser)]
#[command(
    version,
    after_help = "Examples:\n  \
        simulate campaign fixtures/plans/magsat-axes.json --truth truth.json | axescal > result.json\n  \
        simulate campaign fixtures/plans/magsat.json --run-sheet > settings.csv\n  \
        simulate replay result.json > predicted.json\n  \
        simulate sweep fixtures/plans/magsat-axes.json --seeds 1..100 > campaigns.ndjson\n  \
        simulate effects coil_heating"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Carry out every procedure of a plan and write the document
    Campaign(CampaignArgs),
    /// Make the absolute measurements and the variometer of an observatory
    Observatory(ObservatoryArgs),
    /// Make the readings of a magnetometer beside star cameras in orbit
    Flight(FlightArgs),
    /// Replace the readings of a document by the predictions of its calibration and model
    Replay(ReplayArgs),
    /// Carry out a plan for many seeds or values, one document a line
    Sweep(SweepArgs),
    /// Print the catalogue of effects
    #[command(after_help = "Example:\n  simulate effects coil_heating")]
    Effects {
        /// One effect; absent: all
        effect: Option<String>,
        /// How it is laid out
        #[arg(long, value_enum, default_value_t)]
        layout: Layout,
    },
}

#[derive(Args)]
#[command(
    after_help = "Example:\n  simulate campaign fixtures/plans/magsat-axes.json | axescal > result.json"
)]
struct CampaignArgs {
    #[command(flatten)]
    io: Io,
    /// Seed of all noise, instead of the plan's
    #[arg(long)]
    seed: Option<u64>,
    /// Write the true values to this file
    #[arg(long, value_name = "FILE", conflicts_with = "run_sheet")]
    truth: Option<PathBuf>,
    /// Write the sequence of settings as CSV instead of the document
    #[arg(long)]
    run_sheet: bool,
    /// Write recordings of more than 10 000 rows beside the document, as Parquet
    #[arg(long, conflicts_with = "run_sheet")]
    beside: bool,
    #[command(flatten)]
    at: AtPlace,
}

#[derive(Args)]
#[command(
    after_help = "Example:\n  simulate observatory fixtures/plans/observatory.json | absolute > result.json"
)]
struct ObservatoryArgs {
    #[command(flatten)]
    io: Io,
    /// Seed of all that is drawn, instead of the plan's
    #[arg(long)]
    seed: Option<u64>,
    /// Write the true baseline values to this file: Unix times, s, and the values in nT and rad
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    #[command(flatten)]
    at: AtPlace,
}

#[derive(Args)]
#[command(
    after_help = "Example:\n  simulate flight fixtures/plans/flight.json --truth truth.json > flight.json"
)]
struct FlightArgs {
    #[command(flatten)]
    io: Io,
    /// Seed of all that is drawn, instead of the plan's
    #[arg(long)]
    seed: Option<u64>,
    /// Write the true values to this file
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

#[derive(Args)]
#[command(after_help = "Example:\n  simulate replay result.json > predicted.json")]
struct ReplayArgs {
    #[command(flatten)]
    io: Io,
    /// Add the declared noise and quantise
    #[arg(long)]
    noise: bool,
    /// Seed of that noise
    #[arg(long, default_value_t = 0, requires = "noise")]
    seed: u64,
}

#[derive(Args)]
#[command(
    after_help = "Example:\n  simulate sweep fixtures/plans/magsat-axes.json --seeds 1..20 \\\n    --set facility.theodolite_arcsec=1,2 --truth truth.ndjson > campaigns.ndjson"
)]
struct SweepArgs {
    #[command(flatten)]
    io: Io,
    /// Seeds: `1..100` (both ends count) or `1,5,9`; absent: the plan's
    #[arg(long, value_parser = seeds)]
    seeds: Option<Seeds>,
    /// A value of the plan in several versions: PATH=VALUE,VALUE,…; give it again for every combination
    #[arg(long, value_name = "PATH=VALUES", value_parser = variation)]
    set: Vec<Variation>,
    /// Write the true values to this file, one line for each document
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

#[derive(Clone)]
struct Seeds(Vec<u64>);

fn seeds(text: &str) -> Result<Seeds, String> {
    let number = |part: &str| part.trim().parse::<u64>().map_err(|_| format!("\"{part}\" is no seed"));
    match text.split_once("..") {
        Some((from, to)) => {
            let (from, to) = (number(from)?, number(to)?);
            if to < from || to - from >= 10_000_000 {
                return Err("expected a range that grows, of at most ten million seeds".into());
            }
            Ok(Seeds((from..=to).collect()))
        }
        None => text.split(',').map(number).collect::<Result<_, _>>().map(Seeds),
    }
}

fn variation(text: &str) -> Result<Variation, String> {
    let (path, values) = text.split_once('=').ok_or("expected PATH=VALUE,VALUE,…")?;
    let list = serde_json::from_str(&format!("[{values}]"));
    let list: Vec<serde_json::Value> =
        list.map_err(|_| format!("\"{values}\" are no JSON values; put text into double quotes"))?;
    if list.is_empty() {
        return Err("expected at least one value after =".into());
    }
    Ok(Variation { path: path.trim().into(), values: list })
}

fn main() -> ExitCode {
    let result = match manual::parse::<Cli>().command {
        Command::Campaign(args) => campaign(&args),
        Command::Observatory(args) => observatory(&args),
        Command::Flight(args) => flight(&args),
        Command::Replay(args) => replay(&args),
        Command::Sweep(args) => sweep(&args),
        Command::Effects { effect, layout } => simulate::catalogue(effect.as_deref(), layout)
            .and_then(|text| pipe::write(None, &text))
            .map_err(Into::into),
    };
    pipe::finish(PROGRAM, result)
}

fn campaign(args: &CampaignArgs) -> anyhow::Result<()> {
    let CampaignArgs { io, seed, truth, run_sheet, beside, at } = args;
    let (input, mut plan) = read(io, truth.as_deref(), simulate::Plan::parse)?;
    let located = |error: Error| input.locate(error);
    plan.seed = seed.unwrap_or(plan.seed);
    let start = plan.start.as_deref().and_then(Start::parse);
    if let Some((field_nt, _)) = at.field_nt(start, "start").map_err(located)? {
        plan.truth.outside.get_or_insert_default().main_field_nt = field_nt;
    }
    if *run_sheet {
        let RunSheet { csv, steps, length_s, work_s } = simulate::run_sheet(&plan).map_err(located)?;
        pipe::write(io.output.as_deref(), &csv)?;
        let [work, length] = [work_s, length_s].map(duration);
        say(io, &format!("{}, {work} of work in {length}", counted(steps, "setting")));
        return Ok(());
    }
    let Campaign { mut document, truth: what_is_true } = simulate::campaign(&plan).map_err(located)?;
    document.history.push(entry("campaign", plan.seed, at.arguments(), input.sha256()));
    let recordings = counted(document.recordings.len(), "recording");
    let words = format!("{recordings}, {}, seed {}", rows(&document), plan.seed);
    write(io, document, *beside, truth.as_deref(), &common::to_text(what_is_true.finite()?), &words)
}

fn observatory(args: &ObservatoryArgs) -> anyhow::Result<()> {
    let ObservatoryArgs { io, seed, truth, at } = args;
    let (input, mut plan) = read(io, truth.as_deref(), ObservatoryPlan::parse)?;
    let located = |error: Error| input.locate(error);
    plan.seed = seed.unwrap_or(plan.seed);
    if let Some((field_nt, _)) = at.field_nt(Start::parse(&plan.start), "start").map_err(located)? {
        plan.main_field_nt = field_nt;
    }
    let Observatory { mut document, truth: what_is_true } = simulate::observatory(&plan).map_err(located)?;
    document.history.push(entry("observatory", plan.seed, at.arguments(), input.sha256()));
    let (time_s, baseline): (Vec<f64>, Vec<[f64; 3]>) = what_is_true.into_iter().unzip();
    let what_is_true =
        serde_json::json!({"components": plan.components, "unix_s": time_s, "baseline": baseline});
    let sets = counted(document.recordings.len() - 1, "measurement");
    let words = format!("{sets} in {}, seed {}", counted(plan.weeks, "week"), plan.seed);
    write(io, document, false, truth.as_deref(), &common::to_text(&what_is_true), &words)
}

fn flight(args: &FlightArgs) -> anyhow::Result<()> {
    let FlightArgs { io, seed, truth } = args;
    let (input, mut plan) = read(io, truth.as_deref(), FlightPlan::parse)?;
    plan.seed = seed.unwrap_or(plan.seed);
    let made = simulate::flight(&plan).map_err(|error| input.locate(error))?;
    let MadeFlight { mut document, truth: what_is_true } = made;
    document.history.push(entry("flight", plan.seed, [], input.sha256()));
    let cameras = counted(plan.cameras.len(), "star camera");
    let words = format!("{}, {cameras}, seed {}", rows(&document), plan.seed);
    let to_file = pipe::named(io.output.as_deref()).is_some();
    write(io, document, to_file, truth.as_deref(), &common::to_text(&what_is_true), &words)
}

fn replay(args: &ReplayArgs) -> anyhow::Result<()> {
    let ReplayArgs { io, noise, seed } = args;
    let seed = noise.then_some(*seed);
    let arguments = ["replay".to_string()]
        .into_iter()
        .chain(seed.iter().flat_map(|seed| ["--noise".into(), format!("--seed={seed}")]));
    let mut notes = Vec::new();
    let run = |document: Document| {
        let Replayed { document, notes: said } = simulate::replay(&document, seed)?;
        notes = said;
        Ok(document)
    };
    let words = |document: &Document| {
        format!("simulate: {} predicted", counted(document.recordings.len(), "recording"))
    };
    pipe::stage(PROGRAM, &StageIo::from(io), arguments.collect(), run, words)?;
    notes.iter().for_each(|note| say(io, note));
    Ok(())
}

fn sweep(args: &SweepArgs) -> anyhow::Result<()> {
    let SweepArgs { io, seeds, set, truth } = args;
    separate(io, truth.as_deref())?;
    let input = Input::read(io.file.as_deref())?;
    let located = |error: Error| input.locate(error);
    let seeds = seeds.as_ref().map(|seeds| seeds.0.as_slice()).unwrap_or_default();
    let cases = simulate::cases(seeds, set);
    // What the values set is looked at before the first line is written; the seed cannot be wrong.
    for case in simulate::cases(&[], set) {
        simulate::run_sheet(&simulate::plan_of(&input.text, &case).map_err(located)?).map_err(located)?;
    }
    let mut documents = Sink::open(io.output.as_deref())?;
    let mut truths = truth.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let truth_wanted = truths.is_some();
    progress::steps(cases.len());
    let sha256 = input.sha256();
    let one = |case: &Case| -> Result<(String, String), Error> {
        let plan = simulate::plan_of(&input.text, case)?;
        let Campaign { mut document, truth } = simulate::campaign(&plan)?;
        // No number of the case: what is made by parts, on several machines, is then what is made at once.
        let set = case.set.iter().map(|(path, value)| format!("--set={path}={value}"));
        document.history.push(entry("sweep", plan.seed, set, sha256.clone()));
        let truth = if truth_wanted { common::to_line(truth.finite()?) + "\n" } else { String::new() };
        Ok((document.to_line()? + "\n", truth))
    };
    let mut written = 0;
    // As many at a time as there are threads: the memory does not grow with the number of cases.
    let at_once = rayon::current_num_threads();
    'all: for batch in cases.chunks(at_once) {
        let made: Vec<_> = batch.par_iter().map(one).collect();
        for made in made {
            let (document, truth) = made.map_err(located)?;
            if let Some(truths) = &mut truths {
                truths.write(&truth)?;
            }
            if !documents.write(&document)? {
                break 'all;
            }
            written += 1;
            progress::step();
        }
    }
    if let Some(truths) = truths {
        truths.finish()?;
    }
    documents.finish()?;
    say(io, &counted(written, "document"));
    Ok(())
}

/// Reads a plan.
fn read<P>(io: &Io, truth: Option<&Path>, parse: fn(&str) -> Result<P, Error>) -> Result<(Input, P), Error> {
    separate(io, truth)?;
    let input = Input::read(io.file.as_deref())?;
    let plan = parse(&input.text).map_err(|error| input.locate(error))?;
    Ok((input, plan))
}

fn entry(name: &str, seed: u64, more: impl IntoIterator<Item = String>, sha256: String) -> HistoryEntry {
    let arguments = [name.into(), format!("--seed={seed}")].into_iter().chain(more).collect();
    PROGRAM.entry(arguments, Some(sha256))
}

fn rows(document: &Document) -> String {
    counted(document.recordings.iter().map(Recording::rows).sum(), "row")
}

/// Writes a document and the truth, its long recordings as tables beside it where that is wanted.
fn write(
    io: &Io,
    mut document: Document,
    beside: bool,
    truth: Option<&Path>,
    truth_text: &str,
    words: &str,
) -> anyhow::Result<()> {
    let long = document.recordings.iter_mut().filter(|one| beside && one.rows() > INLINE_ROWS);
    let tables: Vec<Table> = long.map(|one| Table::of(one, beside::file_name(&one.id))).collect();
    // What is refused is refused before a file is written.
    let text = document.to_text()?;
    if let Some(path) = truth {
        pipe::write(Some(path), truth_text)?;
    }
    beside::write(io.output.as_deref(), &text, &tables)?;
    say(io, words);
    Ok(())
}

/// What is written is not what is read, and the truth never goes into the document.
fn separate(io: &Io, truth: Option<&Path>) -> Result<(), Error> {
    io.apart([])?;
    apart::check(truth, io.file.as_deref())?;
    apart::from_document("--truth", truth, io.output.as_deref())
}

fn say(io: &Io, words: &str) {
    if !io.quiet {
        pipe::say(&format!("{}: {words}", PROGRAM.name));
    }
}

/// Seconds as days, hours and minutes.
fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    let (days, hours, minutes) = (minutes / 1440, minutes / 60 % 24, minutes % 60);
    match (days, hours) {
        (0, 0) => format!("{minutes} min"),
        (0, _) => format!("{hours} h {minutes} min"),
        _ => format!("{days} d {hours} h {minutes} min"),
    }
}
