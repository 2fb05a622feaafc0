//! Truths are sealed before anything is diagnosed, and opened after.

use rayon::prelude::*;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::Error;
use crate::case::{Case, Truth};
use crate::programs::Programs;

/// A folder of documents, sealed truths and answers.
#[derive(Clone, Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// A folder that is made where it is not there.
    pub fn at(path: &Path) -> Result<Self, Error> {
        for part in ["documents", "truths"] {
            let path = path.join(part);
            fs::create_dir_all(&path).map_err(|source| Error::file(&path, "written", source))?;
        }
        Ok(Self(path.into()))
    }

    /// The document of a case.
    pub fn document(&self, case: &str) -> PathBuf {
        self.0.join("documents").join(format!("{case}.json"))
    }

    fn truth(&self, case: &str) -> PathBuf {
        self.0.join("truths").join(format!("{case}.json"))
    }

    fn seals(&self) -> PathBuf {
        self.0.join("seals.txt")
    }

    /// Writes documents and truths, and stores the digests of the truths.
    pub fn seal(&self, cases: &[Case]) -> Result<(), Error> {
        let mut seals = self.stored().unwrap_or_default();
        for Case { document, truth } in cases {
            write(&self.document(&truth.case), &document.to_string())?;
            let text = serde_json::to_string_pretty(truth).map_err(|source| {
                Error::file(self.truth(&truth.case), "written", std::io::Error::other(source))
            })?;
            write(&self.truth(&truth.case), &text)?;
            seals.insert(truth.case.clone(), digest(text.as_bytes()));
        }
        let lines: Vec<String> = seals.iter().map(|(case, seal)| format!("{seal}  {case}\n")).collect();
        write(&self.seals(), &lines.concat())
    }

    /// The stored digests by case.
    pub fn stored(&self) -> Result<BTreeMap<String, String>, Error> {
        let text = read(&self.seals())?;
        let pair =
            |line: &str| line.split_once("  ").map(|(seal, case)| (case.to_string(), seal.to_string()));
        Ok(text.lines().filter_map(pair).collect())
    }

    /// The digest of all seals together.
    pub fn seal_of_all(&self) -> Result<String, Error> {
        Ok(digest(read(&self.seals())?.as_bytes()))
    }

    /// Runs diagnose on every document, those apart that this very program has answered. Gives the folder of the answers.
    pub fn diagnose(&self, programs: &Programs) -> Result<PathBuf, Error> {
        self.answer("diagnose", &[], programs)
    }

    /// The folder of a program's answers, which bears its digest.
    pub fn answers(&self, name: &str, programs: &Programs) -> Result<PathBuf, Error> {
        let program = programs.program(name)?;
        let bytes = fs::read(&program).map_err(|source| Error::file(&program, "read", source))?;
        let answers = self.0.join(format!("answers-{}", &digest(&bytes)[..12]));
        fs::create_dir_all(&answers).map_err(|source| Error::file(&answers, "written", source))?;
        Ok(answers)
    }

    /// Runs diagnose on one document, unless this very program has answered it, for no longer than a limit. Gives the seconds it took.
    pub fn answer_within(
        &self,
        limit: Duration,
        case: &str,
        answers: &Path,
        programs: &Programs,
    ) -> Result<f64, Error> {
        let (document, answer) = (self.document(case), answers.join(format!("{case}.json")));
        let taken = answers.join(format!("{case}.seconds"));
        if answered(&document, &answer)? {
            return Ok(read(&taken).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::NAN));
        }
        let begun = Instant::now();
        programs.run_within(limit, "diagnose", &document, &answer)?;
        let seconds = begun.elapsed().as_secs_f64();
        write(&taken, &format!("{seconds:.3}"))?;
        Ok(seconds)
    }

    /// The same as [`Self::diagnose`] with another program.
    pub fn answer(&self, name: &str, arguments: &[&str], programs: &Programs) -> Result<PathBuf, Error> {
        let answers = self.answers(name, programs)?;
        let cases: Vec<String> = self.stored()?.into_keys().collect();
        cases.par_iter().try_for_each(|case| {
            let (document, answer) = (self.document(case), answers.join(format!("{case}.json")));
            if answered(&document, &answer)? {
                return Ok(());
            }
            programs.run(name, arguments, &document, &answer)
        })?;
        Ok(answers)
    }

    /// Opens a truth; refused where it is not the one that was sealed.
    pub fn open(&self, case: &str, sealed: &str) -> Result<Truth, Error> {
        let path = self.truth(case);
        let text = read(&path)?;
        let found = digest(text.as_bytes());
        if found != sealed {
            return Err(Error::Seal { path, found, sealed: sealed.into() });
        }
        serde_json::from_str(&text).map_err(|source| Error::file(path, "read", std::io::Error::other(source)))
    }
}

/// Whether an answer is one to this document: its history has the document's digest.
fn answered(document: &Path, answer: &Path) -> Result<bool, Error> {
    if !answer.is_file() {
        return Ok(false);
    }
    let asked = digest(read(document)?.as_bytes());
    let answer: Value = parsed(answer)?;
    let history = answer["history"].as_array();
    Ok(history.is_some_and(|entries| entries.iter().any(|entry| entry["input_sha256"] == *asked)))
}

/// SHA-256 in hexadecimal.
pub fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The JSON of a file.
pub fn parsed(path: &Path) -> Result<Value, Error> {
    serde_json::from_str(&read(path)?)
        .map_err(|source| Error::file(path, "read", std::io::Error::other(source)))
}

fn read(path: &Path) -> Result<String, Error> {
    fs::read_to_string(path).map_err(|source| Error::file(path, "read", source))
}

fn write(path: &Path, text: &str) -> Result<(), Error> {
    Ok(program::pipe::write(Some(path), text)?)
}
