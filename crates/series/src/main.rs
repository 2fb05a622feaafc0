//! `series`: recordings cut, averaged, resampled, joined, and their columns renamed.

use clap::{Args, Parser, Subcommand};
use common::procedure;
use program::beside::{self, INLINE_ROWS, Table};
use program::pipe::{self, Input, Io, Program};
use program::{apart, manual, number};
use series::{Average, Bound, Cut, Join, Operation};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "series", version: env!("CARGO_PKG_VERSION"), takes: procedure::ALL };

/// Cut, average, resample and join recordings, and rename their columns
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    ingest fixtures/ingest/flx20240310[ab].min | series average --window 300 > result.json\n\n\
    Exit codes: 0 done; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Keep rows from one time up to another
    #[command(after_help = "Example:\n  \
        ingest fixtures/ingest/lemi.sec | series cut --from 5 --to 15 > result.json")]
    Cut {
        #[command(flatten)]
        io: Io,
        /// The recording; absent: all with readings
        #[arg(long, value_name = "ID")]
        recording: Vec<String>,
        /// Earliest time: RFC 3339, or seconds of time_s
        #[arg(long, value_name = "TIME", allow_hyphen_values = true, value_parser = bound)]
        from: Option<Bound>,
        /// Rows before this time
        #[arg(long, value_name = "TIME", allow_hyphen_values = true, required_unless_present = "from", value_parser = bound)]
        to: Option<Bound>,
    },
    /// Take means over windows that begin at whole multiples of their length in UTC, and count samples
    #[command(
        after_help = "Example:\n  ingest fixtures/ingest/lemi.sec | series average --window 10 > result.json"
    )]
    Average {
        #[command(flatten)]
        io: Io,
        /// The recording; absent: all with readings
        #[arg(long, value_name = "ID")]
        recording: Vec<String>,
        /// The length of a window, s
        #[arg(long, value_name = "S", value_parser = number::positive)]
        window: f64,
        /// Minimum share of the samples of a full window, 0 to 1; means of fewer are missing
        #[arg(long, value_name = "SHARE", default_value_t = 0.5, value_parser = share)]
        share: f64,
    },
    /// Resample to whole multiples of a step in UTC, with a low-pass filter against aliasing
    #[command(
        after_help = "Example:\n  ingest fixtures/ingest/logger.csv | series resample --step 60 > result.json"
    )]
    Resample {
        #[command(flatten)]
        io: Io,
        /// The recording; absent: all with readings
        #[arg(long, value_name = "ID")]
        recording: Vec<String>,
        /// The step, s
        #[arg(long, value_name = "S", value_parser = number::positive)]
        step: f64,
    },
    /// Give columns other names; sensor=test renames all that begin with sensor_
    #[command(
        after_help = "Example:\n  ingest fixtures/ingest/lemi.sec | series rename sensor=test > result.json"
    )]
    Rename {
        /// OLD=NEW, several times
        #[arg(required = true, value_name = "OLD=NEW", value_parser = pair)]
        names: Vec<(String, String)>,
        #[command(flatten)]
        io: NamedIo,
        /// The recording; absent: all with readings
        #[arg(long, value_name = "ID")]
        recording: Vec<String>,
    },
    /// Join recordings into one: the columns of the others at the times of the first, clocks as they are
    #[command(after_help = "Example:\n  \
        ingest --as reference --id hut fixtures/ingest/field.ndjson > hut.json\n  \
        ingest --as test --id field --add hut.json fixtures/ingest/field.csv \\\n    \
        | series join hut field --procedure differential > result.json")]
    Join {
        /// Ids of the recordings; the times are those of the first
        #[arg(required = true, value_name = "ID")]
        ids: Vec<String>,
        #[command(flatten)]
        io: NamedIo,
        /// The id of what they become [default: that of the first]
        #[arg(long)]
        id: Option<String>,
        /// Its procedure [default: that of the first]
        #[arg(long)]
        procedure: Option<String>,
    },
}

/// As [`Io`], where the plain arguments are something else.
#[derive(Args)]
struct NamedIo {
    /// The document to read; absent or `-`: standard input
    #[arg(long = "document", value_name = "DOCUMENT")]
    file: Option<PathBuf>,
    /// Write to this file; absent or `-`: standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Let -o name the document that is read: it is replaced when all is done
    #[arg(long, requires = "output")]
    in_place: bool,
    /// Say nothing on standard error
    #[arg(short, long)]
    quiet: bool,
}

impl From<NamedIo> for Io {
    fn from(io: NamedIo) -> Self {
        Io { file: io.file, output: io.output, in_place: io.in_place, quiet: io.quiet }
    }
}

fn bound(text: &str) -> Result<Bound, String> {
    Bound::parse(text)
        .ok_or_else(|| "expected a moment such as 2025-03-14T12:00:00Z, or seconds of time_s".into())
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|share: &f64| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected a number from 0 to 1".into())
}

fn pair(text: &str) -> Result<(String, String), String> {
    let good = |name: &str| {
        !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
    };
    let found = text.split_once('=').filter(|(old, new)| good(old) && good(new));
    let (old, new) = found.ok_or("expected OLD=NEW, as in sensor=test")?;
    Ok((old.into(), new.into()))
}

fn main() -> ExitCode {
    let (io, recordings, operation) = match manual::parse::<Cli>().command {
        Command::Cut { io, recording, from, to } => (io, recording, Operation::Cut(Cut { from, to })),
        Command::Average { io, recording, window, share } => {
            (io, recording, Operation::Average(Average { window_s: window, share }))
        }
        Command::Resample { io, recording, step } => (io, recording, Operation::Resample(step)),
        Command::Rename { names, io, recording } => (io.into(), recording, Operation::Rename(names)),
        Command::Join { ids, io, id, procedure } => {
            (io.into(), Vec::new(), Operation::Join(Join { ids, id, procedure }))
        }
    };
    pipe::finish(PROGRAM, run(&io, &recordings, &operation))
}

fn run(io: &Io, recordings: &[String], operation: &Operation) -> anyhow::Result<()> {
    let name = name(operation);
    let command = |file: &str| format!("ingest {file} | series {name} …");
    let (input, mut document) = Input::document(io.file.as_deref(), command)?;
    let tables = document.recordings.iter().filter_map(|recording| recording.table.as_ref());
    let read: Vec<PathBuf> = tables.map(|table| io.folder().join(table)).collect();
    io.apart(read.iter().map(PathBuf::as_path))?;
    beside::read(&mut document, io.folder(), PROGRAM.takes).map_err(|error| input.locate(error))?;
    let outcome = series::run(document, recordings, operation).map_err(|error| input.locate(error))?;
    let mut document = outcome.document;
    let mut tables = Vec::new();
    for index in outcome.changed {
        let recording = &mut document.recordings[index];
        recording.table = None;
        if recording.rows() > INLINE_ROWS {
            let path = beside::file_name(&format!("{}-{name}", recording.id));
            tables.push(Table::of(recording, path));
        }
    }
    beside::put_back(&mut document);
    let folder = io.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let written: Vec<PathBuf> = tables.iter().map(|table| folder.join(&table.path)).collect();
    apart::check(written.iter().map(PathBuf::as_path), read.iter().map(PathBuf::as_path))?;
    document.history.push(PROGRAM.entry(arguments(recordings, operation), Some(input.sha256())));
    beside::write(io.output.as_deref(), &document.to_text()?, &tables)?;
    if !io.quiet {
        let beside = tables.iter().map(|table| format!("  readings beside the document: {}", table.path));
        let lines: Vec<String> =
            outcome.words.into_iter().map(|words| format!("  {words}")).chain(beside).collect();
        pipe::say(&format!("series {name}:\n{}", lines.join("\n")));
    }
    Ok(())
}

fn name(operation: &Operation) -> &'static str {
    match operation {
        Operation::Cut(_) => "cut",
        Operation::Average(_) => "average",
        Operation::Resample(_) => "resample",
        Operation::Rename(_) => "rename",
        Operation::Join(_) => "join",
    }
}

/// What the history records of the request.
fn arguments(recordings: &[String], operation: &Operation) -> Vec<String> {
    let mut said = vec![name(operation).to_string()];
    match operation {
        Operation::Cut(cut) => {
            let bound = |bound: Bound| match bound {
                Bound::Moment(moment) => moment.text().unwrap_or_default(),
                Bound::Seconds(seconds) => seconds.to_string(),
            };
            said.extend(cut.from.map(|from| format!("--from={}", bound(from))));
            said.extend(cut.to.map(|to| format!("--to={}", bound(to))));
        }
        Operation::Average(average) => {
            said.extend([format!("--window={}", average.window_s), format!("--share={}", average.share)]);
        }
        Operation::Resample(step_s) => said.push(format!("--step={step_s}")),
        Operation::Rename(names) => said.extend(names.iter().map(|(old, new)| format!("{old}={new}"))),
        Operation::Join(join) => {
            said.extend(join.ids.iter().cloned());
            said.extend(join.id.as_ref().map(|id| format!("--id={id}")));
            said.extend(join.procedure.as_ref().map(|procedure| format!("--procedure={procedure}")));
        }
    }
    said.extend(recordings.iter().map(|id| format!("--recording={id}")));
    said
}
