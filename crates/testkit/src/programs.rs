//! The programs under proof, run as they are shipped.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::Told;
use thiserror::Error;

/// Why a program gave no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// A file cannot be read or run, or a program is missing.
    #[error(transparent)]
    Common(#[from] common::Error),
    /// A program ended with an error.
    #[error("{program} on {document}: {words}; run it by itself to see more")]
    Program {
        /// Which.
        program: PathBuf,
        /// What it was given.
        document: PathBuf,
        /// Its last words.
        words: String,
    },
}

impl Told for Error {
    fn told(self) -> common::Error {
        match self {
            Error::Common(error) => error,
            other => common::Error::Request(other.to_string()),
        }
    }
}

impl Error {
    /// A file that cannot be `read`, `written` or `run`.
    pub fn file(path: impl Into<PathBuf>, action: &'static str, source: std::io::Error) -> Self {
        Error::Common(common::Error::file(path, action, source))
    }
}

/// Where the stages' programs are.
#[derive(Clone, Debug)]
pub struct Programs {
    folder: PathBuf,
}

impl Programs {
    /// In a folder; absent: beside the running program.
    pub fn find(folder: Option<&Path>) -> Result<Self, Error> {
        let folder = match folder {
            Some(folder) => folder.to_path_buf(),
            None => {
                let own =
                    std::env::current_exe().map_err(|e| Error::file("the running program", "read", e))?;
                own.parent().map(Path::to_path_buf).unwrap_or_default()
            }
        };
        Ok(Self { folder })
    }

    /// A program of that name; refused where it is not there.
    pub fn program(&self, name: &str) -> Result<PathBuf, Error> {
        let path = self.folder.join(name);
        if path.is_file() {
            return Ok(path);
        }
        Err(Error::Common(common::Error::Request(format!(
            "no program {name} in {}; build it with cargo build --release, or say where it is with --programs",
            self.folder.display()
        ))))
    }

    /// Runs a stage on a document; the answer stands in `output`, whole or not at all.
    pub fn run(&self, name: &str, arguments: &[&str], document: &Path, output: &Path) -> Result<(), Error> {
        let program = self.program(name)?;
        let run = command(&program, arguments, document, output)
            .output()
            .map_err(|source| Error::file(&program, "read", source))?;
        finished(&run, program, document)
    }

    /// The same, stopped after a time.
    pub fn run_within(
        &self,
        limit: Duration,
        name: &str,
        arguments: &[&str],
        document: &Path,
        output: &Path,
    ) -> Result<(), Error> {
        let program = self.program(name)?;
        let failed = |source| Error::file(&program, "run", source);
        let mut run = command(&program, arguments, document, output)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let begun = Instant::now();
        while run.try_wait().map_err(failed)?.is_none() {
            if begun.elapsed() > limit {
                run.kill().map_err(failed)?;
                run.wait().map_err(failed)?;
                let words = format!("stopped after {} s", limit.as_secs());
                return Err(Error::Program { program, document: document.into(), words });
            }
            thread::sleep(Duration::from_millis(20));
        }
        let run = run.wait_with_output().map_err(failed)?;
        finished(&run, program, document)
    }
}

fn command(program: &Path, arguments: &[&str], document: &Path, output: &Path) -> Command {
    let mut command = Command::new(program);
    command
        .args(arguments)
        .arg("-q")
        .arg(document)
        .arg("-o")
        .arg(output)
        // Cases run side by side; the answer does not depend on the number of threads.
        .env("RAYON_NUM_THREADS", "1")
        .stdin(Stdio::null());
    command
}

fn finished(run: &Output, program: PathBuf, document: &Path) -> Result<(), Error> {
    if run.status.success() {
        return Ok(());
    }
    let words = String::from_utf8_lossy(&run.stderr).trim().to_string();
    Err(Error::Program { program, document: document.into(), words })
}
