//! `report`: any document as one page.

use clap::{Parser, ValueEnum};
use common::{Error, procedure};

use program::pipe::{self, Input, Io, Program, Sink};
use program::{apart, beside, manual};
use report::certificate::{self, Asked};
use report::conformity::Spec;
use report::{Options, html, text};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const PROGRAM: Program =
    Program { name: "report", version: env!("CARGO_PKG_VERSION"), takes: procedure::ALL };

/// One page that shows what each stage found: words, tables, plots, and the data of each plot
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    report fixtures/diagnose/warm/expected.json -o report.html\n  \
    report --text fixtures/diagnose/warm/expected.json\n  \
    report --text --spec fixtures/specs/magsat.json fixtures/specs/calibrated/input.json\n  \
    report --certificate certificate.html fixtures/specs/calibrated/input.json\n\n\
    The page is HTML that needs no network. No clock is in it: the same document gives the same bytes.\n\
    Exit codes: 0 done, whatever the page says; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
    /// Plain text, for the terminal, instead of HTML
    #[arg(long)]
    text: bool,
    /// Check the document against this specification and state conformity; the exit code is 0 whatever its verdicts
    #[arg(long, value_name = "FILE")]
    spec: Option<PathBuf>,
    /// Write a calibration certificate (ISO/IEC 17025:2017, 7.8.2 and 7.8.4) to this file; the page is then written where -o names a file
    #[arg(long, value_name = "FILE")]
    certificate: Option<PathBuf>,
    /// Administrative data of the certificate, as under the document's `certificate`, which they are put over
    #[arg(long, value_name = "FILE", requires = "certificate")]
    certificate_data: Option<PathBuf>,
    /// Paper that the certificate is laid out for; without it the printer's
    #[arg(long, value_enum, requires = "certificate")]
    paper: Option<Paper>,
}

/// A size of paper.
#[derive(Clone, Copy, ValueEnum)]
enum Paper {
    /// 210 mm × 297 mm
    A4,
    /// 8.5 in × 11 in
    Letter,
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    pipe::finish(PROGRAM, run(&cli))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let beside_it = [cli.spec.as_deref(), cli.certificate_data.as_deref()];
    cli.io.apart(beside_it.into_iter().flatten())?;
    // The certificate never replaces what is read, nor is it the page.
    let read = [cli.io.file.as_deref(), cli.io.output.as_deref()].into_iter().chain(beside_it).flatten();
    apart::check(cli.certificate.as_deref(), read.collect::<Vec<_>>())?;
    if cli.certificate.is_some() && cli.certificate == cli.io.output {
        let words =
            "-o and --certificate name one file; the page and the certificate are two, name two files";
        return Err(Error::Request(words.into()).into());
    }
    let mut options = Options::default();
    let mut spec_sha256 = None;
    if let Some(file) = &cli.spec {
        let input = Input::read(Some(file))?;
        options.spec = Some(Spec::parse(&input.text).map_err(|error| input.locate(error))?);
        spec_sha256 = Some(input.sha256());
    }
    let (input, mut document) = Input::document(cli.io.file.as_deref(), |file| PROGRAM.ingest(file))?;
    options.document_sha256 = Some(input.sha256());
    let file = cli.io.file.as_deref().and_then(|file| pipe::named(Some(file)));
    options.name = file.and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
    if let Err(error) = beside::read(&mut document, cli.io.folder(), PROGRAM.takes) {
        pipe::say(&format!("report: {}; the page does without", input.locate(error)));
    }
    let page = report::run(&document, &options).map_err(|error| input.locate(error))?;
    let (mut words, mut written) = (Vec::new(), Vec::new());
    if let Some(file) = &cli.certificate {
        let data = cli.certificate_data.as_deref().map(|file| Input::read(Some(file))).transpose()?;
        if let Some(data) = &data {
            let stated = document.certificate.take().unwrap_or_default();
            let merged = stated.overlaid(&data.text).map_err(|error| data.locate(error))?;
            document.certificate = Some(Box::new(merged));
        }
        let data_sha256 = data.map(|data| data.sha256());
        let findings = report::findings(&document).map_err(|error| input.locate(error))?;
        let asked = Asked {
            findings: &findings,
            document_sha256: options.document_sha256.as_deref(),
            data_sha256: data_sha256.as_deref(),
            spec: options.spec.as_ref().map(|spec| (spec, spec_sha256.as_deref())),
        };
        let sheet = certificate::run(&document, &asked).map_err(|error| input.locate(error))?;
        let paper = cli.paper.map(|paper| if matches!(paper, Paper::A4) { "A4" } else { "letter" });
        written.push((Some(file.as_path()), certificate::render(&sheet, paper)?));
        words.push(certificate::summary(&sheet));
    }
    if cli.certificate.is_none() || cli.io.output.is_some() {
        let text = if cli.text { text::render(&page) } else { html::render(&page)? };
        written.push((cli.io.output.as_deref(), text));
        words.insert(0, report::summary(&page));
    }
    // Both files get their names when both are whole.
    let mut sinks = Vec::new();
    for (file, text) in &written {
        let mut sink = Sink::open(*file)?;
        sink.write(text)?;
        sinks.push(sink);
    }
    sinks.into_iter().try_for_each(Sink::finish)?;
    if !cli.io.quiet {
        pipe::say(&words.join("\n"));
    }
    Ok(())
}
