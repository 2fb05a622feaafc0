//! `ingest`: files of observatories and loggers into a document.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use common::{Document, Error as Fault};
use ingest::{Keep, Mapping, Options, Readings};
use program::pipe::{self, Input, Program};
use program::place::{self, KnownMagnitude};
use program::{apart, beside, manual, number};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const PROGRAM: Program = Program { name: "ingest", version: env!("CARGO_PKG_VERSION"), takes: &[] };

/// Vector readings that the document knows.
const QUANTITIES: [&str; 6] = ["sensor", "reference", "test", "third", "outside", "ambient"];

/// Read files of observatories and loggers into a document: IAGA-2002, IAF, CDF, CSV, NDJSON, Parquet
#[derive(Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    after_help = "Example:\n  \
    ingest guess fixtures/ingest/logger.csv > map.json\n  \
    ingest --map map.json fixtures/ingest/logger.csv > result.json\n\n\
    Exit codes: 0 done; 2 a file, the mapping or the request is wrong."
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    ingest: IngestArgs,
}

#[derive(Subcommand)]
enum Command {
    /// Write a mapping for a file of columns, to look at and edit
    #[command(after_help = "Example:\n  ingest guess fixtures/ingest/logger.csv > map.json")]
    Guess(GuessArgs),
}

#[derive(Args)]
struct GuessArgs {
    /// CSV, NDJSON or Parquet
    file: PathBuf,
    /// What vector readings are
    #[arg(long = "as", value_name = "QUANTITY", default_value = "sensor", value_parser = QUANTITIES)]
    quantity: String,
    /// Write to this file; absent or `-`: standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Say nothing on standard error
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Args)]
struct IngestArgs {
    /// Files of one series in any order, or sheets of absolute measurements; - is standard input
    files: Vec<PathBuf>,
    /// How files of columns are read; `ingest guess` writes one
    #[arg(long, value_name = "MAP")]
    map: Option<PathBuf>,
    /// Add the recording to this document; - is standard input
    #[arg(long, value_name = "DOCUMENT")]
    add: Option<PathBuf>,
    /// What vector readings are (with --map, the mapping states it)
    #[arg(long = "as", value_name = "QUANTITY", default_value = "sensor", value_parser = QUANTITIES, conflicts_with = "map")]
    quantity: String,
    /// The recording's id [default: of the station and day, or of the first file's name]
    #[arg(long)]
    id: Option<String>,
    /// The recording's procedure
    #[arg(long, default_value = common::procedure::FREE_RUN)]
    procedure: String,
    /// Write the readings beside the document, as Parquet unless PATH says otherwise (always done over 10 000 rows)
    #[arg(long, value_name = "PATH", num_args = 0..=1, require_equals = true)]
    beside: Option<Option<String>>,
    /// Keep the readings in the document, however many
    #[arg(long, conflicts_with = "beside")]
    inline: bool,
    /// Which file takes precedence where files disagree: the one that begins first or last
    #[arg(long, value_name = "FILE", value_parser = PossibleValuesParser::new(["first", "last"]).map(keep))]
    keep: Option<Keep>,
    /// Sort rows that are out of order within a file
    #[arg(long)]
    sort: bool,
    /// Trust titles and rows where the header of IAGA-2002 contradicts them
    #[arg(long)]
    trust_rows: bool,
    /// Add this to D of IAGA-2002, minutes of arc, instead of the DECBAS of the file
    #[arg(long, value_name = "ARCMIN", value_parser = number::finite)]
    declination_base_arcmin: Option<f64>,
    #[command(flatten)]
    magnitude: KnownMagnitude,
    /// Write the document to this file; absent or `-`: standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Let -o name the document of --add: it is replaced when all is done
    #[arg(long, requires_all = ["add", "output"])]
    in_place: bool,
    /// Say nothing on standard error
    #[arg(short, long)]
    quiet: bool,
}

fn keep(word: String) -> Keep {
    if word == "first" { Keep::First } else { Keep::Last }
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    let result = match &cli.command {
        Some(Command::Guess(args)) => guess(args),
        None => run(cli.ingest),
    };
    pipe::finish(PROGRAM, result)
}

fn guess(args: &GuessArgs) -> anyhow::Result<()> {
    apart::check(args.output.as_deref(), [args.file.as_path()])?;
    let guess = ingest::guess(&args.file, &args.quantity)?;
    pipe::write(args.output.as_deref(), &guess.to_text())?;
    if !args.quiet {
        pipe::say(&guess.words(&args.file));
    }
    Ok(())
}

fn run(args: IngestArgs) -> anyhow::Result<()> {
    if args.files.is_empty() {
        let message = "no file; name the files of one series, as in: ingest bou*.min > result.json. --help shows an example";
        return Err(Fault::Request(message.into()).into());
    }
    let (document, added) = match &args.add {
        Some(path) => {
            let files: Vec<String> = args.files.iter().map(|file| file.display().to_string()).collect();
            let files = files.join(" ");
            let command = |file: &str| format!("ingest {file} | ingest --add - {files}");
            let (input, document) = Input::document(Some(path), command)?;
            (document, Some(input.sha256()))
        }
        None => (Document { fluxcal: common::FORMAT_VERSION, ..Document::default() }, None),
    };
    let mapping = args.map.as_deref().map(mapping).transpose()?;
    let readings = match (&args.beside, args.inline) {
        (Some(path), _) => Readings::Beside(path.clone()),
        (None, true) => Readings::Inline,
        (None, false) => Readings::ByLength,
    };
    let arguments = arguments(&args);
    let options = Options {
        mapping,
        quantity: args.quantity,
        id: args.id,
        procedure: args.procedure,
        keep: args.keep,
        sort: args.sort,
        trust_rows: args.trust_rows,
        declination_base_arcmin: args.declination_base_arcmin,
        readings,
    };
    let known = document.recordings.len();
    let mut ingested = ingest::run(document, &args.files, &options)?;
    let new = ingested.document.recordings.iter().skip(known);
    let new: Vec<String> = new.map(|recording| recording.id.clone()).collect();
    // The columns of a table beside the document are not in the recording.
    let beside = ingested.table.iter().flat_map(|table| &table.columns).map(|(name, _)| name);
    let measured = ingested.table.is_some() && place::is_measured(beside, [].iter());
    args.magnitude.state(&mut ingested.document, |recording| new.contains(&recording.id) && !measured)?;
    ingested.document.history.push(PROGRAM.entry(arguments, added));
    let folder = args.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let table = ingested.table.as_ref().map(|table| folder.join(&table.path));
    let read = args.files.iter().chain(&args.map).chain(args.add.iter().filter(|_| !args.in_place));
    apart::check(args.output.as_deref().into_iter().chain(table.as_deref()), read.map(PathBuf::as_path))?;
    beside::write(args.output.as_deref(), &ingested.document.to_text()?, ingested.table.as_slice())?;
    if !args.quiet {
        pipe::say(&ingested.words);
    }
    Ok(())
}

fn mapping(path: &Path) -> Result<Mapping, Fault> {
    let input = Input::read(Some(path))?;
    Mapping::parse(&input.text).map_err(|error| input.locate(error))
}

/// What the history records: all that changes the answer, without names of files.
fn arguments(args: &IngestArgs) -> Vec<String> {
    let mut said = vec![format!("--as={}", args.quantity), format!("--procedure={}", args.procedure)];
    if args.map.is_some() {
        said = vec!["--map".into(), format!("--procedure={}", args.procedure)];
    }
    said.extend(args.id.as_ref().map(|id| format!("--id={id}")));
    said.extend(args.keep.map(|keep| match keep {
        Keep::First => "--keep=first".into(),
        Keep::Last => "--keep=last".into(),
    }));
    for (flag, name) in [
        (args.sort, "--sort"),
        (args.trust_rows, "--trust-rows"),
        (args.inline, "--inline"),
        (args.beside.is_some(), "--beside"),
    ] {
        if flag {
            said.push(name.into());
        }
    }
    said.extend(args.magnitude.arguments());
    said.extend(args.declination_base_arcmin.map(|base| format!("--declination-base-arcmin={base}")));
    said
}
