//! A folder of documents and their answers.

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use testkit::programs::Programs;

use crate::Error;

/// What programs are told besides, by the case.
pub type Arguments = BTreeMap<String, Vec<String>>;

/// Documents in `documents`, the answers of each build of a program in a folder that bears the program's
/// digest.
#[derive(Clone, Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// A folder that is made where it is not there.
    pub fn at(path: &Path) -> Result<Self, Error> {
        let documents = path.join("documents");
        fs::create_dir_all(&documents).map_err(|source| Error::file(&documents, "written", source))?;
        Ok(Self(path.into()))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// The document of a case.
    pub fn document(&self, case: &str) -> PathBuf {
        self.0.join("documents").join(format!("{case}.json"))
    }

    /// Writes the document of a case.
    pub fn write(&self, case: &str, document: &Value) -> Result<(), Error> {
        write(&self.document(case), &document.to_string())
    }

    /// Writes what programs are told for some cases besides.
    pub fn write_arguments(&self, arguments: &Arguments) -> Result<(), Error> {
        write(&self.of_arguments(), &json!(arguments).to_string())
    }

    /// What programs are told for some cases besides.
    fn arguments(&self) -> Result<Arguments, Error> {
        let path = self.of_arguments();
        if path.is_file() { value(&path) } else { Ok(Arguments::new()) }
    }

    fn of_arguments(&self) -> PathBuf {
        self.0.join("arguments.json")
    }

    /// The folder of a program's answers with some arguments.
    pub fn answers(&self, name: &str, arguments: &[String], programs: &Programs) -> Result<PathBuf, Error> {
        let program = programs.program(name)?;
        let mut bytes = fs::read(&program).map_err(|source| Error::file(&program, "read", source))?;
        bytes.extend(arguments.concat().into_bytes());
        let answers = self.0.join(format!("answers-{}", &digest(&bytes)[..12]));
        fs::create_dir_all(&answers).map_err(|source| Error::file(&answers, "written", source))?;
        Ok(answers)
    }

    /// All folders of answers.
    pub fn answers_there(&self) -> Result<Vec<PathBuf>, Error> {
        let entries = fs::read_dir(&self.0).map_err(|source| Error::file(&self.0, "read", source))?;
        let named = |path: &PathBuf| {
            path.is_dir()
                && path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("answers-"))
        };
        let mut all: Vec<PathBuf> =
            entries.filter_map(|entry| Some(entry.ok()?.path())).filter(named).collect();
        all.sort();
        Ok(all)
    }

    /// Runs a program on the document of a case, unless it has answered it, for no longer than a limit. Gives
    /// the seconds it took.
    pub fn answer(&self, asked: &Asked<'_>, case: &str, answers: &Path) -> Result<f64, Error> {
        let (document, answer) = (self.document(case), answers.join(format!("{case}.json")));
        let taken = answers.join(format!("{case}.seconds"));
        if answered(&document, &answer)? {
            return Ok(read(&taken).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::NAN));
        }
        let begun = Instant::now();
        let arguments: Vec<&str> = asked.arguments.iter().map(String::as_str).collect();
        asked.programs.run_within(asked.limit, asked.name, &arguments, &document, &answer)?;
        let seconds = begun.elapsed().as_secs_f64();
        write(&taken, &format!("{seconds:.3}"))?;
        Ok(seconds)
    }

    /// The answers to some cases, side by side on all cores; a program that fails has given none, which is
    /// its answer. Gives their folder.
    pub fn answer_all<'c>(
        &self,
        asked: &Asked<'_>,
        cases: impl Iterator<Item = &'c String>,
    ) -> Result<PathBuf, Error> {
        let answers = self.answers(asked.name, asked.arguments, asked.programs)?;
        let besides = self.arguments()?;
        let cases: Vec<&String> = cases.collect();
        cases.par_iter().try_for_each(|case| {
            let besides = besides.get(*case).map_or(&[][..], Vec::as_slice);
            let arguments = [asked.arguments, besides].concat();
            match self.answer(&Asked { arguments: &arguments, ..*asked }, case, &answers) {
                Err(Error::Program { words, .. }) => {
                    let answer = answers.join(format!("{case}.json"));
                    write(&answer, &json!({"failed": words}).to_string())
                }
                other => other.map(|_| ()),
            }
        })?;
        Ok(answers)
    }
}

/// What is run on a document.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// The program.
    pub name: &'a str,
    /// What it is told.
    pub arguments: &'a [String],
    /// Where it is.
    pub programs: &'a Programs,
    /// How long it may take.
    pub limit: Duration,
}

impl<'a> Asked<'a> {
    /// diagnose as it stands, a quarter of an hour for each document.
    pub fn diagnose(programs: &'a Programs) -> Self {
        Self { name: "diagnose", arguments: &[], programs, limit: Duration::from_secs(900) }
    }
}

/// Whether an answer is one to this document: its history has the document's digest.
fn answered(document: &Path, answer: &Path) -> Result<bool, Error> {
    if !answer.is_file() {
        return Ok(false);
    }
    let asked = digest(read(document)?.as_bytes());
    let answer: Value = value(answer)?;
    let history = answer["history"].as_array();
    Ok(history.is_some_and(|entries| entries.iter().any(|entry| entry["input_sha256"] == *asked)))
}

/// SHA-256 in hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The JSON of a file.
pub fn value<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    serde_json::from_str(&read(path)?).map_err(|source| Error::file(path, "read", source.into()))
}

/// The text of a file.
pub fn read(path: &Path) -> Result<String, Error> {
    fs::read_to_string(path).map_err(|source| Error::file(path, "read", source))
}

/// Writes a file, whole or not at all.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    Ok(program::pipe::write(Some(path), text)?)
}
