//! `stream` and `merge`: long series in one pass, and statistics of their pieces that are joined later.

use clap::Args;
use common::{Document, Error};
use partial::{Partial, Series};
use rayon::prelude::*;
use std::fs::File;
use std::io::{self, BufRead, BufReader, IsTerminal};
use std::path::{Path, PathBuf};

use crate::pipe::{self, Input, Program};
use crate::{apart, progress};

/// As messages call it.
const STANDARD_INPUT: &str = "standard input";

/// Files of a series.
#[derive(Args, Clone, Debug)]
pub struct Stream {
    /// Pieces in any order: .csv, .ndjson, .parquet, or .json, a document; absent or `-`: CSV, NDJSON or a
    /// document on standard input
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    out: Out,
}

/// Statistics of pieces.
#[derive(Args, Clone, Debug)]
pub struct Merge {
    /// What `stream --partial` and `merge --partial` wrote, one piece a line; absent or `-`: standard input
    files: Vec<PathBuf>,
    #[command(flatten)]
    out: Out,
}

#[derive(Args, Clone, Debug)]
struct Out {
    /// Write the statistics in one line, to be merged with those of other pieces, in place of the answer
    #[arg(long)]
    partial: bool,
    /// Write to this file; absent or `-`: standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Say nothing on standard error
    #[arg(short, long)]
    quiet: bool,
}

/// A document that states what is known beside the statistics.
#[derive(Args, Clone, Debug)]
pub struct Stated {
    /// Document that states what is known of the instrument; the calibration is added to it, its recordings are not read
    #[arg(long, value_name = "DOCUMENT", conflicts_with = "partial")]
    document: Option<PathBuf>,
}

impl Stated {
    /// Does what answers from statistics, with the document that is stated, by the answer into a document.
    ///
    /// # Errors
    ///
    /// A document that cannot be read, and those of the answer.
    pub fn answered<P>(
        &self,
        program: Program,
        arguments: Vec<String>,
        answer: impl Fn(&P, Document) -> Result<Document, Error>,
        words: &dyn Fn(&Document) -> String,
        run: impl FnOnce(&Answer<'_, P>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let document = self.document.as_deref();
        let stream = |file: &str| format!("{} stream {file}", program.name);
        let stated = document.map(|file| Input::document(Some(file), stream)).transpose()?;
        let of = |joined: &P| {
            let (input, document) = match &stated {
                Some((input, document)) => (Some(input), document.clone()),
                None => (None, Document { fluxcal: common::FORMAT_VERSION, ..Document::default() }),
            };
            let document = answer(joined, document).map_err(|error| match input {
                Some(input) => input.locate(error),
                None => error,
            })?;
            Ok((document, input.map(Input::sha256)))
        };
        run(&Answer { program, document, arguments, of: &of, words })
    }
}

/// The document of an answer, and the SHA-256 of the one that was read for it.
pub type Answered = (Document, Option<String>);

/// How a program answers from statistics.
pub struct Answer<'a, P> {
    /// The program.
    pub program: Program,
    /// What is read beside the pieces.
    pub document: Option<&'a Path>,
    /// What the history records of the request beside the subcommand.
    pub arguments: Vec<String>,
    /// The answer.
    pub of: &'a dyn Fn(&P) -> Result<Answered, Error>,
    /// What is said of it.
    pub words: &'a dyn Fn(&Document) -> String,
}

impl Stream {
    /// Takes the files and answers, or writes the statistics.
    ///
    /// # Errors
    ///
    /// What cannot be read, taken, joined or answered.
    pub fn run<S: Series>(&self, series: &S, answer: &Answer<'_, S::Partial>) -> Result<(), Error> {
        let files = files(&self.files)?;
        let take = || {
            progress::steps(files.len());
            let pieces = files.par_iter().map(|file| {
                let piece = match pipe::named(Some(file)) {
                    Some(file) => partial::take(series, file),
                    None => partial::take_from(series, io::stdin(), STANDARD_INPUT),
                };
                progress::step();
                piece
            });
            partial::merge(pieces.collect::<Result<_, Error>>()?).map_err(Into::into)
        };
        self.out.write("stream", &files, take, answer)
    }
}

impl Merge {
    /// Joins the pieces and answers, or writes the statistics.
    ///
    /// # Errors
    ///
    /// What cannot be read, joined or answered.
    pub fn run<P: Partial>(&self, answer: &Answer<'_, P>) -> Result<(), Error> {
        let files = files(&self.files)?;
        let join = || {
            let sources = files.iter().map(|file| open(file)).collect::<Result<Vec<_>, Error>>()?;
            partial::merge_lines(sources)
        };
        self.out.write("merge", &files, join, answer)
    }
}

/// The files that are read, `-` where none is named.
fn files(named: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let files = if named.is_empty() { vec!["-".into()] } else { named.to_vec() };
    match files.iter().filter(|file| pipe::named(Some(file)).is_none()).count() {
        0 => Ok(files),
        1 if io::stdin().is_terminal() => Err(Error::Request(
            "no pieces: standard input is a terminal. Give files, or put another program before this one in a pipe; \
             --help shows an example"
                .into(),
        )),
        1 => Ok(files),
        _ => Err(Error::Request("- twice; standard input can be read once".into())),
    }
}

/// A file, or standard input, as messages call it and as it is read.
fn open(file: &Path) -> Result<(String, Box<dyn BufRead>), Error> {
    let Some(file) = pipe::named(Some(file)) else {
        return Ok((STANDARD_INPUT.into(), Box::new(io::stdin().lock())));
    };
    let opened = File::open(file).map_err(|source| Error::file(file, "read", source))?;
    Ok((file.display().to_string(), Box::new(BufReader::new(opened))))
}

impl Out {
    fn write<P: Partial>(
        &self,
        command: &str,
        files: &[PathBuf],
        pieces: impl FnOnce() -> Result<P, Error>,
        answer: &Answer<'_, P>,
    ) -> Result<(), Error> {
        let inputs = files.iter().map(PathBuf::as_path).chain(answer.document);
        apart::check(self.output.as_deref(), inputs)?;
        let joined = pieces()?;
        if self.partial {
            return pipe::write(self.output.as_deref(), &(partial::to_line(&joined) + "\n"));
        }
        progress::tell("fitting");
        let (mut document, input_sha256) = (answer.of)(&joined)?;
        let arguments = [&[command.to_string()], answer.arguments.as_slice()].concat();
        document.history.push(answer.program.entry(arguments, input_sha256));
        pipe::write(self.output.as_deref(), &document.to_text()?)?;
        if !self.quiet {
            pipe::say(&(answer.words)(&document));
            pipe::say_undetermined(answer.program, &document, &[]);
        }
        Ok(())
    }
}
