//! `report`: any document as one page.

use clap::Parser;
use common::procedure;
use program::pipe::{self, Input, Io, Program};
use program::{beside, manual};
use report::certificate::Spec;
use report::{Options, html, text};
use std::path::PathBuf;
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
    report --text --spec fixtures/specs/magsat.json fixtures/specs/calibrated/input.json\n\n\
    The page is HTML that needs no network. No clock is in it: the same document gives the same bytes.\n\
    Exit codes: 0 done, whatever the page says; 2 the request or the document is wrong."
)]
struct Cli {
    #[command(flatten)]
    io: Io,
    /// Plain text, for the terminal, instead of HTML
    #[arg(long)]
    text: bool,
    /// Hold the document against this specification, as a certificate; the exit code is 0 whatever its verdicts
    #[arg(long, value_name = "FILE")]
    spec: Option<PathBuf>,
}

fn main() -> ExitCode {
    let cli = manual::parse::<Cli>();
    pipe::finish(PROGRAM, run(&cli))
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    cli.io.apart(cli.spec.as_deref())?;
    let mut options = Options::default();
    if let Some(file) = &cli.spec {
        let input = Input::read(Some(file))?;
        options.spec = Some(Spec::parse(&input.text).map_err(|error| input.locate(error))?);
    }
    let (input, mut document) = Input::document(cli.io.file.as_deref(), |file| PROGRAM.ingest(file))?;
    options.document_sha256 = Some(input.sha256());
    if let Err(error) = beside::read(&mut document, cli.io.folder(), PROGRAM.takes) {
        pipe::say(&format!("report: {}; the page does without", input.locate(error)));
    }
    let page = report::run(&document, &options).map_err(|error| input.locate(error.into()))?;
    let render = if cli.text { text::render } else { html::render };
    pipe::write(cli.io.output.as_deref(), &render(&page))?;
    if !cli.io.quiet {
        pipe::say(&report::summary(&page));
    }
    Ok(())
}
