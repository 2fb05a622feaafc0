//! The stages run on real recordings, each as a program of its own.

use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use tempfile::TempDir;

use super::series::Series;
use crate::Error;
use testkit::programs::Programs;

/// What a stage answered: its document, or the sentence by which it refused.
pub type Answer = Result<Value, String>;

/// The programs, the recordings, and a place for documents on their way.
#[derive(Debug)]
pub struct Stages {
    programs: Programs,
    data: PathBuf,
    place: TempDir,
    documents: AtomicUsize,
}

impl Stages {
    /// Programs with the folder of the recordings.
    pub fn new(programs: Programs, data: &Path) -> Result<Self, Error> {
        let place =
            tempfile::tempdir().map_err(|source| Error::file(std::env::temp_dir(), "written", source))?;
        Ok(Self { programs, data: data.into(), place, documents: AtomicUsize::new(0) })
    }

    /// Files of one series through `ingest`; `mapping` is the text of one. Refusals are errors: the files are
    /// known to be readable.
    pub fn ingest(&self, files: &[PathBuf], mapping: Option<&str>) -> Result<Series, Error> {
        self.ingest_with(files, mapping, &[])
    }

    /// The same with further arguments.
    pub fn ingest_with(
        &self,
        files: &[PathBuf],
        mapping: Option<&str>,
        arguments: &[&str],
    ) -> Result<Series, Error> {
        let [first, others @ ..] = files else {
            return Err(request(format!("no files for `ingest` in {}", self.data.display())));
        };
        let mut all: Vec<String> = vec!["--inline".into()];
        all.extend(arguments.iter().map(|argument| argument.to_string()));
        if let Some(text) = mapping {
            let path = self.write("map", text)?;
            all.extend(["--map".to_string(), path.display().to_string()]);
        }
        all.extend(others.iter().map(|path| path.display().to_string()));
        let output = self.path("ingested");
        let arguments: Vec<&str> = all.iter().map(String::as_str).collect();
        self.programs.run("ingest", &arguments, first, &output)?;
        Series::of(&read(&output)?)
            .ok_or_else(|| request(format!("`ingest` gave no columns of {}", first.display())))
    }

    /// A file of the recordings; refused where it is missing.
    pub fn file(&self, name: &str) -> Result<PathBuf, Error> {
        let path = self.data.join(name);
        if path.is_file() {
            return Ok(path);
        }
        Err(request(format!("{}: no such file; the set must be whole", path.display())))
    }

    /// The files of a folder of the recordings that end in `end`, by name.
    pub fn files(&self, folder: &str, end: &str) -> Result<Vec<PathBuf>, Error> {
        let folder = self.data.join(folder);
        let entries = fs::read_dir(&folder).map_err(|source| Error::file(&folder, "read", source))?;
        let mut files: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.to_string_lossy().ends_with(end))
            .collect();
        files.sort();
        Ok(files)
    }

    /// A stage on a document of these recordings, with calibration and instrument beside them as `given` has
    /// it.
    pub fn stage(
        &self,
        program: &str,
        arguments: &[&str],
        recordings: Vec<Value>,
        given: &Value,
    ) -> Result<Answer, Error> {
        let document = self.document(recordings, given)?;
        let output = self.path("answer");
        match self.programs.run(program, arguments, &document, &output) {
            Ok(()) => Ok(Ok(read(&output)?)),
            Err(Error::Program { words, .. }) => {
                let own = format!("{}, ", document.display());
                Ok(Err(words.replace(&own, "").replace(&document.display().to_string(), "the document")))
            }
            Err(error) => Err(error),
        }
    }

    /// The same, held against the readings of another document.
    pub fn against(&self, recordings: Vec<Value>, simulated: Vec<Value>) -> Result<Answer, Error> {
        let simulated = self.document(simulated, &json!({}))?;
        self.stage("diagnose", &["--against", &simulated.display().to_string()], recordings, &json!({}))
    }

    fn document(&self, recordings: Vec<Value>, given: &Value) -> Result<PathBuf, Error> {
        let mut document = json!({"fluxcal": 1, "recordings": recordings});
        for (key, value) in given.as_object().into_iter().flatten() {
            document[key] = value.clone();
        }
        self.write("document", &document.to_string())
    }

    fn path(&self, what: &str) -> PathBuf {
        let number = self.documents.fetch_add(1, Ordering::Relaxed);
        self.place.path().join(format!("{what}-{number}.json"))
    }

    fn write(&self, what: &str, text: &str) -> Result<PathBuf, Error> {
        let path = self.path(what);
        fs::write(&path, text).map_err(|source| Error::file(&path, "written", source))?;
        Ok(path)
    }
}

fn read(path: &Path) -> Result<Value, Error> {
    let text = fs::read_to_string(path).map_err(|source| Error::file(path, "read", source))?;
    Ok(common::parse(&text)?)
}

fn request(words: String) -> Error {
    Error::Common(common::Error::Request(words))
}
