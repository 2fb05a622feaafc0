//! `correct`: raw readings, a calibration and a model: the field.

use clap::Parser;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use common::{Document, Recording};
use correct::{Frame, Observatory, Request, Station};
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
    #[arg(long, value_name = "DOCUMENT", conflicts_with_all = ["magnitude_nt", "date", "field_model"])]
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
    #[command(flatten)]
    station: StationOptions,
    #[command(flatten)]
    magnitude: KnownMagnitude,
}

/// An observatory format in place of a table, in GEO.
#[derive(clap::Args)]
struct StationOptions {
    /// Write IAGA-2002 for this station (three or four letters), in GEO; with --place its header has the place
    #[arg(long, value_name = "CODE", group = "station", requires = "calibration", conflicts_with_all = ["to", "frame"])]
    iaga: Option<String>,
    /// The same as minute values for INTERMAGNET, IMFV1.22 (three letters)
    #[arg(long, value_name = "CODE", group = "station", requires = "calibration", conflicts_with_all = ["to", "frame"])]
    imf: Option<String>,
    /// The same as ImagCDF 1.2 (three or four letters)
    #[arg(long, value_name = "CODE", group = "station", requires = "calibration", conflicts_with_all = ["to", "frame"])]
    imagcdf: Option<String>,
    /// Write the adopted baselines of DOCUMENT as INTERMAGNET's yearly baseline file, IBFV2.00 (three letters)
    #[arg(long, value_name = "CODE", conflicts_with_all = ["station", "calibration", "frame", "place", "magnitude_nt"])]
    ibf: Option<String>,
    /// Time at which time_s is zero (RFC 3339), if the recording does not state it
    #[arg(long, value_name = "MOMENT", requires = "station")]
    start: Option<String>,
}

impl StationOptions {
    fn station(&self, place: Option<[f64; 3]>) -> Option<Station<'_>> {
        let named = [
            (Observatory::Iaga, &self.iaga),
            (Observatory::Imf, &self.imf),
            (Observatory::ImagCdf, &self.imagcdf),
        ];
        let (format, code) = named.into_iter().find_map(|(format, code)| Some((format, code.as_deref()?)))?;
        Some(Station { format, code, start: self.start.as_deref(), place })
    }
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
    let frame = if cli.station.station(None).is_some() { Frame::Geo } else { cli.frame };
    if let Some(calibration) = &cli.calibration {
        return table(cli, calibration, frame);
    }
    if let Some(code) = &cli.station.ibf {
        let (input, document) = Input::document(cli.io.file.as_deref(), with_calibration)?;
        let text = correct::ibf(document, code).map_err(|error| input.locate(error))?;
        return Ok(pipe::write(cli.io.output.as_deref(), &text)?);
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
    let place = cli.magnitude.at.place.map(|at| [at.latitude_deg, at.longitude_deg, at.height_m]);
    let station = cli.station.station(place);
    if place.is_some() && station.is_none() {
        let words = "--place beside --calibration is for the header of an observatory's file: give --iaga, --imf or --imagcdf too";
        return Err(common::Error::Request(words.into()).into());
    }
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
        station,
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
    if cli.map.is_none() {
        match content(&file).filter(|_| cli.from.is_none()) {
            Some(Content::Document) => return of_document(&file).map(Some),
            Some(Content::Iaga | Content::Cdf | Content::Iaf) => {}
            _ => return Ok(None),
        }
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

/// What a file's first bytes say.
fn content(file: &Path) -> Option<Content> {
    let mut head = Vec::new();
    File::open(file).and_then(|file| file.take(4096).read_to_end(&mut head)).ok()?;
    Content::of("", &head).ok()
}

/// The recording of a document with readings of sensors, such as the means that `series` takes.
fn of_document(file: &Path) -> anyhow::Result<Recording> {
    let (_, mut document) = Input::document(Some(file), with_calibration)?;
    document.recordings.retain(|recording| recording.columns.keys().any(|name| name.starts_with("sensor_")));
    let found = document.recordings.len();
    document.recordings.pop().filter(|_| found == 1).ok_or_else(|| {
        let expected = "one; a longer one stands in the file beside it, which is then the file of readings";
        let words = format!(
            "{}: found {found} recordings with readings of sensors; expected {expected}",
            file.display()
        );
        common::Error::Request(words).into()
    })
}
