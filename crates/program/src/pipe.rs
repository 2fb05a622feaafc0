//! Reading and writing that all stages share, with good manners in pipes.
//!
//! Standard output carries the document or nothing; people's words go to standard error. The exit
//! code is 0 (done), 1 (the data do not allow the answer) or 2 (the request or the document is wrong).

use clap::Args;
use files::Unfinished;
use sha2::{Digest, Sha256};
use std::fs;
use std::io::{self, ErrorKind, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};
use std::process;

use common::{Document, Error, ExitCode, HistoryEntry, line_of};

use crate::outline::outline;
use crate::{apart, beside, readings};

/// Arguments for the document's way in and out, the same in every stage.
#[derive(Args, Clone, Debug, Default)]
pub struct Io {
    /// The document to read; absent or `-`: standard input
    #[arg(value_name = "DOCUMENT")]
    pub file: Option<PathBuf>,
    /// Write to this file instead of standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Let -o name the document that is read: it is replaced when all is done
    #[arg(long, requires = "output")]
    pub in_place: bool,
    /// Say nothing on standard error
    #[arg(short, long)]
    pub quiet: bool,
}

impl Io {
    /// The output is not what is read, unless that is asked for; `others` is what is read besides, which may never be it.
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

    /// Reads a document. Readings as a file (CSV, IAGA-2002, CDF, …) are answered with the command that reads them: `command` makes it of
    /// the file's name.
    ///
    /// # Errors
    ///
    /// What is no document, with file and line.
    pub fn document(
        file: Option<&Path>,
        command: impl Fn(&str) -> String,
    ) -> Result<(Self, Document), Error> {
        let (bytes, source_name) = bytes(file)?;
        let named = file.filter(|path| *path != Path::new("-")).map(|path| path.display().to_string());
        let readings = readings::told(&bytes).map(|found| Error::Syntax {
            message: format!(
                "{source_name}: found {found}; expected a fluxcal document. To read it:\n  {}",
                command(named.as_deref().unwrap_or("FILE"))
            ),
        });
        if let Some(error) = readings {
            return Err(error);
        }
        let input = Self::of(bytes, source_name)?;
        let document = Document::parse(&input.text).map_err(|error| input.locate(error))?;
        Ok((input, document))
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
        Sha256::digest(self.text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The same with no more of the text than says on which line something stands.
    pub fn outlined(self) -> Self {
        Self { text: outline(self.text), ..self }
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
    match file.filter(|path| *path != Path::new("-")) {
        Some(path) => {
            let bytes = fs::read(path).map_err(|source| unreadable(path, source))?;
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
            read.map_err(|source| unreadable(Path::new("standard input"), source))?;
            Ok((bytes, "standard input".to_string()))
        }
    }
}

fn unreadable(path: &Path, source: io::Error) -> Error {
    Error::File { path: path.into(), action: "read", source }
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
pub fn stage<E>(
    program: Program,
    io: &Io,
    arguments: Vec<String>,
    run: impl FnOnce(Document) -> Result<Document, E>,
    words: impl FnOnce(&Document) -> String,
) -> Result<(), Error>
where
    Error: From<E>,
{
    stage_or(program, io, arguments, |file| program.ingest(file), run, words)
}

/// As [`stage`], where another command than `ingest` reads a file of readings that was given as the document: `command` makes it of the
/// file's name.
pub fn stage_or<E>(
    program: Program,
    io: &Io,
    arguments: Vec<String>,
    command: impl Fn(&str) -> String,
    run: impl FnOnce(Document) -> Result<Document, E>,
    words: impl FnOnce(&Document) -> String,
) -> Result<(), Error>
where
    Error: From<E>,
{
    let (input, mut document) = Input::document(io.file.as_deref(), command)?;
    let (input_sha256, input) = (input.sha256(), input.outlined());
    let located = |error: Error| input.locate(error);
    let tables = document.recordings.iter().filter_map(|recording| recording.table.as_ref());
    let tables: Vec<PathBuf> = tables.map(|table| io.folder().join(table)).collect();
    io.apart(tables.iter().map(PathBuf::as_path))?;
    beside::read(&mut document, io.folder(), program.takes).map_err(located)?;
    let mut document = run(document).map_err(Error::from).map_err(located)?;
    let said = (!io.quiet).then(|| words(&document));
    beside::put_back(&mut document);
    document.history.push(HistoryEntry {
        stage: program.name.into(),
        version: program.version.into(),
        arguments,
        input_sha256: Some(input_sha256),
        extra: Default::default(),
    });
    write(io.output.as_deref(), &document.to_text()?)?;
    said.iter().for_each(|words| say(words));
    Ok(())
}

/// Writes text to a file (beside it first, then renamed) or to standard output.
/// A reader that has gone is no error.
pub fn write(output: Option<&Path>, text: &str) -> Result<(), Error> {
    let mut sink = Sink::open(output)?;
    sink.write(text)?;
    sink.finish()
}

/// Where text goes, piece by piece: standard output, a file that appears whole when all is written, or a device.
pub struct Sink {
    /// As it is named in errors.
    path: PathBuf,
    target: Target,
}

enum Target {
    Stdout,
    File(fs::File, Unfinished),
}

impl Sink {
    /// Opens a file, or standard output where none is given.
    pub fn open(output: Option<&Path>) -> Result<Self, Error> {
        let Some(path) = output else {
            return Ok(Self { path: "standard output".into(), target: Target::Stdout });
        };
        let failed = |source| Error::File { path: path.into(), action: "written", source };
        let (file, unfinished) = files::create(path).map_err(failed)?;
        Ok(Self { path: path.into(), target: Target::File(file, unfinished) })
    }

    /// Writes a piece. False: the reader of standard output has gone, which is no error, and no more is wanted.
    pub fn write(&mut self, text: &str) -> Result<bool, Error> {
        let result = match &mut self.target {
            Target::Stdout => {
                let mut stdout = io::stdout().lock();
                stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush())
            }
            Target::File(file, _) => file.write_all(text.as_bytes()),
        };
        match (&self.target, result) {
            (_, Ok(())) => Ok(true),
            (Target::Stdout, Err(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
            (_, Err(source)) => Err(Error::File { path: self.path.clone(), action: "written", source }),
        }
    }

    /// Gives the file its name.
    pub fn finish(self) -> Result<(), Error> {
        match self.target {
            Target::Stdout => Ok(()),
            Target::File(_, unfinished) => unfinished.finish().map_err(|source| Error::File {
                path: self.path,
                action: "written",
                source,
            }),
        }
    }
}

/// People's words, to standard error. A closed standard error is no reason to fail.
pub fn say(words: &str) {
    let _ = writeln!(io::stderr(), "{}", words.trim_end());
}

/// The end of `main`: the error as one sentence to standard error, and the exit code that it means.
pub fn finish<E>(program: Program, result: Result<(), E>) -> process::ExitCode
where
    E: AsRef<dyn std::error::Error + Send + Sync>,
{
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
        let error =
            Input::document(Some(&path), |file| program.ingest(file)).err().expect("refused").to_string();
        let shown = path.display();
        let expected = format!(
            "{shown}: found lines of values (CSV); expected a fluxcal document. To read it:\n  ingest '{shown}' | diffmag"
        );
        assert_eq!(error, expected);
        fs::write(&path, "{\"fluxcal\": 1}").expect("written");
        assert!(Input::document(Some(&path), |file| program.ingest(file)).is_ok());
    }

    #[test]
    fn a_file_is_whole_or_not_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("out.json");
        write(Some(&path), "{}\n").expect("written");
        assert_eq!(fs::read_to_string(&path).expect("there"), "{}\n");
        let lost = folder.path().join("absent").join("out.json");
        let error = write(Some(&lost), "{}").expect_err("no such folder");
        assert!(error.to_string().contains("cannot be written"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 1);
    }
}
