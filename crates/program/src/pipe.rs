//! Reading and writing that all stages share, with good manners in pipes.
//!
//! Standard output carries the document or nothing; people's words go to standard error. The exit
//! code is 0 (done), 1 (the data do not allow the answer) or 2 (the request or the document is wrong).

use clap::Args;
use sha2::{Digest, Sha256};
use std::fs;
use std::io::{self, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};
use std::process;

use common::number::counted;
use common::{Document, Error, ExitCode, HistoryEntry, Recording, Undetermined, line_of};

use crate::outline::outline;
pub use crate::sink::{Sink, named, write};
use crate::{apart, beside, dropped, hexadecimal, keys, progress, readings};

/// Arguments for the document's way in and out, the same in every stage.
#[derive(Args, Clone, Debug, Default)]
pub struct Io {
    /// The document to read; absent or `-`: standard input
    #[arg(value_name = "DOCUMENT")]
    pub file: Option<PathBuf>,
    /// Write to this file; absent or `-`: standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Let -o name the document that is read: it is replaced when all is done
    #[arg(long, requires = "output")]
    pub in_place: bool,
    /// Say nothing on standard error
    #[arg(short, long)]
    pub quiet: bool,
}

/// The same for a stage that takes recordings.
#[derive(Args, Clone, Debug, Default)]
pub struct StageIo {
    #[command(flatten)]
    #[allow(missing_docs)]
    pub io: Io,
    /// Leave the readings that this program takes out of the document it writes; their SHA-256 stays
    #[arg(long)]
    pub drop_recordings: bool,
}

impl From<&Io> for StageIo {
    fn from(io: &Io) -> Self {
        StageIo { io: io.clone(), drop_recordings: false }
    }
}

impl Io {
    /// The output is not what is read, unless that is asked for; `others` is what is read besides, which may
    /// never be it.
    ///
    /// # Errors
    ///
    /// As [`apart::check`].
    pub fn apart<'a>(&'a self, others: impl IntoIterator<Item = &'a Path>) -> Result<(), Error> {
        let document = self.file.as_deref().filter(|_| !self.in_place);
        let inputs: Vec<&Path> = document.into_iter().chain(others).collect();
        apart::check(self.output.as_deref(), inputs)
    }

    /// The folder of the document: that of its file, else the present one.
    pub fn folder(&self) -> &Path {
        self.file.as_deref().and_then(Path::parent).unwrap_or(Path::new(""))
    }
}

/// What was read, with what is needed to speak of it.
pub struct Input {
    /// The text.
    pub text: String,
    /// The file's name, or `standard input`.
    pub source_name: String,
}

impl Input {
    /// Reads a file, or standard input where no file is given.
    pub fn read(file: Option<&Path>) -> Result<Self, Error> {
        let (bytes, source_name) = bytes(file)?;
        Self::of(bytes, source_name)
    }

    /// Reads a document. Readings as a file (CSV, IAGA-2002, CDF, …) are answered with the command that reads
    /// them: `command` makes it of the file's name.
    ///
    /// # Errors
    ///
    /// What is no document, with file and line.
    pub fn document(
        file: Option<&Path>,
        command: impl Fn(&str) -> String,
    ) -> Result<(Self, Document), Error> {
        let input = Self::of_document(file, command)?;
        let document = input.parsed()?;
        Ok((input, document))
    }

    /// As [`Self::document`], for a stage: with the digest of the text, and no more of the text than says on
    /// which line something stands.
    fn outlined(
        file: Option<&Path>,
        command: impl Fn(&str) -> String,
    ) -> Result<(Self, Document, String), Error> {
        let input = Self::of_document(file, command)?;
        let digest_and_outline = || (input.sha256(), outline(&input.text));
        let (document, (sha256, text)) = rayon::join(|| input.parsed(), digest_and_outline);
        Ok((Self { text, source_name: input.source_name.clone() }, document?, sha256))
    }

    /// The text of a document, and no file of readings.
    fn of_document(file: Option<&Path>, command: impl Fn(&str) -> String) -> Result<Self, Error> {
        let (bytes, source_name) = bytes(file)?;
        let Some(found) = readings::told(&bytes) else { return Self::of(bytes, source_name) };
        let file_name = named(file).map_or("FILE".into(), |path| path.display().to_string());
        let command = command(&file_name);
        let message =
            format!("{source_name}: found {found}; expected a fluxcal document. To read it:\n  {command}");
        Err(Error::Syntax { message })
    }

    fn parsed(&self) -> Result<Document, Error> {
        let document = Document::parse(&self.text).map_err(|error| self.locate(error))?;
        for (index, recording) in document.recordings.iter().enumerate() {
            let checked = dropped::check(recording, &format!("recordings[{index}]"));
            checked.map_err(|error| self.locate(error))?;
        }
        Ok(document)
    }

    fn of(bytes: Vec<u8>, source_name: String) -> Result<Self, Error> {
        let text = String::from_utf8(bytes).map_err(|error| Error::Syntax {
            message: format!(
                "{source_name}: byte {} is not UTF-8; expected JSON text, which is always UTF-8",
                error.utf8_error().valid_up_to()
            ),
        })?;
        Ok(Input { text, source_name })
    }

    /// SHA-256 of the text, in hexadecimal.
    pub fn sha256(&self) -> String {
        hexadecimal(&Sha256::digest(self.text.as_bytes()))
    }

    /// Adds file and line to an error that names a JSON path.
    pub fn locate(&self, error: Error) -> Error {
        let line = error.path().and_then(|path| line_of(&self.text, path));
        match (line, error) {
            (Some(line), error) => {
                Error::At { source_name: self.source_name.clone(), line, error: Box::new(error) }
            }
            (None, Error::Syntax { message }) => {
                Error::Syntax { message: format!("{}: {message}", self.source_name) }
            }
            (None, error) => error,
        }
    }
}

/// What is in a file or comes on standard input, and how messages name it.
fn bytes(file: Option<&Path>) -> Result<(Vec<u8>, String), Error> {
    match named(file) {
        Some(path) => {
            let bytes = fs::read(path).map_err(|source| Error::file(path, "read", source))?;
            Ok((bytes, path.display().to_string()))
        }
        None if io::stdin().is_terminal() => Err(Error::Request(
            "no document: standard input is a terminal. Give a file, or put this program behind \
             another in a pipe; --help shows an example"
                .into(),
        )),
        None => {
            let mut bytes = Vec::new();
            let read = io::stdin().read_to_end(&mut bytes);
            read.map_err(|source| Error::file("standard input", "read", source))?;
            Ok((bytes, "standard input".to_string()))
        }
    }
}

/// A stage's name and version, as its history entry states them.
#[derive(Clone, Copy, Debug)]
pub struct Program {
    /// Name of the binary.
    pub name: &'static str,
    /// Its version.
    pub version: &'static str,
    /// The procedures whose recordings it takes: of those, tables beside the document are read.
    pub takes: &'static [&'static str],
}

impl Program {
    /// Its line of a document's history.
    pub fn entry(&self, arguments: Vec<String>, input_sha256: Option<String>) -> HistoryEntry {
        let (stage, version) = (self.name.into(), self.version.into());
        HistoryEntry { stage, version, arguments, input_sha256, extra: Default::default() }
    }

    /// The command that reads a file of readings for this program.
    pub fn ingest(&self, file: &str) -> String {
        format!("ingest {} | {}", quoted(file), self.name)
    }
}

/// A file's name as a shell takes it.
fn quoted(file: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "/._-+,:=@".contains(letter);
    if !file.is_empty() && file.chars().all(plain) {
        file.into()
    } else {
        format!("'{}'", file.replace('\'', "'\\''"))
    }
}

/// Runs a stage: document in, `run`, words to standard error, document out.
///
/// `arguments` is what the history records of the request. Nothing is written when anything fails.
pub fn stage(
    program: Program,
    stage: &StageIo,
    arguments: Vec<String>,
    run: impl FnOnce(Document) -> Result<Document, Error>,
    words: impl FnOnce(&Document) -> String,
) -> Result<(), Error> {
    stage_or(program, stage, arguments, |file| program.ingest(file), run, words)
}

/// As [`stage`], where another command than `ingest` reads a file of readings that was given as the document:
/// `command` makes it of the file's name.
pub fn stage_or(
    program: Program,
    stage: &StageIo,
    mut arguments: Vec<String>,
    command: impl Fn(&str) -> String,
    run: impl FnOnce(Document) -> Result<Document, Error>,
    words: impl FnOnce(&Document) -> String,
) -> Result<(), Error> {
    let StageIo { io, drop_recordings } = stage;
    let (input, mut document, input_sha256) = Input::outlined(io.file.as_deref(), command)?;
    if !io.quiet {
        keys::mistaken(&input.text).iter().for_each(|line| say(&format!("{}: {line}", program.name)));
    }
    let located = |error: Error| input.locate(error);
    let before = document.undetermined.clone();
    let tables = document.recordings.iter().filter_map(|recording| recording.table.as_ref());
    let tables: Vec<PathBuf> = tables.map(|table| io.folder().join(table)).collect();
    io.apart(tables.iter().map(PathBuf::as_path))?;
    beside::read(&mut document, io.folder(), program.takes).map_err(located)?;
    let rows = document.recordings.iter().map(Recording::rows).sum();
    let recordings = counted(document.recordings.len(), "recording");
    progress::tell(&format!("{} of {recordings}", counted(rows, "row")));
    let mut document = run(document).map_err(located)?;
    let said = (!io.quiet).then(|| words(&document));
    beside::put_back(&mut document);
    if *drop_recordings {
        dropped::drop(&mut document, program.takes);
        arguments.push("--drop-recordings".into());
    }
    document.history.push(program.entry(arguments, Some(input_sha256)));
    write(io.output.as_deref(), &document.to_text()?)?;
    if let Some(words) = said {
        say(&words);
        say_undetermined(program, &document, &before);
    }
    Ok(())
}

/// One line on what a document does not determine that it had not `before`.
pub(crate) fn say_undetermined(program: Program, document: &Document, before: &[Undetermined]) {
    const SHOWN: usize = 3;
    let new = document.undetermined.iter().filter(|one| !before.contains(one));
    let mut told: Vec<String> = new.map(|one| format!("{} ({})", one.path, one.reason)).collect();
    if let Some(more) = told.len().checked_sub(SHOWN).filter(|more| *more > 0) {
        told.truncate(SHOWN);
        told.push(format!("{more} more"));
    }
    if !told.is_empty() {
        say(&format!("{}: undetermined, null in the document: {}", program.name, told.join("; ")));
    }
}

/// People's words, to standard error. A closed standard error is no reason to fail.
pub fn say(words: &str) {
    progress::end();
    let _ = writeln!(io::stderr(), "{}", words.trim_end());
}

/// The end of `main`: the error as one sentence to standard error, and the exit code that it means.
pub fn finish<E>(program: Program, result: Result<(), E>) -> process::ExitCode
where
    E: AsRef<dyn std::error::Error + Send + Sync>,
{
    progress::end();
    let Err(error) = result else { return process::ExitCode::SUCCESS };
    let error: &(dyn std::error::Error + Send + Sync) = error.as_ref();
    say(&format!("{}: {error}", program.name));
    let code = error.downcast_ref::<Error>().map_or(ExitCode::Refused, Error::exit_code);
    process::ExitCode::from(code as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_are_answered_with_the_command_that_reads_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a day.csv");
        fs::write(&path, "time,x_nT\n2025-03-14T00:00:00Z,20900.5\n").expect("written");
        let program = Program { name: "diffmag", version: "1", takes: &[] };
        let error = Input::document(Some(&path), |file| program.ingest(file)).err().expect("refused");
        let shown = path.display();
        let expected = format!(
            "{shown}: found lines of values (CSV); expected a fluxcal document. To read it:\n  ingest '{shown}' | diffmag"
        );
        assert_eq!(error.to_string(), expected);
    }
}
