//! `correct`: raw readings, a calibration and a model: the field.

use clap::Parser;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use common::{Document, Recording};
use correct::{Frame, Request, Station};
use ingest::{Mapping, Readings};
use program::pipe::{self, Input, Io, Program, StageIo};
use program::place::KnownMagnitude;
use program::{manual, progress};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tables::{Content, Format};

const PROGRAM: Program = Program { name: "correct", version: env!("CARGO_PKG_VERSION"), takes: &[] };

/// Turn raw readings into the field in nT, with the uncertainty of each sample
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    correct fixtures/correct/flight/input.json > result.json\n  \
    correct --calibration fixtures/correct/flight/input.json \\\n    fixtures/correct/flight/readings.csv -o field.parquet\n  \
    correct --calibration fixtures/correct/flight/input.json --iaga FLX --start 2026-05-26T00:00:00Z \\\n    fixtures/correct/flight/readings.csv -o field.min\n\n\
    Exit codes: 0 done; 1 the model cannot be inverted; 2 the request, the document or the table is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
    /// The frame of the field: that of the sensor block, or north, east, down
    #[arg(long, value_parser = PossibleValuesParser::new(["sen", "geo"]).map(frame), default_value = "sen")]
    frame: Frame,
    /// Correct a table with this document's calibration; DOCUMENT is then a file of readings: .csv, .ndjson or .parquet with the document's
    /// names of columns, IAGA-2002, CDF, or with --map whatever `ingest` reads
    #[arg(long, value_name = "DOCUMENT", conflicts_with_all = ["magnitude_nt", "place"])]
    calibration: Option<PathBuf>,
    /// The table was recorded under the conditions of this recording of the document
    #[arg(long, value_name = "ID", requires = "calibration")]
    recording: Option<String>,
    /// How the file of readings is read, as `ingest --map`; it is then held in memory
    #[arg(long, value_name = "MAP", requires = "calibration", conflicts_with = "from")]
    map: Option<PathBuf>,
    /// Format of the table, if its name does not show it
    #[arg(long, value_parser = PossibleValuesParser::new(FORMATS).map(format), requires = "calibration")]
    from: Option<Format>,
    /// Format to write, if the name of the output does not show it
    #[arg(long, value_parser = PossibleValuesParser::new(FORMATS).map(format), requires = "calibration")]
    to: Option<Format>,
    /// Write IAGA-2002 for this station (three or four letters), in GEO
    #[arg(long, value_name = "CODE", requires = "calibration", conflicts_with_all = ["to", "frame"])]
    iaga: Option<String>,
    /// Time at which time_s is zero (RFC 3339), if the recording does not state it
    #[arg(long, value_name = "MOMENT", requires = "iaga")]
    start: Option<String>,
    #[command(flatten)]
    magnitude: KnownMagnitude,
}

const FORMATS: [&str; 3] = ["csv", "ndjson", "parquet"];

fn format(name: String) -> Format {
    match name.as_str() {
        "csv" => Format::Csv,
        "ndjson" => Format::NdJson,
        _ => Format::Parquet,
    }
}

fn frame(name: String) -> Frame {
    if name == "geo" { Frame::Geo } else { Frame::Sen }
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    pipe::finish(PROGRAM, run(&cli))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let frame = if cli.iaga.is_some() { Frame::Geo } else { cli.frame };
    if let Some(calibration) = &cli.calibration {
        return table(cli, calibration, frame);
    }
    let frame_argument = (frame == Frame::Geo).then(|| "--frame=geo".to_string());
    let arguments = frame_argument.into_iter().chain(cli.magnitude.arguments()).collect();
    pipe::stage_or(
        PROGRAM,
        &StageIo::from(&cli.io),
        arguments,
        with_calibration,
        |mut document| {
            cli.magnitude.state(&mut document, |_| true)?;
            correct::run(document, frame)
        },
        |document| correct::summary(document, frame),
    )?;
    Ok(())
}

/// How a table is corrected, for one that is given in place of a document.
fn with_calibration(file: &str) -> String {
    format!("correct --calibration DOCUMENT {file}")
}

fn table(cli: &Cli, calibration: &Path, frame: Frame) -> anyhow::Result<()> {
    cli.io.apart([calibration].into_iter().chain(cli.map.as_deref()))?;
    let (text, document) = Input::document(Some(calibration), with_calibration)?;
    let readings = readings(cli)?;
    let request = Request {
        calibration: &document,
        readings: readings.as_ref(),
        recording: cli.recording.as_deref(),
        frame,
        input: pipe::named(cli.io.file.as_deref()),
        input_format: cli.from,
        output: pipe::named(cli.io.output.as_deref()),
        output_format: cli.to,
        iaga: cli.iaga.as_deref().map(|code| Station { code, start: cli.start.as_deref() }),
    };
    if request.output.is_none() {
        progress::give_way();
    }
    let tally = correct::correct_table(&request).map_err(|error| text.locate(error))?;
    if !cli.io.quiet {
        pipe::say(&correct::table_summary(&tally, &document, cli.recording.as_deref(), frame));
    }
    Ok(())
}

/// Readings of a file that only `ingest` reads: with a mapping, or in a format that is no table with the document's names.
fn readings(cli: &Cli) -> anyhow::Result<Option<Recording>> {
    let file = cli.io.file.clone().unwrap_or_else(|| "-".into());
    if cli.map.is_none() && (cli.from.is_some() || !says_itself(&file)) {
        return Ok(None);
    }
    let read = |map: &PathBuf| {
        let input = Input::read(Some(map))?;
        Mapping::parse(&input.text).map_err(|error| input.locate(error))
    };
    let mapping = cli.map.as_ref().map(read).transpose()?;
    let options = ingest::Options { mapping, readings: Readings::Inline, ..ingest::Options::default() };
    let document = Document { fluxcal: common::FORMAT_VERSION, ..Document::default() };
    let mut ingested = ingest::run(document, &[file], &options)?;
    if !cli.io.quiet {
        pipe::say(&ingested.words);
    }
    Ok(ingested.document.recordings.pop())
}

/// Whether a file is of a format that says what its columns are.
fn says_itself(file: &Path) -> bool {
    let mut head = Vec::new();
    let read = File::open(file).and_then(|file| file.take(4096).read_to_end(&mut head));
    read.is_ok() && matches!(Content::of("", &head), Ok(Content::Iaga | Content::Cdf | Content::Iaf))
}
